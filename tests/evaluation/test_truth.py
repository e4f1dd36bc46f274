"""Ground truth files: what is accepted, what is repaired and counted, what is refused and how."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.errors import TruthError
from fpnav.evaluation.truth import pairs_to_rows, poses_at, read_pairs, read_tum


def tum(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "truth.tum"
    path.write_bytes(data)
    return path


def test_a_tum_row_becomes_a_planar_pose_at_its_exact_nanosecond(tmp_path: Path) -> None:
    half = math.sqrt(0.5)
    path = tum(tmp_path, f"1700000000.123456789 1.5 -2 9 0 0 {half} {half}\n".encode())
    track = read_tum(path)
    assert track.stamps_ns.tolist() == [1_700_000_000_123_456_789]
    assert track.poses[0] == pytest.approx([1.5, -2.0, math.pi / 2])


@pytest.mark.parametrize(
    "data",
    [
        b"\xef\xbb\xbf1.0 1 2 0 0 0 0 1\r\n2.0 2 2 0 0 0 0 1\r\n",
        b"# t x y z\n\n1.0\t1   2 0 0 0 0 1  \n   # more\n2.0 2 2 0 0 0 0 1",
        b"1.0 1 2 0 0 0 0 1\r2.0 2 2 0 0 0 0 1\r",
    ],
    ids=["byte order mark and CRLF", "comments, tabs, trailing blanks, no last newline", "CR"],
)
def test_any_white_space_is_accepted(tmp_path: Path, data: bytes) -> None:
    track = read_tum(tum(tmp_path, data))
    assert track.poses[:, 0].tolist() == [1.0, 2.0]
    assert track.notes == {}


def test_an_unnormalised_quaternion_gives_the_same_heading(tmp_path: Path) -> None:
    track = read_tum(tum(tmp_path, b"1 0 0 0 0 0 2 2\n"))
    assert track.poses[0, 2] == pytest.approx(math.pi / 2)


def test_disorder_duplicates_and_nan_rows_are_repaired_and_counted(tmp_path: Path) -> None:
    rows = (
        b"3 3 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n1 9 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n4 4 0 0 0 0 0 0\n"
    )
    track = read_tum(tum(tmp_path, rows))
    assert track.stamps_ns.tolist() == [10**9, 3 * 10**9]
    assert track.poses[:, 0].tolist() == [1.0, 3.0]
    assert track.notes == {"unsorted": 1, "duplicate": 1, "not_finite": 2}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"1 1 2 0 0 0 0 1\n2 1 2 0 0 0 1\n", r"line 2: 7 columns, expected 8"),
        (b"# ok\n1,5 1 2 0 0 0 0 1\n", r"line 2: commas found"),
        (b"1 1 2 0 0 0 zero 1\n", r"line 1: not eight numbers"),
        (b"inf 1 2 0 0 0 0 1\n", r"line 1: stamp 'inf' is not a time in seconds"),
        (b"1e30 1 2 0 0 0 0 1\n", r"line 1: stamp '1e30'"),
        (b"", r"holds no pose; expected lines 't tx ty tz qx qy qz qw'"),
        (b"1 nan 2 0 0 0 0 1\n", r"holds no pose"),
        (b"1 1 2 0 0 0 0 1\n\xff\xfe\n", r"not text: byte 16 is not UTF-8"),
        (b"1 0 0 1 0 0 1 0 0 1 0 0\n", r"line 1: 12 columns"),
    ],
)
def test_a_bad_file_is_refused_with_its_line(tmp_path: Path, data: bytes, message: str) -> None:
    with pytest.raises(TruthError, match=message) as caught:
        read_tum(tum(tmp_path, data))
    assert "truth.tum" in str(caught.value)


def test_a_missing_file_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(TruthError, match="cannot be read: No such file"):
        read_tum(tmp_path / "none.tum")


@given(data=st.binary(max_size=200))
def test_arbitrary_bytes_give_a_track_or_a_truth_error(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    path = tum(tmp_path_factory.mktemp("tum"), data)
    for read in (read_tum, read_pairs):
        try:
            read(path)
        except TruthError:
            continue


def test_poses_are_interpolated_inside_the_track_and_unknown_outside(tmp_path: Path) -> None:
    path = tum(tmp_path, b"1 0 0 0 0 0 0 1\n3 2 4 0 0 0 0 1\n")
    poses = poses_at(path, read_tum(path), np.array([0, 2 * 10**9], dtype=np.int64))
    assert np.isnan(poses[0]).all()
    assert poses[1].tolist() == [1.0, 2.0, 0.0]


def test_clocks_that_do_not_meet_are_said_not_aligned(tmp_path: Path) -> None:
    path = tum(tmp_path, b"100 0 0 0 0 0 0 1\n103 2 4 0 0 0 0 1\n")
    with pytest.raises(TruthError, match=r"covers 100.000 .. 103.000 s, the run 1.000 .. 2.000 s"):
        poses_at(path, read_tum(path), np.array([10**9, 2 * 10**9], dtype=np.int64))


def pairs_file(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "truth.json"
    path.write_text(text)
    return path


def test_pairs_are_read_as_indices(tmp_path: Path) -> None:
    assert read_pairs(pairs_file(tmp_path, '{"0": [3, 4], "12": []}')) == {0: (3, 4), 12: ()}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2]", "expected an object"),
        ("{}", "at least one query"),
        ('{"0": 3}', r"query '0': expected a list of indices, found 3"),
        ('{"0": [1.5]}', r"reference 1.5 is not an index"),
        ('{"0": [-1]}', r"reference -1 is not an index"),
        ('{"0": [true]}', r"reference True is not an index"),
        ('{"a": [1]}', r"query 'a' is not an index"),
        ('{"0": [1], "0": [2]}', "one query is named twice"),
        ('{"0": [1]', "not JSON"),
        ("[" * 100_000, "nested too deeply"),
    ],
)
def test_pairs_that_are_none_are_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(TruthError, match=message):
        read_pairs(pairs_file(tmp_path, text))


def test_indices_before_thinning_become_rows_after_it(tmp_path: Path) -> None:
    pairs = {0: (4, 6), 4: (2, 2, 8), 6: ()}
    kept = np.array([0, 2, 4, 8])
    rows = pairs_to_rows(tmp_path / "t.json", pairs, kept, kept)
    # query rows 0, 2, 4, 8: reference 6 was thinned away, query 8 is not named
    assert [rows[i].tolist() for i in range(4)] == [[2], [], [1, 3], []]


def test_truth_of_another_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TruthError, match=r"names queries 100 .. 200, none of which is in this run"):
        pairs_to_rows(tmp_path / "t.json", {100: (1,), 200: (2,)}, np.arange(3), np.arange(3))
