"""Abstracted scene representations: cues whose links strengthen and weaken from visit to visit.

"The connection that links each cell of the ASR to a cue representation can be strengthened or
weakened, depending on whether the cue is present or not during each traversal" (Kortenkamp and
Weymouth); how much is systems.md 3.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnav.sensing.cues import CUE, lengths
from fpnav.sensing.scene import CELL_PX, FACINGS, columns_of, compatible
from fpnav.systems.gateway.params import GatewayParams
from fpnav.values import FloatArray

LINK = np.dtype([*CUE.descr, ("weight", "<f4"), ("seen", "<i4"), ("known", "<i4")])
"""A cue with the weight of its link, the visits that saw it, and those that told its distance."""

LENGTH_RATIO = 0.5, 2.0
SETTLED = 2
"""Visits that must have seen a cue before it is stable, where there were so many."""


@dataclass(frozen=True, slots=True, eq=False)
class Asr:
    """Links of one scene, and how often each of the eight directions was looked in, (8,)."""

    links: NDArray[np.void]
    visits: NDArray[np.int64]

    @property
    def facings(self) -> int:
        """Bit f set where direction f was looked in."""
        return int((1 << np.flatnonzero(self.visits > 0)).sum())


EMPTY = Asr(np.zeros(0, LINK), np.zeros(FACINGS, np.int64))


def visited(asr: Asr, cues: NDArray[np.void], facings: int, params: GatewayParams) -> Asr:
    """The scene after one more visit that looked in the given directions."""
    looked = facings >> np.arange(FACINGS) & 1
    links = asr.links.copy()
    old, new = _same(links, cues, params.distance_share)
    present = np.zeros(len(links), bool)
    present[old] = True
    links["weight"] = np.where(
        present,
        links["weight"] + params.strengthen * (1.0 - links["weight"]),
        np.where(looked[links["facing"]] == 1, params.weaken * links["weight"], links["weight"]),
    )
    _blend(links, old, cues[new])
    fresh = np.ones(len(cues), bool)
    fresh[new] = False
    links = np.concatenate([links, _links(cues[fresh], params.strengthen)])
    return Asr(_ordered(links[links["weight"] >= params.forget]), asr.visits + looked)


def united(keep: Asr, drop: Asr, params: GatewayParams) -> Asr:
    """The scene of two that turn out to be of one place: cues of both are seen by both."""
    links, other = keep.links.copy(), drop.links.copy()
    old, new = _same(links, other, params.distance_share)
    for mine, theirs, asr in ((links, old, drop), (other, new, keep)):
        alone = np.ones(len(mine), bool)
        alone[theirs] = False
        mine["weight"][alone] *= params.weaken ** asr.visits[mine["facing"][alone]]
    weights = 1.0 - (1.0 - links["weight"][old]) * (1.0 - other["weight"][new])
    _blend(links, old, other[new], other["seen"][new])
    links["weight"][old] = weights
    rest = np.ones(len(other), bool)
    rest[new] = False
    links = np.concatenate([links, other[rest]])
    return Asr(_ordered(links[links["weight"] >= params.forget]), keep.visits + drop.visits)


def strongest(asr: Asr, count: int) -> Asr:
    """The scene with its ``count`` strongest links."""
    order = np.argsort(-asr.links["weight"].astype(np.float64), kind="stable")[:count]
    return Asr(asr.links[np.sort(order)], asr.visits)


def stable(asr: Asr, params: GatewayParams) -> tuple[NDArray[np.void], FloatArray]:
    """Stable cues and the weight each counts with."""
    visits = asr.visits[asr.links["facing"]]
    enough = asr.links["seen"] >= np.minimum(SETTLED, visits)
    shares = (asr.links["seen"] + 1.0) / (visits + 2.0)
    weights = shares if params.weights == "count" else asr.links["weight"].astype(np.float64)
    kept = enough & (asr.links["weight"] >= params.stable)
    return asr.links[kept][list(CUE.names or ())].astype(CUE), weights[kept]


def _same(
    links: NDArray[np.void], cues: NDArray[np.void], share: float
) -> tuple[Sequence[int], Sequence[int]]:
    """Pairs of a link and the cue it is seen again in, the nearest across first."""
    apart = np.abs(links["x_px"][:, None].astype(np.float64) - cues["x_px"][None, :])
    ratio = lengths(links)[:, None] / lengths(cues)[None, :]
    possible = (
        (links["facing"][:, None] == cues["facing"][None, :])
        & (links["direction"][:, None] == cues["direction"][None, :])
        & (np.abs(columns_of(links)[:, None] - columns_of(cues)[None, :]) <= 1)
        & (apart <= CELL_PX - 2)
        & compatible(links["distance_m"][:, None], cues["distance_m"][None, :], share)
        & (ratio >= LENGTH_RATIO[0])
        & (ratio <= LENGTH_RATIO[1])
    )
    rows, columns = np.nonzero(possible)
    old: list[int] = []
    new: list[int] = []
    for at in np.lexsort((columns, rows, apart[rows, columns])):
        row, column = int(rows[at]), int(columns[at])
        if row not in old and column not in new:
            old.append(row)
            new.append(column)
    return old, new


def _links(cues: NDArray[np.void], weight: float) -> NDArray[np.void]:
    links = np.zeros(len(cues), LINK)
    for name in CUE.names or ():
        links[name] = cues[name]
    links["weight"], links["seen"] = weight, 1
    links["known"] = ~np.isnan(cues["distance_m"])
    return links


def _blend(
    links: NDArray[np.void],
    rows: Sequence[int],
    cues: NDArray[np.void],
    seen: NDArray[np.int32] | None = None,
) -> None:
    """Move links towards where they were seen again; ``seen`` how often, once by default."""
    times = np.ones(len(cues)) if seen is None else seen
    share = times / (links["seen"][rows] + times)
    for name in ("x_px", "top_px", "bottom_px", "strength"):
        links[name][rows] += share * (cues[name] - links[name][rows])
    known = ~np.isnan(cues["distance_m"])
    before = np.nan_to_num(links["distance_m"][rows])
    count = links["known"][rows] + known
    total = before * links["known"][rows] + np.nan_to_num(cues["distance_m"])
    links["distance_m"][rows] = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    links["known"][rows] = count
    links["seen"][rows] += times.astype(np.int32)


def _ordered(links: NDArray[np.void]) -> NDArray[np.void]:
    order = np.lexsort((links["top_px"], links["x_px"], links["facing"]))
    return links[order]
