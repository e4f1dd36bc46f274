"""The header of a file, and the refusal of what does not fit, with both sides named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fpnav import __version__
from fpnav.errors import StoreError
from fpnav.store.header import (
    FORMAT_VERSION,
    MAP,
    RESULT,
    SIGNATURES,
    check_header,
    check_same_signatures,
    make_header,
    source_of,
)

FILE = Path("some") / "x.h5"


def header(system: str = "toy", **params: Any) -> dict[str, Any]:
    return make_header(SIGNATURES, system=system, preset="default", params=params, sources=[])


def refused(found: dict[str, Any], kind: str = SIGNATURES) -> str:
    with pytest.raises(StoreError) as caught:
        check_header(FILE, found, kind)
    return str(caught.value)


def test_a_header_says_what_the_file_is_and_what_it_was_made_of(tmp_path: Path) -> None:
    source = tmp_path / "drive.mcap"
    source.write_bytes(b"abc")
    first = header(theta=0.5)
    second = make_header(
        MAP, system="toy", preset="paper", params={}, sources=[source_of(source)],
        chain=[first], guided=True,
    )  # fmt: skip
    assert second == {
        "format": "fpnav/map",
        "format_version": FORMAT_VERSION,
        "fpnav": __version__,
        "system": "toy",
        "preset": "paper",
        "params": {},
        "sources": [{"name": "drive.mcap", "sha256": second["sources"][0]["sha256"], "bytes": 3}],
        "chain": [first],
        "guided": True,
    }
    assert second["sources"][0]["sha256"].startswith("ba7816bf8f01cfea")
    assert str(tmp_path) not in json.dumps(second)


def test_headers_of_every_kind_pass_as_what_they_are() -> None:
    for kind in (SIGNATURES, MAP, RESULT):
        check_header(FILE, {**header(), "format": kind}, kind)


def test_a_file_of_another_kind_is_refused_by_name() -> None:
    assert refused(header(), MAP) == f"{FILE}: is 'fpnav/signatures', expected 'fpnav/map'"
    assert refused({}) == f"{FILE}: is None, expected 'fpnav/signatures'"


@pytest.mark.parametrize("version", [0, FORMAT_VERSION + 1, None, "1"])
def test_a_file_of_another_layout_is_refused_with_both_versions(version: object) -> None:
    said = refused({**header(), "format_version": version})
    assert f"format version {version}, this fpnav {__version__} reads {FORMAT_VERSION}" in said


@pytest.mark.parametrize(
    ("name", "value"),
    [("system", 3), ("preset", None), ("params", []), ("sources", {}), ("chain", "x")],
)
def test_a_header_that_lacks_its_fields_is_refused(name: str, value: object) -> None:
    assert f"header field '{name}' is missing" in refused({**header(), name: value})
    lacking = {key: member for key, member in header().items() if key != name}
    assert f"header field '{name}' is missing" in refused(lacking)


def test_files_made_alike_may_be_joined() -> None:
    check_same_signatures(header(theta=0.5), header(theta=0.5), ("a", "b"), ())


def test_files_of_two_systems_are_not_joined() -> None:
    with pytest.raises(StoreError, match=r"the map was made with system 'toy', q\.h5 with 'gate'"):
        check_same_signatures(header(), header("gate"), ("the map", "q.h5"), ())


def test_files_of_two_parameters_are_not_joined_and_both_values_are_said() -> None:
    with pytest.raises(StoreError, match=r"m\.h5 has toy\.theta=0\.5, q\.h5 has 0\.75"):
        check_same_signatures(header(theta=0.5), header(theta=0.75), ("m.h5", "q.h5"), ())


def test_a_file_of_a_version_without_a_parameter_is_told_from_one_of_another_value() -> None:
    with pytest.raises(StoreError, match=r"m\.h5 was made by a version .* had no toy\.theta; make"):
        check_same_signatures(header(), header(theta=0.75), ("m.h5", "q.h5"), ())


def test_parameters_that_act_late_may_differ() -> None:
    check_same_signatures(header(theta=0.5), header(theta=0.75), ("a", "b"), {"theta"})
