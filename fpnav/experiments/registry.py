"""The papers that can be reproduced: name -> where its study lives. A new one is one line here."""

from __future__ import annotations

import importlib
from typing import cast

from fpnav.errors import UsageError
from fpnav.experiments.study import Study

STUDIES: dict[str, str] = {
    "tapus": "fpnav.experiments.tapus:STUDY",
    "giovannangeli": "fpnav.experiments.giovannangeli:STUDY",
    "kortenkamp": "fpnav.experiments.kortenkamp:STUDY",
}


def study_of(name: str) -> Study:
    """The named study; imported on first use.

    Raises
    ------
    UsageError
        No paper has that name.
    """
    if name not in STUDIES:
        raise UsageError(f"no paper {name!r}; known: {', '.join(STUDIES)}")
    module, _, attribute = STUDIES[name].partition(":")
    return cast("Study", getattr(importlib.import_module(module), attribute))
