"""The messages of every sensor role joined to the frames they belong to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from fpnav.logs import streams as joins
from fpnav.logs import timing
from fpnav.logs.container import Damaged
from fpnav.logs.contents import Container
from fpnav.logs.ledger import Ledger
from fpnav.logs.payloads import Fitting, Loader, make_payload
from fpnav.logs.streams import Stream
from fpnav.values import SENSOR_ROLES, Payload


class Joining:
    """One reading of a log's frames: which message each takes of each role, and what was lost.

    Parameters
    ----------
    main : the stream the frames stand on
    kept : (k,) its rows that become frames
    tolerance_s : largest time between a frame and a joined message; None = by the periods

    Raises
    ------
    LogError
        A role's messages are all too far from any frame (E205).
    """

    def __init__(
        self,
        file: Container,
        streams: Mapping[str, list[Stream]],
        main: Stream,
        kept: NDArray[np.int64],
        fitting: Fitting,
        ledger: Ledger,
        tolerance_s: float | None,
    ) -> None:
        self._streams = streams
        self._loader = Loader(file)
        self._fitting = fitting
        self._ledger = ledger
        self._rows: dict[str, list[NDArray[np.int64]]] = {}
        for role in SENSOR_ROLES:
            if role in streams:
                self._rows[role] = [
                    self._join(role, stream, main, kept, tolerance_s) for stream in streams[role]
                ]

    def count_unused(self, primary: str, *, thinned: bool) -> None:
        """Count messages that no frame takes: thinned out, or with no frame near them."""
        for role, found in self._rows.items():
            code = "thinned" if role == primary and thinned else "unjoined"
            for stream, rows in zip(self._streams[role], found, strict=True):
                taken = len(np.unique(rows[rows >= 0]))
                self._ledger.topic(stream.topic).drop(code, len(stream) - taken)

    def payloads(self, place: int) -> dict[str, Payload]:
        """Payloads of one frame; a message that cannot be decoded is counted and left out."""
        payloads: dict[str, Payload] = {}
        for role, found in self._rows.items():
            rows = [int(column[place]) for column in found]
            if max(rows) < 0:
                continue
            streams = self._streams[role]
            try:
                payloads[role] = make_payload(role, streams, rows, self._loader, self._fitting)
            except Damaged as damage:
                self._count_damage(streams, rows, damage)
        return payloads

    def _join(
        self,
        role: str,
        stream: Stream,
        main: Stream,
        kept: NDArray[np.int64],
        tolerance_s: float | None,
    ) -> NDArray[np.int64]:
        """Row of a stream at each kept frame, -1 where it has none near enough."""
        if stream is main:
            return kept
        if role == "label":
            return timing.holding(stream.stamps, main.log_ns[kept])
        limit_ns = joins.tolerance(main, stream, tolerance_s)
        return joins.joined(
            self._fitting.name, role, stream, main.stamps[kept], limit_ns, self._ledger
        )

    def _count_damage(
        self, streams: Sequence[Stream], rows: Sequence[int], damage: Damaged
    ) -> None:
        first = next(number for number, row in enumerate(rows) if row >= 0)
        self._ledger.topic(streams[first].topic).drop(damage.code)
        self._ledger.note(damage.code, f"{streams[first].topic}: {damage.reason}")
