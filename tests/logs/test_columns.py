"""Messages decoded in columns equal those decoded one by one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.logs import START_NS, STEP_NS, drive, scan, write_log
from hypothesis import given, settings
from hypothesis import strategies as st

from fpnav.logs import columns, index, messages
from fpnav.logs.columns import Payloads
from fpnav.logs.decode import scan_of
from fpnav.logs.frames import open_log
from fpnav.logs.index import index_log
from fpnav.logs.ledger import Ledger
from fpnav.logs.reader import LogFile
from fpnav.logs.topics import Topic
from fpnav.logs.writer import LogWriter
from fpnav.values import Pose2


def topics(path: Path) -> dict[str, Topic]:
    with LogFile(path) as file:
        return index_log(file, Ledger())


def check_same(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both ways of indexing a log give the same."""
    fast = topics(path)
    monkeypatch.setattr(index, "_take_columns", lambda *_: False)
    slow = topics(path)
    monkeypatch.undo()
    assert fast.keys() == slow.keys()
    for name, topic in fast.items():
        assert np.array_equal(topic.rows, slow[name].rows), name
        assert np.allclose(topic.columns, slow[name].columns, rtol=0, atol=1e-12), name
        assert topic.count.skipped == slow[name].count.skipped, name
        assert topic.count.used == slow[name].count.used, name
        assert topic.frame_id == slow[name].frame_id


def odd_poses(writer: LogWriter) -> None:
    """Poses of every kind that is refused, among good ones."""
    for i in range(8):
        made = messages.odometry(START_NS + i * STEP_NS, Pose2(i, 0.5, 0.1 * i), 0.1, 0.0)
        if i == 2:
            made.pose.pose.orientation.w = 0.0
            made.pose.pose.orientation.z = 0.0
        if i == 4:
            made.pose.pose.position.x = float("nan")
        if i == 5:
            made.pose.pose.orientation.w *= 1.0005
        writer.message("/odom", messages.ODOMETRY, made, START_NS + i, None)
        head = messages.imu(START_NS + i * STEP_NS, 0.1 * i)
        head.orientation_covariance[0] = -1.0 if i == 3 else 0.0
        writer.message("/compass", messages.IMU, head, START_NS + i, None)


def many_frames(writer: LogWriter) -> None:
    """One topic with two sensors, one that changes its frame, one that repeats itself."""
    for i in range(8):
        stamp = START_NS + i * STEP_NS
        for name in ("front", "rear"):
            made = messages.laser_scan(stamp, name, scan(range_m=1.0 + i))
            writer.message("/scan", messages.LASER_SCAN, made, stamp, None)
        made = messages.sonar_range(stamp, f"sonar_{i % 3}", 1.0 + i, 0.4, 0.1, 5.0)
        writer.message("/ring", messages.RANGE, made, stamp, None)
        writer.scan(stamp if i != 5 else stamp - STEP_NS, scan(range_m=9.0), topic="/again")


def odd_sizes(writer: LogWriter) -> None:
    for i, beams in enumerate([8, 8, 9, 8, 9, 9, 9, 8, 8, 8]):
        writer.scan(START_NS + i * STEP_NS, scan(beams, range_m=1.0 + i))


