"""Rows A and B of the fault catalogue: what goes wrong with logs, and what comes of it."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers import mcaps
from helpers.logs import START_NS, STEP_NS, drive, log_bytes, scan, write_log

from fpnav.errors import FpnavError, LogError, LossError, UsageError
from fpnav.logs import messages
from fpnav.logs.frames import Log, open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.ledger import Budget
from fpnav.logs.writer import LogWriter
from fpnav.values import Pose2


@pytest.fixture
def target(tmp_path: Path) -> Path:
    return tmp_path / "log.mcap"


def scans(stamps: list[int], log_times: list[int] | None = None) -> Callable[[LogWriter], None]:
    """Scans at these stamps (ns after the start), range = number."""

    def fill(writer: LogWriter) -> None:
        for i, stamp in enumerate(stamps):
            log_ns = START_NS + log_times[i] if log_times else None
            writer.scan(START_NS + stamp, scan(range_m=1.0 + i), log_ns=log_ns)

    return fill


def ranges(log: Log) -> list[float]:
    """First range of every frame's scan: which scans came out, in which order."""
    return [float(frame.scan.ranges_m[0]) for frame in log.frames() if frame.scan]


def count(log: Log, topic: str = "/scan") -> dict[str, int]:
    return dict(log.ledger.topic(topic).skipped)


@pytest.mark.parametrize("row", ["A1", "A2"])
def test_what_is_no_log_is_refused_in_one_line(row: str, target: Path) -> None:
    target.write_bytes(b"" if row == "A1" else b"SQLite format 3\x00")
    with pytest.raises(LogError, match="E101" if row == "A1" else "E100 .*SQLite") as caught:
        open_log(target)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 1


