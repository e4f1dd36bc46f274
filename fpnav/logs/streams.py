"""The messages that play a role, in time order, and their joins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnav.errors import LogError
from fpnav.logs import timing
from fpnav.logs.codecs import Codec
from fpnav.logs.ledger import Ledger
from fpnav.logs.topics import Topic
from fpnav.values import FloatArray

LEAST_TOLERANCE_NS = 1e6
MOST_TOLERANCE_NS = 1e9
_BY_LOG_TIME = ("label",)


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """One topic of a role: everything (n,) in order of ``stamps``.

    ``ordinals`` count the topic's messages in the file from 0, dropped ones included. ``rows``
    are the index rows, ``columns`` (n, 3 or 1) the values of a state topic, ``objects`` those of
    a label topic.
    """

    topic: str
    type_name: str
    frame_id: str
    stamps: NDArray[np.int64]
    log_ns: NDArray[np.int64]
    ordinals: NDArray[np.int64]
    rows: NDArray[Any]
    columns: FloatArray
    objects: list[Any]
    codecs: dict[int, Codec]

    def __len__(self) -> int:
        return len(self.stamps)

    @property
    def period_ns(self) -> float:
        """Median period, NaN below two messages."""
        return timing.median_period(self.stamps)


def build_streams(
    topics: Mapping[str, Topic], chosen: Mapping[str, tuple[str, ...]], ledger: Ledger
) -> dict[str, list[Stream]]:
    """Streams of every role, all by one clock; late messages are skipped and counted."""
    ordered = {
        name: timing.by_log_time(topics[name].rows) for names in chosen.values() for name in names
    }
    by_log_time = _log_time_needed(topics, ordered, ledger)
    streams: dict[str, list[Stream]] = {}
    for role, names in chosen.items():
        by_log = by_log_time or role in _BY_LOG_TIME
        found = [_stream(topics[name], ordered[name], by_log, ledger) for name in names]
        if kept := [stream for stream in found if len(stream)]:
            streams[role] = kept
    return streams


def _log_time_needed(
    topics: Mapping[str, Topic], ordered: Mapping[str, NDArray[np.int64]], ledger: Ledger
) -> bool:
    """Whether header stamps of a used topic cannot be relied on; the policy is noted."""
    for name, order in ordered.items():
        topic = topics[name]
        if topic.columns.shape[1] or not topic.objects:
            trouble = timing.clock_trouble(topic.rows[order])
            if trouble:
                reason = f"{name}: stamps {_TROUBLES[trouble]}; the log goes by log time"
                ledger.note(trouble, reason)
                return True
    return False


_TROUBLES = {
    "B6": "are mostly zero",
    "E204": "are mostly outside 1970 to 2200",
    "E202": "jump back by more than a second",
}


def _stream(topic: Topic, order: NDArray[np.int64], by_log: bool, ledger: Ledger) -> Stream:
    rows = topic.rows[order]
    stamps = rows["log_ns"] if by_log else rows["stamp_ns"]
    count = ledger.topic(topic.name)
    possible = (stamps >= 0) & (stamps < timing.YEAR_2200_NS)
    count.drop("E204", int(np.count_nonzero(~possible)))
    sane = possible if by_log else possible & ~_unset(stamps)
    count.drop("E203", int(np.count_nonzero(possible & ~sane)))
    on_time = np.zeros(len(rows), dtype=np.bool_)
    on_time[sane] = timing.in_order(stamps[sane])
    count.drop("E201", int(np.count_nonzero(sane & ~on_time)))
    keep = np.flatnonzero(on_time)
    stamps = stamps[keep].astype(np.int64)
    _note_pauses(topic.name, stamps, ledger)
    columns = topic.columns[order][keep] if topic.columns.shape[1] else topic.columns
    objects = [topic.objects[i] for i in order[keep].tolist()] if topic.objects else []
    return Stream(
        topic.name,
        topic.type_name,
        topic.frame_id,
        stamps,
        rows["log_ns"][keep].astype(np.int64),
        keep.astype(np.int64),
        rows[keep],
        columns,
        objects,
        topic.codecs,
    )


def _unset(stamps: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Stamps left at zero; a clock that starts with the log may well begin there."""
    zero = np.asarray(stamps == 0, dtype=np.bool_)
    after = stamps[~zero]
    soon = max(timing.JUMP_NS, 10 * np.nan_to_num(timing.median_period(after)))
    if len(after) == 0 or int(after.min()) < soon:
        zero &= np.cumsum(~zero) > 0
    return zero


def _note_pauses(name: str, stamps: NDArray[np.int64], ledger: Ledger) -> None:
    """Note equal stamps (B3) and gaps (B10)."""
    pauses, longest = timing.gaps(stamps)
    if pauses:
        ledger.note("B10", f"{name}: {pauses} gaps, the longest {longest:.1f} s", pauses)
    equal = int(np.count_nonzero(np.diff(stamps) == 0))
    if equal:
        ledger.note("B3", f"{name}: {equal} messages have the stamp of the one before", equal)


def joined(
    name: str,
    role: str,
    stream: Stream,
    query_ns: NDArray[np.int64],
    tolerance_ns: float,
    ledger: Ledger,
) -> NDArray[np.int64]:
    """Row of the stream nearest each query stamp, -1 beyond the tolerance; misses are noted.

    Raises
    ------
    LogError
        E205: no query finds a message.
    """
    rows = timing.nearest(stream.stamps, query_ns, tolerance_ns)
    missed = int(np.count_nonzero(rows < 0))
    if missed and missed == len(query_ns):
        away = int(np.abs(stream.stamps[:, None] - query_ns[[0, -1]]).min())
        raise LogError(
            f"{name}: E205 {stream.topic} ({_span(stream.stamps)}) and the frames "
            f"({_span(query_ns)}) never meet within {tolerance_ns / 1e9:.3g} s (nearest "
            f"{away / 1e9:.3g} s); leave it out with --topic {role}="
        )
    if missed:
        remark = f"{stream.topic}: no message within {tolerance_ns / 1e9:.3g} s of a frame"
        ledger.note(f"unjoined:{role}", remark, missed)
    return rows


def _span(stamps: NDArray[np.int64]) -> str:
    return f"{stamps[0] / 1e9:.3f} .. {stamps[-1] / 1e9:.3f} s"


def tolerance(first: Stream, second: Stream, wanted_s: float | None) -> float:
    """Join tolerance in ns: half the slower one's period within 1 ms .. 1 s, or as wanted."""
    if wanted_s is not None:
        return wanted_s * 1e9
    periods = [p for p in (first.period_ns, second.period_ns) if not np.isnan(p)]
    half = 0.5 * max(periods, default=MOST_TOLERANCE_NS)
    return float(np.clip(half, LEAST_TOLERANCE_NS, MOST_TOLERANCE_NS))


def states(streams: Sequence[Stream], query_ns: NDArray[np.int64]) -> FloatArray:
    """Poses (q, 3) of a state role at the query stamps; headings alone stand in column 2.

    NaN where no sample is within a second or two and a half median periods.
    """
    if not streams:
        return np.full((len(query_ns), 3), np.nan)
    stream = streams[0]
    stamps, first = np.unique(stream.stamps, return_index=True)
    columns = stream.columns[first]
    poses = np.zeros((len(stamps), 3))
    poses[:, 3 - columns.shape[1] :] = columns
    reach = max(1e9, 2.5 * np.nan_to_num(stream.period_ns))
    bridge = columns.shape[1] == 3
    return timing.interpolated(stamps, poses, query_ns, reach, bridge=bridge)
