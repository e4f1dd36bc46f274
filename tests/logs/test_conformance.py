"""The 416 files of the MCAP conformance suite read as their JSON says."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import pytest
from mcap import records

from fpnav.logs.ledger import Budget, Ledger
from fpnav.logs.reader import LogFile


@pytest.fixture(scope="module")
def pairs(data: Path) -> list[tuple[Path, dict[str, Any]]]:
    """Every file with what it must read as."""
    files = sorted((data / "mcap" / "conformance").rglob("*.mcap"))
    stated = data / "mcap" / "conformance_json"
    return [(path, json.loads((stated / f"{path.stem}.json").read_text())) for path in files]


def _fields(expected: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    """Fields of the expected records of a kind up to the end of the data section."""
    found = []
    for entry in expected["records"]:
        if entry["type"] == "DataEnd":
            break
        if entry["type"] == kind:
            found.append(dict(entry["fields"]))
    return found


def _messages(file: LogFile, ledger: Ledger) -> list[dict[str, Any]]:
    found = []
    for delivery in file.scan(ledger):
        for _, _, offset, length in delivery.messages.tolist():
            channel, sequence, log, publish = struct.unpack_from(
                "<HIQQ", delivery.data, offset - 22
            )
            found.append(
                {
                    "channel_id": str(channel),
                    "data": [str(byte) for byte in delivery.data[offset : offset + length]],
                    "log_time": str(log),
                    "publish_time": str(publish),
                    "sequence": str(sequence),
                }
            )
    return found


def _channel(channel: records.Channel) -> dict[str, Any]:
    return {
        "id": str(channel.id),
        "message_encoding": channel.message_encoding,
        "metadata": channel.metadata,
        "schema_id": str(channel.schema_id),
        "topic": channel.topic,
    }


def _schema(schema: records.Schema) -> dict[str, Any]:
    return {
        "id": str(schema.id),
        "name": schema.name,
        "encoding": schema.encoding,
        "data": [str(byte) for byte in schema.data],
    }


def _statistics(expected: dict[str, Any]) -> dict[str, Any] | None:
    found = [dict(e["fields"]) for e in expected["records"] if e["type"] == "Statistics"]
    return found[0] if found else None


def _check(path: Path, expected: dict[str, Any]) -> None:
    ledger = Ledger()
    with LogFile(path) as file:
        assert _messages(file, ledger) == _fields(expected, "Message")
        contents = file.contents
        channels = [_channel(c) for c in contents.channels.values()]
        assert channels == _fields(expected, "Channel")
        assert [_schema(s) for s in contents.schemas.values()] == _fields(expected, "Schema")
        for metadata in _fields(expected, "Metadata"):
            assert contents.metadata[metadata["name"]] == metadata["metadata"]
        for attachment in _fields(expected, "Attachment"):
            data = file.attachment(attachment["name"], ledger)
            assert data is not None
            assert [str(byte) for byte in data] == attachment["data"]
        statistics = _statistics(expected)
        if statistics:
            assert contents.summary is not None
            assert contents.summary.statistics is not None
            count = contents.summary.statistics.message_count
            assert str(count) == statistics["message_count"]
        ledger.settle(Budget(strict=True))
        assert ledger.inputs[0].integrity == "verified"
        assert not ledger.notes["E112"]
        assert not ledger.notes["E111"]


def test_every_file_of_the_suite_reads_as_its_json_says(
    pairs: list[tuple[Path, dict[str, Any]]],
) -> None:
    assert len(pairs) == 416
    for path, expected in pairs:
        try:
            _check(path, expected)
        except AssertionError as error:
            raise AssertionError(f"{path.name}: {error}") from error
