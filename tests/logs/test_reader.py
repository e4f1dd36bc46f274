"""The container: every message before the damage, the loss put down, never a silent difference."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from helpers import mcaps
from helpers.mcaps import KINDS, plain_log, read_all

from fpnav.errors import LogError, LossError
from fpnav.logs import limits
from fpnav.logs.container import MAGIC
from fpnav.logs.ledger import Budget, Ledger
from fpnav.logs.reader import LogFile

CRC_KINDS = ("zstd", "lz4", "none", "unchunked-crc")


def write(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


@pytest.fixture
def target(tmp_path: Path) -> Path:
    return tmp_path / "log.mcap"


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_file_gives_every_message_in_order(kind: str, target: Path) -> None:
    found, ledger = read_all(write(target, plain_log(kind)))
    assert [(log_ns, data) for _, log_ns, data in found] == [
        (i, bytes([65 + i]) * 40) for i in range(12)
    ]
    ledger.settle(Budget(strict=True))
    expected = "unverified" if kind in ("unchunked", "no-crc") else "verified"
    assert ledger.inputs[0].integrity == expected


def _cuts(data: bytes, every: int) -> range:
    return range(len(MAGIC), len(data), every)


def _check_cut(target: Path, data: bytes, cut: int, whole: list[tuple[int, int, bytes]]) -> int:
    """Messages saved of a log cut at a byte; they are the first ones, and the loss is told."""
    found, ledger = read_all(write(target, data[:cut]))
    assert found == whole[: len(found)]
    with pytest.raises(LossError, match=r"E102 .* at byte .*--allow-truncated"):
        ledger.settle(Budget())
    assert ledger.inputs[0].integrity == "damaged"
    return len(found)


@pytest.mark.parametrize("kind", KINDS)
def test_a_log_cut_anywhere_gives_what_is_whole_and_says_so(kind: str, target: Path) -> None:
    data = plain_log(kind)
    whole, _ = read_all(write(target, data))
    saved = [_check_cut(target, data, cut, whole) for cut in _cuts(data, 13)]
    assert saved == sorted(saved)
    assert saved[-1] == len(whole)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_log_cut_at_every_byte_gives_what_is_whole(kind: str, target: Path) -> None:
    data = plain_log(kind)
    whole, _ = read_all(write(target, data))
    saved = [_check_cut(target, data, cut, whole) for cut in _cuts(data, 1)]
    assert saved == sorted(saved)


@pytest.mark.parametrize("kind", ["none", "unchunked"])
def test_exactly_the_messages_before_the_cut_are_saved(kind: str, target: Path) -> None:
    data = plain_log(kind)
    whole, _ = read_all(write(target, data))
    ends = [data.index(payload) + len(payload) for _, _, payload in whole]
    for cut in range(ends[0] - 60, ends[-1] + 5, 7):
        found, _ = read_all(write(target, data[:cut]))
        assert len(found) == sum(end <= cut for end in ends), cut


def _check_flip(target: Path, data: bytes, at: int, bits: int) -> bool:
    """Whether a flipped byte was harmless; a difference must be told."""
    whole, _ = read_all(write(target, data))
    broken = bytearray(data)
    broken[at] ^= bits
    try:
        found, ledger = read_all(write(target, bytes(broken)))
    except LogError:
        return False
    if found == whole:
        return True
    told = ledger.inputs[0].integrity != "verified" or ledger.topic("(lost)").lost
    assert told, f"byte {at} ^ {bits:#x}: silently different"
    return False


@pytest.mark.parametrize("kind", CRC_KINDS)
@pytest.mark.parametrize("bits", [0x01, 0x80, 0xFF])
def test_a_flipped_byte_is_harmless_or_told(kind: str, bits: int, target: Path) -> None:
    data = plain_log(kind)
    for at in range(0, len(data), 17):
        _check_flip(target, data, at, bits)


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("kind", CRC_KINDS)
def test_every_flipped_bit_is_harmless_or_told(kind: str, target: Path) -> None:
    data = plain_log(kind, messages=5, size=10)
    for at in range(len(data)):
        for bit in range(8):
            _check_flip(target, data, at, 1 << bit)


@pytest.mark.parametrize("kind", ["unchunked", "no-crc"])
def test_logs_without_a_crc_are_called_unverified(kind: str, target: Path) -> None:
    _, ledger = read_all(write(target, plain_log(kind)))
    assert ledger.inputs[0].integrity == "unverified"
    assert ledger.remarks["A11"] == "unverified (no CRC in file)"


def test_a_file_that_is_not_mcap_is_told_by_its_looks(target: Path) -> None:
    for data, words in (
        (b"", "E101 empty file"),
        (b"#ROSBAG V2.0\n", "a ROS 1 bag"),
        (b"SQLite format 3\x00", "a SQLite file"),
        (b"<!DOCTYPE html><html>", "a web page"),
        (b"\x00" * 64, "all zeros"),
        (b"stamp,file\n1,2\n", "a text file"),
        (b"PK\x03\x04....", "a zip file"),
        (b"\x89MCAP1\r\n", "no format known here"),
    ):
        with pytest.raises(LogError, match=words):
            LogFile(write(target, data))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"gone\.mcap: cannot be opened: No such file"):
        LogFile(tmp_path / "gone.mcap")


def test_a_tail_of_zeros_ends_the_data(target: Path) -> None:
    data = plain_log("unchunked", use_statistics=False)
    end = data.index(b"L" * 40) + 40
    found, ledger = read_all(write(target, data[:end] + b"\x00" * 5000))
    assert len(found) == 12
    assert "opcode 0 is not valid" in ledger.inputs[0].damage


@pytest.mark.parametrize("length", [2**20, 2**40, 2**63, 2**64 - 1])
def test_a_record_longer_than_the_file_ends_the_data(length: int, target: Path) -> None:
    head = MAGIC + mcaps.header() + mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x")
    found, ledger = read_all(write(target, head + struct.pack("<BQ", 5, length) + b"rest"))
    assert found == [(1, 5, b"x")]
    assert f"record says {length:,} bytes, 4 left" in ledger.inputs[0].damage


def test_an_index_that_holds_leads_past_the_damage(target: Path) -> None:
    data = bytearray(plain_log("none"))
    whole, _ = read_all(write(target, bytes(data)))
    first = data.index(b"\x06", 30)
    struct.pack_into("<Q", data, first + 1, 2**60)
    found, ledger = read_all(write(target, bytes(data)))
    assert found == whole
    with pytest.raises(LossError, match="E102 truncated in Chunk"):
        ledger.settle(Budget())


def test_a_damaged_chunk_is_skipped_and_its_index_says_what_it_held(target: Path) -> None:
    data = plain_log("none")
    at = data.index(b"E" * 40)
    broken = data[:at] + b"e" + data[at + 1 :]
    found, ledger = read_all(write(target, broken))
    lost = ledger.topic("(lost)")
    assert len(found) + lost.skipped["E110"] == 12
    assert 0 < lost.skipped["E110"] < 5
    assert ledger.inputs[0].integrity == "damaged"
    ledger.settle(Budget(max_loss=1.0))
    with pytest.raises(LossError, match=r"messages lost \(100.00%; \d E110\), allowed 1.00%"):
        ledger.settle(Budget())


def test_a_damaged_chunk_without_an_index_is_an_uncountable_loss(target: Path) -> None:
    body = mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x")
    bad = mcaps.chunk(body, len(body), crc=1234)
    found, ledger = read_all(write(target, mcaps.whole(bad)))
    assert found == []
    with pytest.raises(LossError, match="E110 a chunk is damaged and no index says what it held"):
        ledger.settle(Budget())


@pytest.mark.parametrize(
    ("code", "stored", "size", "compression"),
    [
        ("E116", b"payload", 7, "brotli"),
        ("E115", b"payload", 8, ""),
        ("E114", b"payload", 6, ""),
        ("E114", b"payload", limits.CHUNK_BYTES + 1, ""),
        ("E114", zstandard.compress(b"\0" * 50_000_000), 1000, "zstd"),
        ("E114", lz4.frame.compress(b"\0" * 50_000_000), 1000, "lz4"),
        ("E115", zstandard.compress(b"\0" * 900), 1000, "zstd"),
        ("E110", b"garbage", 1000, "zstd"),
        ("E110", b"garbage", 1000, "lz4"),
    ],
)
def test_a_chunk_that_lies_is_skipped_with_its_code(
    code: str, stored: bytes, size: int, compression: str, target: Path
) -> None:
    after = mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x")
    lie = mcaps.chunk(stored, size, compression=compression)
    found, ledger = read_all(write(target, mcaps.whole(lie, after)))
    assert found == [(1, 5, b"x")]
    assert code in ledger.notes
    assert ledger.inputs[0].integrity == "damaged"


def test_a_chunk_that_stores_more_than_its_record_is_damaged(target: Path) -> None:
    body = mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x")
    good = bytearray(mcaps.chunk(body, len(body)))
    struct.pack_into("<Q", good, 9 + 32, len(body) + 50)
    found, ledger = read_all(write(target, mcaps.whole(bytes(good))))
    assert found == []
    assert "E110" in ledger.notes


def test_zstd_frames_without_a_size_and_several_frames_are_read(target: Path) -> None:
    body = mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x")
    packer = zstandard.ZstdCompressor(write_content_size=False)
    frames = packer.compress(body[:10]) + packer.compress(body[10:])
    crc = zlib.crc32(body)
    found, ledger = read_all(
        write(target, mcaps.whole(mcaps.chunk(frames, len(body), crc, "zstd")))
    )
    assert found == [(1, 5, b"x")]
    assert ledger.inputs[0].integrity == "verified"


def test_private_and_unknown_records_and_padding_are_skipped(target: Path) -> None:
    odd = mcaps.record(0x80, b"private") + mcaps.record(0x42, b"reserved")
    padded = mcaps.record(4, mcaps.channel(1, "/a")[9:] + b"future fields")
    found, ledger = read_all(write(target, mcaps.whole(odd, padded, mcaps.message(1, 5, b"x"))))
    assert found == [(1, 5, b"x")]
    assert not ledger.inputs[0].damage


def test_attachments_are_sought_over_and_read_when_asked_for(target: Path) -> None:
    def attachment(name: bytes, data: bytes, crc: int | None = None) -> bytes:
        body = struct.pack("<QQ", 0, 0) + mcaps.text(name) + mcaps.text("text/plain")
        body += struct.pack("<Q", len(data)) + data
        return mcaps.record(9, body + struct.pack("<I", zlib.crc32(body) if crc is None else crc))

    write(
        target,
        mcaps.whole(
            attachment(b"../../etc/x", b"never a path"),
            attachment(b"broken", b"data", crc=7),
            attachment(b"\xff\xfe", b"not text"),
            mcaps.channel(1, "/a"),
            mcaps.message(1, 5, b"x"),
        ),
    )
    ledger = Ledger()
    with LogFile(target) as file:
        assert sum(len(d.messages) for d in file.scan(ledger, digest=False)) == 1
        assert [facts.name for facts in file.contents.attachments] == ["../../etc/x", "broken"]
        assert file.attachment("../../etc/x", ledger) == b"never a path"
        assert file.attachment("broken", ledger) is None
        assert file.attachment("none", ledger) is None
    assert ledger.notes["A14"] == 1
    assert ledger.notes["E121"] == 1


def test_huge_attachments_cost_neither_time_nor_memory(target: Path) -> None:
    size = 20 * 10**9
    body = struct.pack("<QQ", 0, 0) + mcaps.text("big") + mcaps.text("") + struct.pack("<Q", size)
    with open(target, "wb") as handle:
        handle.write(MAGIC + mcaps.header())
        handle.write(struct.pack("<BQ", 9, len(body) + size + 4) + body)
        handle.seek(size + 4, 1)
        handle.write(mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x") + mcaps.ending())
    ledger = Ledger()
    with LogFile(target) as file:
        assert sum(len(d.messages) for d in file.scan(ledger, digest=False)) == 1
    assert not ledger.inputs[0].damage


def test_two_definitions_of_one_channel_make_it_ambiguous(target: Path) -> None:
    records = mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x") + mcaps.channel(1, "/other")
    write(target, mcaps.whole(records))
    with LogFile(target) as file:
        list(file.scan(Ledger()))
        assert file.contents.ambiguous == {1}


def test_a_channel_whose_topic_is_not_text_is_noted(target: Path) -> None:
    records = mcaps.channel(1, b"\xff\xfe") + mcaps.message(1, 5, b"x")
    _, ledger = read_all(write(target, mcaps.whole(records)))
    assert ledger.notes["E121"] == 1


def test_a_wrong_summary_crc_is_noted_and_the_summary_not_used(target: Path) -> None:
    data = bytearray(plain_log("zstd"))
    at = data.rindex(b"/a")
    data[at] ^= 0xFF
    found, ledger = read_all(write(target, bytes(data)))
    assert len(found) == 12
    assert ledger.notes["E111"] == 1
    ledger.settle(Budget(strict=True))


def test_a_wrong_data_crc_matters_where_nothing_else_covers_the_messages(target: Path) -> None:
    good = mcaps.channel(1, "/a") + mcaps.message(1, 5, b"x")
    bare = MAGIC + mcaps.header() + good + mcaps.ending(data_crc=99)
    _, ledger = read_all(write(target, bare))
    with pytest.raises(LossError, match="E112 CRC of the data section is wrong"):
        ledger.settle(Budget())
    covered = mcaps.chunk(good, len(good), zlib.crc32(good))
    _, ledger = read_all(write(target, MAGIC + mcaps.header() + covered + mcaps.ending(data_crc=9)))
    ledger.settle(Budget(strict=True))
    assert ledger.notes["E112"] == 1


def test_a_file_that_grows_while_it_is_read_is_refused(target: Path) -> None:
    write(target, plain_log("none"))
    with LogFile(target) as file:
        deliveries = file.scan(Ledger())
        next(deliveries)
        with open(target, "ab") as handle:
            handle.write(b"more")
        with pytest.raises(LogError, match="E120 changed while it was read"):
            list(deliveries)


def test_a_block_can_be_loaded_again(target: Path) -> None:
    write(target, plain_log("none", messages=20, size=5000))
    with LogFile(target) as file:
        delivered = [(d.number, d.data) for d in file.scan(Ledger())]
        assert all(file.load(number) == data for number, data in delivered)
        broken = bytearray(target.read_bytes())
        broken[file.contents.blocks[1].offset + 5] ^= 0xFF
        target.write_bytes(bytes(broken))
        with pytest.raises(LogError, match="E120 changed"):
            file.load(1)


def test_the_digest_is_that_of_the_whole_file(target: Path) -> None:
    import hashlib

    data = plain_log("zstd")
    _, ledger = read_all(write(target, data))
    assert ledger.inputs[0].sha256 == hashlib.sha256(data).hexdigest()
