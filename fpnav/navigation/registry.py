"""The policies there are: name -> what makes one of a map. A new policy is one line here."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import cast

from fpnav.errors import UsageError
from fpnav.navigation.base import Policy, Task
from fpnav.params import Tables
from fpnav.store.maps import BuiltMap
from fpnav.systems.base import System

Maker = Callable[[System, BuiltMap, Task, Tables], Policy]
"""A fresh policy for a task on a map; the tables hold the policy's own parameter block."""

POLICIES: dict[str, str] = {
    "place-action": "fpnav.navigation.policy:place_action",
    "wall-following": "fpnav.navigation.walls:wall_following",
}

BLOCKS = ("navigate", "walls")
"""Parameter blocks of policies."""


def policy_maker(name: str) -> Maker:
    """What makes the named policy; imported on first use.

    Raises
    ------
    UsageError
        No policy has that name.
    """
    if name not in POLICIES:
        raise UsageError(f"no policy {name!r}; known: {', '.join(POLICIES)}")
    module, _, attribute = POLICIES[name].partition(":")
    return cast("Maker", getattr(importlib.import_module(module), attribute))
