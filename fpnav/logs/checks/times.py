"""Checks of time: order, rates, gaps, clocks, and whether the sensors meet."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fpnav.errors import LogError
from fpnav.logs.checks.finding import Finding, fail, note, ok, warn
from fpnav.logs.frames import Log
from fpnav.logs.ledger import Budget
from fpnav.logs.streams import Stream

_OFFSET_S = 1.0
_JITTER = 0.5
_POLICY = "stages go by log time"


def clock(log: Log, budget: Budget) -> Iterator[Finding]:
    """Header stamps can be relied on."""
    for code in ("B6", "E202", "E204"):
        if log.ledger.notes[code] and code in log.ledger.remarks:
            yield warn("clock", code, log.ledger.remarks[code], _POLICY)
            return
    yield ok("clock", "header stamps run on")


def order(log: Log, budget: Budget) -> Iterator[Finding]:
    """Messages of a topic come in order of their stamps, each with a stamp of its own."""
    counts = {name: count.skipped["E201"] for name, count in log.ledger.topics.items()}
    late = {name: count for name, count in counts.items() if count}
    for name, count in sorted(late.items()):
        yield warn(
            "order", "E201", f"{name}: {count} late messages are skipped", "check the driver"
        )
    if log.ledger.notes["B3"]:
        yield note("order", "B3", log.ledger.remarks["B3"])
    elif not late:
        yield ok("order", "stamps increase in every topic")


def stamps_against_log_time(log: Log, budget: Budget) -> Iterator[Finding]:
    """Header stamps and log times are of one clock."""
    apart = False
    for role, streams in log.streams.items():
        offset_s, spread_s = _offset(streams[0])
        if abs(offset_s) > _OFFSET_S or spread_s > _OFFSET_S:
            apart = True
            message = (
                f"{role} {streams[0].topic}: log time is {offset_s:+.3f} s from the stamps "
                f"(spread {spread_s:.3f} s)"
            )
            yield warn("log-time", "B7", message, "labels go by log time; synchronise the clocks")
    if not apart:
        yield ok("log-time", "header stamps and log times agree within a second")


def _offset(stream: Stream) -> tuple[float, float]:
    """Median of log time minus stamp, and the spread of the middle nine tenths (s)."""
    apart = (stream.log_ns - stream.stamps) / 1e9
    low, high = np.quantile(apart, [0.05, 0.95])
    return float(np.median(apart)), float(high - low)


def rates(log: Log, budget: Budget) -> Iterator[Finding]:
    """Sensors are regular."""
    told = []
    for role, streams in log.streams.items():
        stream = max(streams, key=len)
        steps = np.diff(stream.stamps)
        steps = steps[steps > 0] / 1e9
        if len(steps) < 10 or role == "label":
            continue
        period = float(np.median(steps))
        jitter = float(np.median(np.abs(steps - period)) / period)
        told.append(f"{role} {1 / period:.3g} Hz")
        if jitter > _JITTER:
            message = f"{role} {stream.topic}: periods vary by {jitter:.0%} around {period:.3g} s"
            yield note("rates", "B10", message)
    yield ok("rates", ", ".join(told) or "too few messages to tell")


def gaps(log: Log, budget: Budget) -> Iterator[Finding]:
    """No sensor pauses."""
    paused = False
    for role, facts in log.roles.items():
        if facts.gaps and role != "label":
            paused = True
            message = f"{role} {facts.topics[0]}: {facts.gaps} gaps, {facts.longest_gap_s:.1f} s"
            yield warn("gaps", "B10", message, "dead reckoning across a gap is not to be trusted")
    if not paused:
        yield ok("gaps", "none")


def joined(log: Log, budget: Budget) -> Iterator[Finding]:
    """Every sensor has a message near every frame."""
    if not log.primary:
        return
    try:
        for _ in log.sample(1):
            pass
        alone = _unjoined(log)
    except LogError as error:
        yield fail("joined", "E205", str(error), "leave the role out with --topic ROLE=")
        return
    for role, share in alone.items():
        message = f"{share:.0%} of the frames have no {role} near enough in time"
        yield note("joined", f"unjoined:{role}", message)
    if not alone:
        yield ok("joined", "every frame has a message of every sensor")


def _unjoined(log: Log) -> dict[str, float]:
    """Share of sampled frames that lack a role the log has."""
    sensors = [r for r in log.roles if r in ("panorama", "omni", "camera", "camera_offset",
                                             "scan", "sonar", "pan")]  # fmt: skip
    lacking = dict.fromkeys(sensors, 0)
    count = 0
    for frame in log.sample(200):
        count += 1
        for role in sensors:
            lacking[role] += role not in frame.payloads
    return {role: n / count for role, n in lacking.items() if n}
