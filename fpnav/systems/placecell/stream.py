"""Short-term state of a stream of signatures: what the merging neurons still hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fpnav.systems.placecell.neurons import Views
from fpnav.systems.placecell.params import PlacecellParams
from fpnav.systems.placecell.stm import Held, explore, largest, nothing
from fpnav.values import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """What a recall hands to the next.

    ``version`` : state of the memory it belongs to; ``held`` the counters; ``recent`` the last
    panoramas (window); ``places`` known and signatures ``since`` one was added.
    """

    version: int
    held: Held
    recent: tuple[FloatArray, ...] = ()
    places: int = 0
    since: int = 0
    begun: bool = False


def resumed(stream: Stream | None, version: int, neurons: int, qmax: int) -> Stream:
    """The stream where it fits the memory, with the neurons recruited since; else a new one."""
    if stream is None or stream.version != version:
        return Stream(version, nothing(neurons))
    return replace(stream, held=stream.held.grown(neurons, qmax))


def lasts(params: PlacecellParams) -> bool:
    """Whether anything outlives the panorama or image it was seen in."""
    return params.qmax > 1


def explorations(
    views: Views, params: PlacecellParams, *, begun: bool
) -> Iterator[tuple[Views, bool]]:
    """The explorations that a signature adds to a stream, and whether T fires at each.

    The whole panorama at once, which leaves the neurons as view after view would; each view where
    the formula is taken to the letter; the newest image, or all at the start, where images stream.
    """
    image = views.rows["image"]
    newest = 0 if begun else int(image.max(initial=0))
    for back in range(newest, -1, -1) if params.streaming else [-1]:
        part = views if back < 0 else views.take(np.flatnonzero(image == back))
        if params.stm != "literal" or len(part.rows) == 0:
            yield part, True
            continue
        for row in range(len(part.rows)):
            yield part.take(np.array([row])), row == 0


def remembered(stream: Stream, seen: FloatArray, *, fires: bool, params: PlacecellParams) -> Stream:
    """The stream after one more exploration, with its merging activity as ``held.m``."""
    if params.stm == "window":
        recent = (*stream.recent, seen)[-params.qmax :]
        held = Held(largest(recent, len(seen)), np.zeros(len(seen), np.int64))
        return replace(stream, held=held, recent=recent, begun=True)
    literal = params.stm == "literal"
    held = explore(stream.held, seen, fires=fires, qmax=params.qmax, literal=literal)
    return replace(stream, held=held, begun=True)
