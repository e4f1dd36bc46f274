"""Scans read by the index equal those read from front to back, and damage is never silent."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from helpers.logs import START_NS, STEP_NS, drive, log_bytes, scan, write_log
from helpers.mcaps import record
from mcap.records import ChunkIndex

from fpnav.errors import LogError
from fpnav.logs import fast
from fpnav.logs.fast import read_scans
from fpnav.logs.writer import LogWriter


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fpnav.logs.writer.CHUNK_BYTES", 4000)


def scans(writer: LogWriter) -> None:
    for i in range(60):
        writer.scan(START_NS + i * STEP_NS, scan(20, range_m=1.0 + i))
        if i < 30:
            writer.scan(START_NS + i * STEP_NS, scan(20, range_m=99.0), topic="/other")


def first_ranges(path: Path, *window: int) -> list[float]:
    return [
        float(r) for found in read_scans(path, ["/scan"], *window) for r in found.ranges_m[:, 0]
    ]


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
@pytest.mark.parametrize("walked_below", [0, 1000])
@pytest.mark.parametrize("batch", [1, 10_000, 2**20])
def test_all_scans_come_in_order(
    compression: str,
    walked_below: int,
    batch: int,
    tmp_path: Path,
    small_chunks: None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(fast, "_WALKED_BELOW", walked_below)
    monkeypatch.setattr(fast, "_BATCH_BYTES", batch)
    path = write_log(tmp_path / "a.mcap", scans, compression)
    found = list(read_scans(path, ["/scan"]))
    stamps = np.concatenate([block.stamps_ns for block in found])
    assert stamps.tolist() == [START_NS + i * STEP_NS for i in range(60)]
    assert first_ranges(path) == [1.0 + i for i in range(60)]
    assert {block.frame_id for block in found} == {"scan"}


def test_a_window_of_time_reads_its_chunks_alone(
    tmp_path: Path, small_chunks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_log(tmp_path / "a.mcap", scans)
    read: list[int] = []
    located = fast._ChunkReader.located

    def count(self: fast._ChunkReader, chunk: ChunkIndex) -> fast.Located:
        read.append(chunk.chunk_start_offset)
        return located(self, chunk)

    monkeypatch.setattr(fast._ChunkReader, "located", count)
    window = (START_NS + 40 * STEP_NS, START_NS + 50 * STEP_NS)
    assert first_ranges(path, *window) == [1.0 + i for i in range(40, 50)]
    few = len(read)
    list(read_scans(path, ["/scan"]))
    assert few < len(read) - few


def index_of(data: bytes, channel: int, entries: list[tuple[int, int]]) -> dict[int, np.ndarray]:
    return {channel: np.array(entries, dtype=fast._ENTRY)}


def message(channel: int, log_ns: int, data: bytes = b"payload") -> bytes:
    return record(5, struct.pack("<HIQQ", channel, 0, log_ns, log_ns) + data)


def test_an_index_is_believed_only_where_it_accounts_for_every_byte() -> None:
    first, second = message(1, 10), message(1, 20)
    head = record(3, b"schema")
    data = head + first + second
    at = len(head)
    right = [(10, at), (20, at + len(first))]
    found = fast.indexed(data, index_of(data, 1, right), {1})
    assert found == [(10, at + 31, 7), (20, at + len(first) + 31, 7)]
    assert found == fast.walked(data, {1})
    for wrong in (
        right[:1],  # one message is not in the index
        [(10, at), (21, at + len(first))],  # another time
        [(10, at), (20, at + len(first) + 1)],  # between two records
        [(10, at), (20, 10**9)],  # outside of the chunk
        [(10, at), (20, 2**63)],
        [*right, right[0]],  # one message twice
        [],
    ):
        assert fast.indexed(data, index_of(data, 1, wrong), {1}) is None, wrong
    assert fast.indexed(data, index_of(data, 2, right), {2}) is None


def test_a_chunk_whose_index_is_wrong_is_walked(
    tmp_path: Path, small_chunks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fast, "_WALKED_BELOW", 0)
    data = bytearray(log_bytes(scans, "none"))
    path = tmp_path / "a.mcap"
    at = data.index(b"\x07", data.index(b"\x06"))
    stop = data.rindex(b"\x0f\x04\0\0\0\0\0\0\0")
    while (at := data.find(b"\x07", at + 1)) != -1 and at < stop:
        (length,) = struct.unpack_from("<Q", data, at + 1)
        if 6 <= length < 600 and (length - 6) % 16 == 0:
            data[at + 9 + 6 + 8] ^= 0x0F
    path.write_bytes(bytes(data))
    assert first_ranges(path) == [1.0 + i for i in range(60)]


def test_a_damaged_chunk_is_an_error_that_says_where(tmp_path: Path, small_chunks: None) -> None:
    data = bytearray(log_bytes(scans, "none"))
    data[data.index(struct.pack("<f", 7.0))] ^= 0x01
    (tmp_path / "a.mcap").write_bytes(bytes(data))
    with pytest.raises(LogError, match="E110 chunk CRC is wrong in the chunk at byte"):
        first_ranges(tmp_path / "a.mcap")


def test_what_has_no_index_and_what_carries_no_scans_is_refused(tmp_path: Path) -> None:
    path = write_log(tmp_path / "a.mcap", drive)
    with pytest.raises(LogError, match="/odom does not carry sensor_msgs/msg/LaserScan"):
        list(read_scans(path, ["/odom"]))
    with pytest.raises(LogError, match="no topic /gone"):
        list(read_scans(path, ["/gone"]))
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(LogError, match="no chunk index that holds"):
        list(read_scans(path, ["/scan"]))