@pytest.mark.parametrize("row", ["A3", "A4", "A20"])
def test_a_cut_log_is_over_budget_unless_allowed(row: str, target: Path) -> None:
    data = log_bytes(drive, "none")
    cut = {"A3": data[: len(data) // 2], "A4": data[: data.rindex(b"\x0f\x04\0\0\0\0\0\0\0")]}
    target.write_bytes(cut.get(row, cut["A4"] + b"\x00" * 4096))
    with pytest.raises(LossError, match="E102") as caught:
        open_log(target)
    assert caught.value.exit_code == 3
    with open_log(target, allow_truncated=True) as log:
        saved = ranges(log)
        assert log.integrity == "damaged"
    assert saved == pytest.approx([1.0 + 0.1 * i for i in range(len(saved))])
    assert len(saved) == (12 if row != "A3" else len(saved)) > 0


def test_a_cut_log_is_ingested_when_allowed_and_not_published_when_not(tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(log_bytes(drive, "none")[:-12000])
    with pytest.raises(LossError):
        ingest([tmp_path / "cut.mcap"], tmp_path / "out.mcap")
    assert [path.name for path in tmp_path.iterdir()] == ["cut.mcap"]
    ingest([tmp_path / "cut.mcap"], tmp_path / "out.mcap", budget=Budget(allow_truncated=True))
    with open_log(tmp_path / "out.mcap") as log:
        assert log.integrity == "verified"
        assert ranges(log)


@pytest.mark.parametrize("row", ["A5", "A6", "A7", "A8", "A9"])
def test_logs_without_index_or_chunks_read_as_those_with(row: str, target: Path) -> None:
    options = {
        "A5": {"repeat_channels": False, "repeat_schemas": False, "use_statistics": False},
        "A6": {"index_types": mcap_index("CHUNK")},
        "A7": {"index_types": mcap_index("MESSAGE")},
        "A8": {"use_chunking": False},
        "A9": {"chunk_size": 10},
    }[row]
    target.write_bytes(rewritten(log_bytes(drive), **options))
    with open_log(target, strict=True) as log:
        assert ranges(log) == pytest.approx([1.0 + 0.1 * i for i in range(12)])


def mcap_index(name: str) -> object:
    from mcap.writer import IndexType

    return getattr(IndexType, name)


def rewritten(data: bytes, **options: object) -> bytes:
    """The same log by the plain writer with other options."""
    from mcap.reader import make_reader
    from mcap.writer import Writer

    stream = io.BytesIO()
    writer = Writer(stream, **options)
    writer.start("ros2", "test")
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages():
        if schema.id not in schemas:
            schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
        if channel.id not in channels:
            channels[channel.id] = writer.register_channel(
                channel.topic, channel.message_encoding, schemas[schema.id]
            )
        writer.add_message(
            channels[channel.id], message.log_time, message.data, message.publish_time
        )
    writer.finish()
    return stream.getvalue()


def test_a10_lost_chunks_are_counted_with_their_topics(target: Path) -> None:
    data = rewritten(log_bytes(drive, "none"), chunk_size=3000, compression=compression_none())
    at = data.index(struct.pack("<f", 1.7))
    target.write_bytes(data[:at] + b"\xff" + data[at + 1 :])
    with pytest.raises(LossError, match=r"lost \(\d+\.\d+%; \d+ E110\)"):
        open_log(target)
    with open_log(target, max_loss=0.9) as log:
        saved = ranges(log)
        lost = count(log)["E110"]
        assert log.integrity == "damaged"
        assert log.ledger.topic("/scan").in_file == 12
    assert len(saved) + lost == 12
    assert 1.7 not in np.round(saved, 3)


def test_a10_a_log_whose_only_chunk_is_lost_is_a_loss_not_a_log_without_topics(
    target: Path,
) -> None:
    data = rewritten(log_bytes(drive, "none"), compression=compression_none())
    at = data.index(struct.pack("<f", 1.7))
    target.write_bytes(data[:at] + b"\xff" + data[at + 1 :])
    for budget in (Budget(), Budget(1.0, allow_truncated=True)):
        with pytest.raises(LossError, match=r"E110 .*nothing is left to stand frames on"):
            ingest([target], target.with_suffix(".out"), budget=budget)
    assert not target.with_suffix(".out").exists()


def compression_none() -> object:
    from mcap.writer import CompressionType

    return CompressionType.NONE


def test_a11_logs_without_crc_are_unverified(target: Path) -> None:
    target.write_bytes(rewritten(log_bytes(drive), enable_crcs=False))
    with open_log(target) as log:
        assert log.integrity == "unverified"
        assert log.ledger.notes["A11"] == 1


def test_a16_a_record_over_the_limit_is_skipped_and_what_follows_is_read(
    target: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fpnav.logs.limits.MESSAGE_BYTES", 2**21)
    huge = mcaps.message(1, 5, b"x" * 2**21 + b"y")
    target.write_bytes(mcaps.whole(mcaps.channel(1, "/a"), huge, mcaps.message(1, 6, b"z")))
    with open_log(target, max_loss=1.0) as log:
        assert log.topics["/a"].count.skipped == {"E113": 1, "unused": 1}


def test_a21_messages_of_unknown_channels_and_schemas_are_counted(target: Path) -> None:
    parts = (mcaps.message(7, 5, b"x"), mcaps.channel(2, "/b", 9, "cdr"), mcaps.message(2, 5, b"x"))
    target.write_bytes(mcaps.whole(*parts))
    with open_log(target, max_loss=1.0) as log:
        assert log.ledger.notes["E117"] == 1
        assert log.topics["(channel 7)"].count.skipped["E117"] == 1
        assert log.topics["/b"].problem == "E301 no schema"


def scan_payload(range_m: float, stamp_ns: int = START_NS) -> bytes:
    message = messages.laser_scan(stamp_ns, "scan", scan(range_m=range_m))
    return messages.serialize(message, messages.LASER_SCAN)


def scan_channel(number: int, topic: str = "/scan", schema: int = 1) -> bytes:
    return mcaps.channel(number, topic, schema=schema, encoding="cdr")


SCAN_SCHEMA = mcaps.schema(1, messages.LASER_SCAN, messages.definition(messages.LASER_SCAN))


@pytest.mark.parametrize("row", ["A22", "C14"])
def test_a_channel_defined_twice_spoils_its_topic_alone(row: str, target: Path) -> None:
    again = (
        scan_channel(1, "/other")
        if row == "A22"
        else mcaps.schema(1, "sensor_msgs/msg/Range", b"float32 range")
    )
    parts = [SCAN_SCHEMA, scan_channel(1), mcaps.message(1, START_NS, scan_payload(1.0)), again]
    other = mcaps.schema(2, messages.LASER_SCAN, messages.definition(messages.LASER_SCAN))
    good = [other, scan_channel(2, "/front", 2), mcaps.message(2, START_NS, scan_payload(2.0))]
    target.write_bytes(mcaps.whole(*parts, *good))
    with open_log(target) as log:
        assert log.roles["scan"].topics == ("/front",)
        assert log.topics["/scan"].problem == "E118 defined twice with different content"
        assert ranges(log) == [2.0]


def test_a23_channels_of_one_topic_are_read_together_in_time_order(target: Path) -> None:
    payloads = [scan_payload(1.0 + i, START_NS + i * STEP_NS) for i in range(4)]
    sent = [
        mcaps.message(1 + i % 2, START_NS + i * STEP_NS, payload)
        for i, payload in enumerate(payloads)
    ]
    target.write_bytes(mcaps.whole(SCAN_SCHEMA, scan_channel(1), scan_channel(2), *sent))
    with open_log(target) as log:
        assert ranges(log) == [1.0, 2.0, 3.0, 4.0]


def test_a23_two_types_on_one_topic_are_refused(target: Path) -> None:
    odometry = mcaps.schema(2, messages.ODOMETRY, messages.definition(messages.ODOMETRY))
    sent = [mcaps.message(1, START_NS, scan_payload(1.0)), mcaps.message(2, START_NS, b"\0\1\0\0")]
    channels = [scan_channel(1), scan_channel(2, schema=2)]
    target.write_bytes(mcaps.whole(SCAN_SCHEMA, odometry, *channels, *sent))
    with open_log(target) as log:
        assert log.topics["/scan"].problem.startswith("E119 carries both sensor_msgs/msg/LaserScan")
    with pytest.raises(LogError, match="E119 carries both"):
        open_log(target, {"scan": "/scan"})


def test_a24_wrong_statistics_are_a_note(target: Path) -> None:
    data = bytearray(log_bytes(scans([0, 1, 2])))
    at = data.rindex(struct.pack("<HQ", 2, 3))
    struct.pack_into("<Q", data, at + 2, 2)
    target.write_bytes(bytes(data))
    with open_log(target) as log:
        assert len(ranges(log)) == 3


def test_a27_files_of_one_recording_are_merged_in_order_without_duplicates(tmp_path: Path) -> None:
    first = write_log(tmp_path / "b.mcap", scans([0, STEP_NS, 2 * STEP_NS]))

    def rest(writer: LogWriter) -> None:
        writer.scan(START_NS + 2 * STEP_NS, scan(range_m=3.0))
        writer.scan(START_NS + 3 * STEP_NS, scan(range_m=4.0))

    second = write_log(tmp_path / "a.mcap", rest)
    done = ingest([second, first], tmp_path / "out.mcap")
    assert done.ledger.topic("/scan").skipped["duplicate"] == 1
    assert done.ledger.topic("/scan").in_file == 5
    with open_log(tmp_path / "out.mcap") as log:
        assert ranges(log) == [1.0, 2.0, 3.0, 4.0]


def test_a28_the_same_file_twice_is_a_usage_error(tmp_path: Path) -> None:
    first = write_log(tmp_path / "a.mcap", scans([0]))
    (tmp_path / "b.mcap").write_bytes(first.read_bytes())
    with pytest.raises(UsageError, match=r"b\.mcap: the same file as .*a\.mcap"):
        ingest([first, tmp_path / "b.mcap"], tmp_path / "out.mcap")


def test_a31_a_pipe_is_a_usage_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="pipe"):
        ingest([Path("-")], tmp_path / "out.mcap")


def test_a33_odd_topic_names_do_no_harm(target: Path) -> None:
    names = ["/a\nb", "\x1b[31m/red", "\u202e/right", "/" + "long" * 300_000, ""]
    parts = [
        mcaps.channel(i + 1, name, schema=1, encoding="cdr") + mcaps.message(i + 1, 5, b"\0\1\0\0")
        for i, name in enumerate(names)
    ]
    target.write_bytes(mcaps.whole(SCAN_SCHEMA, *parts))
    with open_log(target, max_loss=1.0) as log:
        assert set(log.topics) == set(names)
        assert log.topics[""].problem == "E121 topic without a name"


def test_b1_messages_out_of_log_time_order_are_put_in_order(target: Path) -> None:
    times = [0, 3 * STEP_NS, STEP_NS, 2 * STEP_NS, 4 * STEP_NS]
    write_log(target, scans(times))
    with open_log(target, strict=True) as log:
        assert ranges(log) == [1.0, 3.0, 4.0, 2.0, 5.0]


def test_b2_a_late_message_is_skipped_and_counted(target: Path) -> None:
    stamps = [0, 2 * STEP_NS, STEP_NS, 3 * STEP_NS]
    write_log(target, scans(stamps, [0, 1, 2, 3]))
    with pytest.raises(LossError, match="1 E201"):
        open_log(target)
    with open_log(target, max_loss=0.5) as log:
        assert ranges(log) == [1.0, 2.0, 4.0]
        assert count(log) == {"E201": 1}
        assert [reference.index for reference in log.references()] == [0, 1, 3]


def test_b3_equal_stamps_keep_their_order_and_are_noted(target: Path) -> None:
    write_log(target, scans([0, STEP_NS, STEP_NS, 2 * STEP_NS]))
    with open_log(target) as log:
        assert ranges(log) == [1.0, 2.0, 3.0, 4.0]
        assert log.ledger.notes["B3"] == 1


@pytest.mark.parametrize("row", ["B4", "B11"])
def test_a_clock_that_jumps_back_makes_the_log_go_by_log_time(row: str, target: Path) -> None:
    back = [0, STEP_NS, 2 * STEP_NS] if row == "B11" else [0, -9 * 10**9, -8 * 10**9]
    stamps = [i * STEP_NS for i in range(5)] + [STEP_NS + b for b in back]
    stamps = [20 * 10**9 + s for s in stamps] if row == "B4" else [*stamps[:4], 5 * 10**9, *back]
    write_log(target, scans(stamps, [i * STEP_NS for i in range(len(stamps))]))
    with open_log(target, strict=True) as log:
        assert ranges(log) == [1.0 + i for i in range(len(stamps))]
        assert log.ledger.notes["E202"] == 1
        assert "jump back by more than a second" in log.ledger.remarks["E202"]


def test_b5_exact_duplicates_are_dropped_and_same_stamps_with_other_bytes_kept(
    target: Path,
) -> None:
    def fill(writer: LogWriter) -> None:
        for range_m in (1.0, 1.0, 2.0, 1.0):
            writer.scan(START_NS, scan(range_m=range_m))

    write_log(target, fill)
    with open_log(target, strict=True) as log:
        assert ranges(log) == [1.0, 2.0]
        assert count(log)["duplicate"] == 2


def test_b6_a_few_zero_stamps_are_skipped(target: Path) -> None:
    stamps = [-START_NS] + [i * STEP_NS for i in range(9)]
    write_log(target, scans(stamps, [i * STEP_NS for i in range(10)]))
    with open_log(target, max_loss=0.2) as log:
        assert len(ranges(log)) == 9
        assert count(log) == {"E203": 1}


def test_b6_a_slow_clock_that_begins_at_zero_loses_nothing(target: Path) -> None:
    def fill(writer: LogWriter) -> None:
        for i in range(5):
            writer.scan(i * 3 * 10**9, scan(range_m=1.0 + i))

    with open_log(write_log(target, fill), strict=True) as log:
        assert ranges(log) == [1, 2, 3, 4, 5]


def test_b6_mostly_zero_stamps_make_the_log_go_by_log_time(target: Path) -> None:
    write_log(target, scans([-START_NS] * 4, [i * STEP_NS for i in range(4)]))
    with open_log(target, strict=True) as log:
        assert [r.stamp_ns for r in log.references()] == [START_NS + i * STEP_NS for i in range(4)]
        assert log.ledger.notes["B6"] == 1


def test_b8_impossible_stamps_are_skipped(target: Path) -> None:
    payload = bytearray(scan_payload(9.0))
    struct.pack_into("<i", payload, 4, -5)

    def fill(writer: LogWriter) -> None:
        scans([0, STEP_NS])(writer)
        writer.raw("/scan", messages.LASER_SCAN, bytes(payload), 0, START_NS + 2 * STEP_NS)

    write_log(target, fill)
    with open_log(target, max_loss=0.5) as log:
        assert ranges(log) == [1.0, 2.0]
        assert count(log) == {"E204": 1}


def test_b8_log_times_beyond_the_clock_are_skipped(target: Path) -> None:
    late = mcaps.message(1, 2**63 + 5, scan_payload(1.0))
    good = mcaps.message(1, START_NS, scan_payload(2.0))
    target.write_bytes(mcaps.whole(SCAN_SCHEMA, scan_channel(1), late, good))
    with open_log(target, max_loss=0.5) as log:
        assert ranges(log) == [2.0]
        assert count(log) == {"E204": 1}


def test_b9_streams_that_never_meet_are_refused_with_both_ranges(target: Path) -> None:
    def fill(writer: LogWriter) -> None:
        scans([0, STEP_NS])(writer)
        writer.pan(START_NS + 500 * 10**9, 0.5)

    write_log(target, fill)
    with open_log(target) as log, pytest.raises(FpnavError, match=r"E205 /pan .*nearest 500 s"):
        list(log.frames())
    with open_log(target, {"pan": ""}) as log:
        assert len(ranges(log)) == 2


def test_b10_gaps_are_noted(target: Path) -> None:
    stamps = [i * STEP_NS for i in range(5)] + [10 * 10**9 + i * STEP_NS for i in range(5)]
    write_log(target, scans(stamps))
    with open_log(target) as log:
        assert log.roles["scan"].gaps == 1
        assert log.ledger.remarks["B10"] == "/scan: 1 gaps, the longest 9.6 s"


def test_b12_nanoseconds_survive(target: Path) -> None:
    write_log(target, scans([1, 3, 7]))
    with open_log(target) as log:
        assert [r.stamp_ns - START_NS for r in log.references()] == [1, 3, 7]


@pytest.mark.parametrize("messages_in_log", [0, 1])
def test_b13_one_message_is_enough_and_none_is_refused(messages_in_log: int, target: Path) -> None:
    def fill(writer: LogWriter) -> None:
        writer.odometry(START_NS, Pose2(0, 0, 0))
        scans([0] * messages_in_log)(writer)

    write_log(target, fill)
    with open_log(target) as log:
        if messages_in_log:
            assert ranges(log) == [1.0]
        else:
            with pytest.raises(LogError, match=r"E206 .*nav_msgs/msg/Odometry"):
                next(log.frames())
