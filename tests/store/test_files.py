"""Signature, map and result files: equal after a round trip, refused when foreign or damaged."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from helpers import stores
from helpers.stores import (
    MAP_HEADER,
    PARTS,
    RESULT_HEADER,
    SIGNATURES_HEADER,
    built_map,
    contents,
    edited,
    flips,
    replaced,
    result,
    table,
    truncations,
)
from helpers.toy_system import RECORD, drive

from fpnav.errors import StoreError
from fpnav.store.maps import read_graph, read_map, write_map
from fpnav.store.results import read_header, read_result, write_result
from fpnav.store.signatures import (
    collect,
    ragged_to_texts,
    read_signatures,
    texts_to_ragged,
    write_signatures,
)

Read = Callable[[Path], Any]


def read_toy_signatures(path: Path) -> Any:
    return read_signatures(path, RECORD, PARTS)


def read_toy_map(path: Path) -> Any:
    return read_map(path, RECORD, PARTS)


@pytest.fixture
def sigs(tmp_path: Path) -> Path:
    path = tmp_path / "sigs.h5"
    write_signatures(path, SIGNATURES_HEADER, table())
    return path


@pytest.fixture
def map_file(tmp_path: Path) -> Path:
    path = tmp_path / "map.h5"
    write_map(path, MAP_HEADER, built_map())
    return path


@pytest.fixture
def result_file(tmp_path: Path) -> Path:
    path = tmp_path / "result.h5"
    write_result(path, result(pairs=True))
    return path


@pytest.fixture(params=["sigs", "map_file", "result_file"])
def any_file(request: pytest.FixtureRequest) -> tuple[Path, Read]:
    reads = {"sigs": read_toy_signatures, "map_file": read_toy_map, "result_file": read_result}
    return request.getfixturevalue(request.param), reads[request.param]


def refused(read: Read, path: Path) -> str:
    with pytest.raises(StoreError) as caught:
        read(path)
    assert path.name in str(caught.value)
    return str(caught.value)


def test_signatures_come_back_as_they_were(sigs: Path) -> None:
    assert contents(read_toy_signatures(sigs)) == contents(table())
    assert read_header(sigs) == SIGNATURES_HEADER


def test_a_map_comes_back_as_it_was_with_what_was_learned(map_file: Path) -> None:
    found, made = read_toy_map(map_file), built_map()
    assert contents(found) == contents(made)
    assert found.memory["scalar"].shape == ()
    assert found.topomap.places[0].label == "hall"
    assert read_header(map_file) == MAP_HEADER


@pytest.mark.parametrize("pairs", [False, True])
def test_a_result_comes_back_as_it_was(tmp_path: Path, pairs: bool) -> None:
    made = result(pairs=pairs)
    write_result(tmp_path / "r.h5", made)
    found = read_result(tmp_path / "r.h5")
    assert contents(found) == contents(made)
    assert found.view.strips == ("ab", "ä→\x00")


def test_no_signatures_at_all_come_back(tmp_path: Path) -> None:
    write_signatures(tmp_path / "s.h5", SIGNATURES_HEADER, collect([], RECORD, PARTS))
    assert len(read_toy_signatures(tmp_path / "s.h5")) == 0


def test_the_graph_alone_is_read_whatever_system_made_it(map_file: Path) -> None:
    assert contents(read_graph(map_file)) == contents(built_map().topomap)


def test_the_same_input_gives_the_same_bytes(
    sigs: Path, map_file: Path, result_file: Path, tmp_path: Path
) -> None:
    again = tmp_path / "again.h5"
    write_signatures(again, dict(reversed(SIGNATURES_HEADER.items())), table())
    assert again.read_bytes() == sigs.read_bytes()
    write_map(again, MAP_HEADER, built_map())
    assert again.read_bytes() == map_file.read_bytes()
    write_result(again, result(pairs=True))
    assert again.read_bytes() == result_file.read_bytes()


@pytest.mark.parametrize(
    "surroundings",
    [
        {"PYTHONHASHSEED": "1", "TZ": "Asia/Kathmandu"},
        {"PYTHONHASHSEED": "77", "LC_ALL": "C", "PYTHONOPTIMIZE": "1"},
    ],
    ids=["zone", "locale"],
)
def test_surroundings_change_no_byte(
    sigs: Path, map_file: Path, tmp_path: Path, surroundings: dict[str, str]
) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    code = (
        "from helpers.stores import *\n"
        "from fpnav.store.maps import write_map\n"
        "from fpnav.store.signatures import write_signatures\n"
        "write_signatures(Path('sigs.h5'), SIGNATURES_HEADER, table())\n"
        "write_map(Path('map.h5'), MAP_HEADER, built_map())\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(stores.__file__).parents[1])}
    subprocess.run(
        [sys.executable, "-c", code],
        cwd=elsewhere, env={**environment, **surroundings}, check=True, timeout=60,
    )  # fmt: skip
    for made in (sigs, map_file):
        assert (elsewhere / made.name).read_bytes() == made.read_bytes()


def test_texts_come_back_whatever_they_are() -> None:
    texts = ("", "a", "ä→𝄞", "nul\x00", "line\nfeed")
    assert ragged_to_texts(texts_to_ragged(texts)) == texts
    assert ragged_to_texts(texts_to_ragged([])) == ()


def test_a_file_is_not_read_as_another_kind(sigs: Path, map_file: Path, result_file: Path) -> None:
    kinds = {"signatures": sigs, "map": map_file, "result": result_file}
    reads = {"signatures": read_toy_signatures, "map": read_toy_map, "result": read_result}
    for is_a, path in kinds.items():
        for wanted, read in reads.items():
            if is_a != wanted:
                said = refused(read, path)
                assert f"is 'fpnav/{is_a}', expected 'fpnav/{wanted}'" in said


def test_signatures_of_another_system_are_refused(sigs: Path) -> None:
    other = np.dtype([("heading_rad", "<f8")])
    with pytest.raises(StoreError, match=r"sigs\.h5: /records: type .*, expected"):
        read_signatures(sigs, other, PARTS)
    with pytest.raises(StoreError, match="/parts/cues: missing"):
        read_signatures(sigs, RECORD, {"cues": RECORD})


def test_a_file_cut_anywhere_is_refused(any_file: tuple[Path, Read]) -> None:
    path, read = any_file
    for _ in truncations(path, 397):
        refused(read, path)


def test_no_flipped_bit_is_read_as_another_content(any_file: tuple[Path, Read]) -> None:
    assert not any(_silent(*any_file, 100))


@pytest.mark.slow
def test_none_of_many_flipped_bits_is_read_as_another_content(any_file: tuple[Path, Read]) -> None:
    assert not any(_silent(*any_file, 1500))


def _silent(path: Path, read: Read, count: int) -> Iterator[bool]:
    sound = contents(read(path))
    for _ in flips(path, count):
        try:
            yield contents(read(path)) != sound
        except StoreError:
            yield False


@pytest.mark.parametrize(
    "offsets", [[0, 2, 2], [1, 2, 2, 5], [0, 2, 2, 4], [0, 3, 2, 5], [0, -1, 6, 5], []]
)
def test_offsets_that_do_not_fit_the_rows_are_refused(sigs: Path, offsets: list[int]) -> None:
    replaced(sigs, "parts/bins/offsets", np.array(offsets, dtype=np.int64))
    said = refused(read_toy_signatures, sigs)
    assert "offsets do not fit the rows" in said or "columns of unequal length" in said


def test_columns_of_unequal_length_are_refused(sigs: Path) -> None:
    replaced(sigs, "records", table().records[:2])
    assert "columns of unequal length [2, 3]" in refused(read_toy_signatures, sigs)


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("edges", np.zeros(1), "type float64"),
        ("novelty", np.zeros(2), "2 novelties of 8 signatures"),
        ("threshold", np.zeros(0), "0 values, expected one"),
        ("members/flat", np.full(8, 99), "member 99 of 8 signatures"),
        ("members/flat", np.zeros(8, dtype=np.int64), "signature 0 belongs to two places"),
        ("members/offsets", np.array([0, 8]), "places, 1 lists of members"),
        ("header", np.frombuffer(b"{}", np.uint8), "is None, expected 'fpnav/map'"),
    ],
)
def test_a_map_that_does_not_fit_together_is_refused(
    map_file: Path, name: str, values: np.ndarray[Any, Any], said: str
) -> None:
    replaced(map_file, name, values)
    assert said in refused(read_toy_map, map_file)


def test_a_map_with_doubled_places_or_dangling_edges_is_refused(map_file: Path) -> None:
    def double(file: h5py.File) -> None:
        file["places"][1] = file["places"][0]

    def dangle(file: h5py.File) -> None:
        edges = file["edges"][()]
        edges["target"][0] = 77
        file["edges"][...] = edges

    sound = map_file.read_bytes()
    for edit, said in ((double, "two places have the id 0"), (dangle, "edge to place 77")):
        edited(map_file, edit)
        assert said in refused(read_toy_map, map_file)
        assert said in refused(read_graph, map_file)
        map_file.write_bytes(sound)


def test_a_map_that_breaks_an_invariant_is_not_written(tmp_path: Path) -> None:
    made = built_map()
    fewer = type(made)(
        made.topomap, collect(drive([0]), RECORD, PARTS), made.novelty, 0.5, made.memory
    )
    with pytest.raises(StoreError, match="member 1 of 1 signatures"):
        write_map(tmp_path / "m.h5", MAP_HEADER, fewer)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("scores", np.zeros((2, 3)), "shape (2, 3), expected 2 along k"),
        ("decision", np.zeros(3, dtype=np.int64), "shape (3,), expected 2 along Q"),
        ("owner", np.zeros(2, dtype=np.int64), "expected 3 along R"),
        ("relative", np.zeros((2, 2)), "expected 3 along 3"),
        ("places", np.zeros(2, dtype=np.int64), "expected 2 dimensions"),
        ("view/extent_m", np.zeros(3), "shape (3,), expected 2 along P"),
        ("view/threshold", np.zeros(2), "2 values, expected one"),
        ("truth/facts", np.frombuffer(b"{}", np.uint8), "truth of unknown kind None"),
        ("query_strips/offsets", np.array([0, 9]), "offsets do not fit"),
    ],
)
def test_a_result_that_does_not_fit_together_is_refused(
    result_file: Path, name: str, values: np.ndarray[Any, Any], said: str
) -> None:
    replaced(result_file, name, values)
    assert said in refused(read_result, result_file)


def test_accepted_pairs_that_are_missing_or_linked_away_are_refused(result_file: Path) -> None:
    def unlink(file: h5py.File) -> None:
        del file["truth/pairs"]

    def link(file: h5py.File) -> None:
        file["truth/pairs"] = h5py.ExternalLink("elsewhere.h5", "/pairs")

    edited(result_file, unlink)
    assert "truth of unknown kind 'pairs'" in refused(read_result, result_file)
    edited(result_file, link)
    assert "/truth/pairs: a link is refused" in refused(read_result, result_file)


def test_a_header_is_read_of_any_kind_and_of_nothing_else(
    any_file: tuple[Path, Read], tmp_path: Path
) -> None:
    assert read_header(any_file[0])["system"] == "toy"
    foreign = tmp_path / "foreign.h5"
    with h5py.File(foreign, "w"):
        pass
    assert "header: missing" in refused(read_header, foreign)
    assert RESULT_HEADER["format"] == "fpnav/result"
