"""Typed way to numba: compiled once per machine, never parallel (workers fork)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """The function as machine code, cached on disk; strict IEEE arithmetic."""
    return cast("Function", numba.njit(cache=True, nogil=True)(function))
