"""ROS 1 bags and ROS 2 db3: whole, unindexed, cut, and what is neither."""

from __future__ import annotations

import bz2
import contextlib
import sqlite3
import struct
from pathlib import Path

import numpy as np
import pytest
import zstandard
from helpers.encodings import FRAMES, MOUNT, drive, pose, scan, write_bag, write_db3
from helpers.logs import START_NS, STEP_NS
from rosbags.rosbag1 import Reader as BagReader
from rosbags.rosbag2 import Reader as Bag2Reader

from fpnav.errors import LogError, LossError
from fpnav.logs.bag import MAGIC, BagFile
from fpnav.logs.containers import open_container
from fpnav.logs.db3 import Db3File
from fpnav.logs.frames import Log, open_log
from fpnav.logs.ingest import ingest
from fpnav.logs.ledger import Budget, Ledger


def check_drive(log: Log) -> None:
    """A log of the drive reads as it was sent."""
    frames = list(log.frames())
    assert [frame.reference.stamp_ns - START_NS for frame in frames] == [
        i * STEP_NS for i in range(FRAMES)
    ]
    for i, frame in enumerate(frames):
        assert frame.scan is not None
        assert np.array_equal(frame.scan.ranges_m, scan(i).ranges_m, equal_nan=True)
        assert frame.scan.mount.heading_rad == pytest.approx(MOUNT.heading_rad)
        assert frame.reference.odometry is not None
        assert frame.reference.odometry.x_m == pytest.approx(pose(i).x_m)
        assert frame.reference.truth is not None
        assert frame.camera is not None
        assert frame.camera.pixels.shape == (16, 32, 3)
        assert frame.camera_offset is not None
        assert (frame.camera_offset.pixels == i).all()
        assert frame.sonar is not None
        assert frame.sonar.ranges_m.tolist() == [0.5 + i]
        assert frame.pan_rad == pytest.approx(0.2 * i)
        assert frame.reference.heading_rad == pytest.approx(0.1 * i)
        assert frame.reference.label == f"room {i}"
    assert log.calibrations["camera"].horizontal_fov_rad == pytest.approx(1.2)


def payloads(path: Path) -> tuple[list[tuple[int, bytes]], Ledger]:
    """(log time, payload) of every message, and the ledger."""
    ledger = Ledger()
    file = open_container(path)
    found = []
    for delivery in file.scan(ledger):
        for message in delivery.messages:
            found.append((int(message["log_ns"]), delivery.payload(message)))
        assert file.load(delivery.number) == delivery.data
    file.close()
    return found, ledger


@pytest.mark.parametrize("compression", ["", "BZ2", "LZ4"])
def test_a_bag_reads_as_it_was_sent(compression: str, tmp_path: Path) -> None:
    path = write_bag(tmp_path / "a.bag", compression=compression)
    with open_log(path, strict=True) as log:
        assert log.integrity == "unverified"
        assert log.file.contents.compressions.keys() == {compression.lower() or "none"}
        check_drive(log)
    ingest([path], tmp_path / "b.mcap")
    with open_log(tmp_path / "b.mcap", strict=True) as log:
        assert log.integrity == "verified"
        check_drive(log)


def test_a_bag_holds_what_another_reader_finds(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "a.bag")
    with BagReader(path) as reader:
        expected = [(stamp, bytes(data)) for _, stamp, data in reader.messages()]
    assert sorted(payloads(path)[0]) == sorted(expected)
    assert len(expected) == len(list(drive()))


def test_a_bag_cut_anywhere_gives_what_is_whole_and_says_so(tmp_path: Path) -> None:
    data = write_bag(tmp_path / "a.bag").read_bytes()
    whole, _ = payloads(tmp_path / "a.bag")
    target = tmp_path / "cut.bag"
    saved = []
    for cut in [*range(len(MAGIC), len(data), 97), len(data) - 1]:
        target.write_bytes(data[:cut])
        found, ledger = payloads(target)
        assert found == whole[: len(found)]
        with pytest.raises(LossError, match="E102"):
            ledger.settle(Budget())
        saved.append(len(found))
    assert saved == sorted(saved)
    assert saved[-1] == len(whole)


def test_a_flipped_byte_of_a_bag_never_ends_in_a_traceback(tmp_path: Path) -> None:
    data = write_bag(tmp_path / "a.bag").read_bytes()
    target = tmp_path / "flip.bag"
    for at in range(0, len(data), 61):
        for bits in (0x01, 0x80, 0xFF):
            broken = bytearray(data)
            broken[at] ^= bits
            target.write_bytes(bytes(broken))
            try:
                _, ledger = payloads(target)
            except LogError:
                continue
            assert ledger.inputs[0].integrity != "verified"