@pytest.mark.parametrize("fill", [drive, odd_poses, many_frames, odd_sizes])
def test_both_ways_of_indexing_agree(
    fill: Callable[[LogWriter], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    check_same(write_log(tmp_path / "a.mcap", fill), monkeypatch)


def test_poses_that_are_none_are_counted(tmp_path: Path) -> None:
    found = topics(write_log(tmp_path / "a.mcap", odd_poses))
    assert found["/odom"].count.skipped == {"E504": 2}
    assert found["/compass"].count.skipped == {"E504": 1}
    assert found["/odom"].columns[:, 0].tolist() == [0, 1, 3, 5, 6, 7]


def test_sensors_that_share_a_topic_are_told_apart_by_their_frames(tmp_path: Path) -> None:
    path = write_log(tmp_path / "a.mcap", many_frames)
    with open_log(path, {"scan": "/scan#rear"}, strict=True) as log:
        assert {"/scan#front", "/scan#rear", "/ring#sonar_0"} <= set(log.topics)
        assert log.roles["scan"].topics == ("/scan#rear",)
        assert log.roles["sonar"].topics == ("/ring#sonar_0", "/ring#sonar_1", "/ring#sonar_2")
        assert len(list(log.frames())) == 8


def payloads_of(sent: list[bytes]) -> Payloads:
    lengths = np.array([len(data) for data in sent], dtype=np.int64)
    return Payloads(b"".join(sent), np.cumsum(lengths) - lengths, lengths)


def scan_bytes(i: int, beams: int, frame: str = "laser", intensities: int = 0) -> bytes:
    made: Any = messages.laser_scan(START_NS + i, frame, scan(beams, range_m=1.0 + i))
    made.intensities = np.arange(intensities, dtype=np.float32)
    return messages.serialize(made, messages.LASER_SCAN)


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(st.integers(1, 4), st.sampled_from(["laser", "l", "front"]), st.integers(0, 2)),
        min_size=1,
        max_size=24,
    )
)
def test_scan_columns_hold_what_the_messages_hold(kinds: list[tuple[int, str, int]]) -> None:
    sent = [scan_bytes(i, beams, frame, extra) for i, (beams, frame, extra) in enumerate(kinds)]
    groups, odd = columns.scans(payloads_of(sent))
    seen = [int(row) for group in groups for row in group.rows] + odd.tolist()
    assert sorted(seen) == list(range(len(sent)))
    store = messages.typestore()
    for group in groups:
        for place, row in enumerate(group.rows.tolist()):
            expected = scan_of(store.deserialize_cdr(sent[row], messages.LASER_SCAN))
            assert group.stamps_ns[place] == START_NS + row
            assert group.frame_id == kinds[row][1]
            assert np.array_equal(group.ranges_m[place], expected.ranges_m)
            assert group.angle_min_rad[place] == np.float32(expected.angle_min_rad)
            assert group.range_max_m[place] == np.float32(expected.range_max_m)


def test_scans_of_one_layout_are_one_group() -> None:
    groups, odd = columns.scans(payloads_of([scan_bytes(i, 8) for i in range(20)]))
    assert len(groups) == 1
    assert len(odd) == 0
    assert groups[0].ranges_m.shape == (20, 8)


def test_damaged_scans_are_left_to_the_strict_decoder() -> None:
    good = [scan_bytes(i, 8) for i in range(6)]
    for change in (0, 1, 12, 16, 24 + 28):
        bad = bytearray(good[0])
        bad[change] ^= 0x55
        groups, odd = columns.scans(payloads_of([*good, bytes(bad)]))
        assert groups == []
        assert odd.tolist() == list(range(7))


def test_range_columns_hold_what_the_messages_hold() -> None:
    sent = [
        messages.serialize(
            messages.sonar_range(START_NS + i, "sonar_1", 0.5 + i, 0.4, 0.1, 5.0), messages.RANGE
        )
        for i in range(5)
    ]
    found = columns.ranges(payloads_of(sent))
    assert found is not None
    assert found.range_m.tolist() == [0.5, 1.5, 2.5, 3.5, 4.5]
    assert found.range_max_m.tolist() == [5.0] * 5
    assert found.frame_id == "sonar_1"
    assert columns.ranges(payloads_of([sent[0], sent[1] + b"\0" * 9])) is None


@settings(max_examples=30)
@given(st.binary(max_size=80), st.integers(0, 3))
def test_any_bytes_are_either_of_one_layout_or_left_alone(data: bytes, copies: int) -> None:
    payloads = payloads_of([data] * (copies + 1))
    columns.heads(payloads)
    columns.poses(payloads, messages.ODOMETRY)
    columns.yaws(payloads)
    columns.ranges(payloads)
    columns.scans(payloads)