def field(name: str, value: bytes) -> bytes:
    data = name.encode() + b"=" + value
    return struct.pack("<I", len(data)) + data


def bag_record(head: list[tuple[str, bytes]], data: bytes) -> bytes:
    fields = b"".join(field(name, value) for name, value in head)
    return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data


def bag_header(index_pos: int = 0) -> bytes:
    head = [
        ("op", b"\x03"),
        ("index_pos", struct.pack("<Q", index_pos)),
        ("conn_count", b"\0" * 4),
        ("chunk_count", b"\0" * 4),
    ]
    return bag_record(head, b" " * 20)


def connection(number: int, topic: str) -> bytes:
    about = field("topic", topic.encode()) + field("type", b"std_msgs/String")
    about += field("md5sum", b"992ce8a1687cec8c8bd883ec73ca41d1")
    about += field("message_definition", b"string data\n")
    head = [("op", b"\x07"), ("conn", struct.pack("<I", number)), ("topic", topic.encode())]
    return bag_record(head, about)


def bag_message(number: int, seconds: int, data: bytes) -> bytes:
    head = [
        ("op", b"\x02"),
        ("conn", struct.pack("<I", number)),
        ("time", struct.pack("<II", seconds, 5)),
    ]
    return bag_record(head, data)


def bag_chunk(stored: bytes, size: int, compression: bytes = b"none") -> bytes:
    head = [("op", b"\x05"), ("compression", compression), ("size", struct.pack("<I", size))]
    return bag_record(head, stored)


def test_the_open_chunk_of_a_killed_recorder_is_read(tmp_path: Path) -> None:
    sent = [bag_message(100_000, i, b"\x01\0\0\0x") for i in range(3)]
    data = MAGIC + bag_header() + bag_chunk(b"", 0) + connection(100_000, "/label") + b"".join(sent)
    (tmp_path / "a.bag.active").write_bytes(data)
    with pytest.raises(LossError, match="E102 the bag was not closed, its recorder was killed"):
        open_log(tmp_path / "a.bag.active")
    with open_log(tmp_path / "a.bag.active", allow_truncated=True) as log:
        assert log.topics["/label"].count.in_file == 3
        assert [str(m.data) for m in log.topics["/label"].objects] == ["x"] * 3
        assert log.topics["/label"].rows["log_ns"].tolist() == [i * 10**9 + 5 for i in range(3)]


@pytest.mark.parametrize(
    ("code", "stored", "size", "compression"),
    [
        ("E116", b"x" * 20, 20, b"rot13"),
        ("E114", bz2.compress(b"\0" * 10**7), 1000, b"bz2"),
        ("E115", bz2.compress(b"\0" * 10), 1000, b"bz2"),
        ("E110", b"no bz2", 1000, b"bz2"),
        ("E110", b"certainly no lz4 frame", 1000, b"lz4"),
        ("E114", b"x", 2**32 - 1, b"none"),
        ("E114", b"x", 2**32 - 1, b"bz2"),
    ],
)
def test_a_bag_chunk_that_lies_is_noted_and_what_follows_is_read(
    code: str, stored: bytes, size: int, compression: bytes, tmp_path: Path
) -> None:
    body = connection(1, "/label") + bag_message(1, 5, b"\x01\0\0\0x")
    parts = [bag_header(1), bag_chunk(stored, size, compression), bag_chunk(body, len(body))]
    (tmp_path / "a.bag").write_bytes(MAGIC + b"".join(parts))
    found, ledger = payloads(tmp_path / "a.bag")
    assert len(found) == 1
    assert ledger.notes[code] == 1
    with pytest.raises(LossError):
        ledger.settle(Budget())


def test_messages_of_a_lost_chunk_are_counted_by_the_index(tmp_path: Path) -> None:
    body = connection(1, "/label") + b"".join(bag_message(1, i, b"\x01\0\0\0x") for i in range(4))
    head = [("op", b"\x06"), ("ver", b"\x01\0\0\0"), ("count", b"\x01\0\0\0")]
    info = bag_record(head, struct.pack("<II", 1, 8))
    parts = [bag_header(1), bag_chunk(body, len(body)), bag_chunk(b"bad", 99, b"bz2"), info]
    (tmp_path / "a.bag").write_bytes(MAGIC + b"".join(parts))
    with open_log(tmp_path / "a.bag", max_loss=0.6) as log:
        count = log.topics["/label"].count
        assert (count.used, count.unread, count.in_file) == (4, 4, 8)


def test_an_old_bag_and_a_file_that_is_none_are_told_apart(tmp_path: Path) -> None:
    (tmp_path / "old.bag").write_bytes(b"#ROSBAG V1.2\nlots of data")
    with pytest.raises(LogError, match=r"#ROSBAG V1.2 is not read, only version 2.0"):
        BagFile(tmp_path / "old.bag")
    (tmp_path / "page.bag").write_bytes(b"<html>")
    with pytest.raises(LogError, match="not a ROS 1 bag, looks like a web page"):
        ingest([tmp_path / "page.bag"], tmp_path / "out.mcap")


@pytest.mark.parametrize("given", ["folder", "file"])
def test_a_db3_reads_as_it_was_sent(given: str, tmp_path: Path) -> None:
    folder = write_db3(tmp_path / "drive")
    file = next(folder.glob("*.db3"))
    with open_log(file, strict=True) as log:
        check_drive(log)
    (folder / "metadata.yaml").unlink()
    ingest([folder if given == "folder" else file], tmp_path / "b.mcap")
    with open_log(tmp_path / "b.mcap", strict=True) as log:
        check_drive(log)


def test_a_db3_holds_what_another_reader_finds(tmp_path: Path) -> None:
    folder = write_db3(tmp_path / "drive")
    with Bag2Reader(folder) as reader:
        expected = [(stamp, bytes(data)) for _, stamp, data in reader.messages()]
    assert sorted(payloads(next(folder.glob("*.db3")))[0]) == sorted(expected)


def rewrite_rows(path: Path, change: str) -> None:
    base = sqlite3.connect(path)
    base.execute(change)
    base.commit()
    base.close()


def test_rows_compressed_one_by_one_are_unpacked(tmp_path: Path) -> None:
    path = next(write_db3(tmp_path / "drive").glob("*.db3"))
    base = sqlite3.connect(path)
    base.create_function("pack", 1, lambda data: zstandard.compress(data))
    base.execute("UPDATE messages SET data = pack(data)")
    base.commit()
    base.close()
    with open_log(path, strict=True) as log:
        check_drive(log)


def test_rows_that_are_damaged_are_counted(tmp_path: Path) -> None:
    path = next(write_db3(tmp_path / "drive").glob("*.db3"))
    rewrite_rows(path, "UPDATE messages SET data = x'28b52ffd00' WHERE id = 5")
    with pytest.raises(LossError, match="1 E11"):
        open_log(path)


def test_a_db3_cut_short_gives_what_is_whole_when_allowed(tmp_path: Path) -> None:
    path = next(write_db3(tmp_path / "drive").glob("*.db3"))
    rewrite_rows(path, "CREATE TABLE filler AS SELECT zeroblob(100000)")
    data = path.read_bytes()
    for share in (0.2, 0.4, 0.6):
        path.write_bytes(data[: int(len(data) * share)])
        with contextlib.suppress(LogError):
            _, ledger = payloads(path)
            assert ledger.inputs[0].integrity in ("unverified", "damaged")


def test_other_sqlite_files_are_refused(tmp_path: Path) -> None:
    base = sqlite3.connect(tmp_path / "other.db3")
    base.execute("CREATE TABLE songs (name TEXT)")
    base.commit()
    base.close()
    with pytest.raises(LogError, match="no ROS 2 bag that can be read: no such table: topics"):
        Db3File(tmp_path / "other.db3")
    (tmp_path / "bad.db3").write_bytes(b"SQLite format 3\x00" + b"\xff" * 200)
    with pytest.raises(LogError, match="E100 SQLite file cannot be read"):
        Db3File(tmp_path / "bad.db3")
    (tmp_path / "empty.db3").write_bytes(b"")
    with pytest.raises(LogError, match="E100 not a SQLite file"):
        Db3File(tmp_path / "empty.db3")


def test_a_db3_shorter_than_its_header_says_is_damaged(tmp_path: Path) -> None:
    path = next(write_db3(tmp_path / "drive").glob("*.db3"))
    rewrite_rows(path, "CREATE TABLE filler AS SELECT zeroblob(100000)")
    path.write_bytes(path.read_bytes()[:-4096])
    with pytest.raises(LossError, match="E102 the database truncated, 4,096 bytes are missing"):
        open_log(path)
    with open_log(path, allow_truncated=True) as log:
        check_drive(log)


@pytest.mark.parametrize(
    "change",
    ["topic_id = NULL", "topic_id = 'scan'", "timestamp = NULL", "timestamp = -5"],
)
def test_cells_that_cannot_be_are_a_loss(change: str, tmp_path: Path) -> None:
    path = next(write_db3(tmp_path / "drive").glob("*.db3"))
    rewrite_rows(path, "CREATE TABLE copies AS SELECT * FROM messages")
    rewrite_rows(path, "DROP TABLE messages")
    rewrite_rows(path, "ALTER TABLE copies RENAME TO messages")
    rewrite_rows(path, f"UPDATE messages SET {change} WHERE id = 5")
    with pytest.raises(LossError, match=r"E102 the database has a message 5 of topic|1 E204"):
        open_log(path)
