"""Features, correspondences, empty space and the readable string."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fpnav.errors import UsageError
from fpnav.systems.fingerprint.symbols import (
    ALPHABET,
    codes,
    features_of,
    parse,
    symbols_of,
    text,
)

TAU = 2.0 * math.pi
PAPER = "cIfvncvfnvncvnnvcvBnvBccE"
EVERYWHERE = np.array([[0.0, TAU], [0.0, TAU]])
FEATURES = st.lists(
    st.tuples(
        st.sampled_from("vcABCP"), st.integers(0, 3599).map(lambda at: at / 10), st.floats(0.1, 1.0)
    ),
    max_size=20,
    unique_by=lambda row: row[1],
)


def features(*rows: tuple[str, float, float]) -> np.ndarray:
    """FEATURE rows of (letter, degrees, certainty)."""
    letters = np.array([letter for letter, _, _ in rows], dtype="S1")
    degrees = np.array([angle for _, angle, _ in rows], dtype=float)
    return features_of(letters, np.radians(degrees), np.array([u for _, _, u in rows], dtype=float))


def inserted(rows: np.ndarray, arcs: np.ndarray = EVERYWHERE) -> np.ndarray:
    return symbols_of(
        rows, arcs, pair_rad=math.radians(3.0), delta_rad=math.radians(20.0), certainty_n=0.5
    )


def test_the_papers_string_is_25_symbols_with_its_counts() -> None:
    rows = parse(PAPER)
    assert len(rows) == 25
    counts = {letter: text(rows).count(letter) for letter in "vcnfBIE"}
    assert counts == {"v": 7, "c": 6, "n": 6, "f": 2, "B": 2, "I": 1, "E": 1}


def test_a_string_that_is_parsed_prints_as_it_was() -> None:
    assert text(parse(PAPER)) == PAPER
    assert text(parse("")) == ""
    assert text(parse(ALPHABET)) == ALPHABET


@pytest.mark.parametrize("wrong", ["cIfQ", "c v", "é"])
def test_other_letters_are_refused_by_name(wrong: str) -> None:
    with pytest.raises(UsageError, match=r"is no fingerprint"):
        parse(wrong)


def test_codes_number_the_alphabet() -> None:
    assert codes(np.frombuffer(ALPHABET.encode(), "S1")).tolist() == list(range(20))


def test_a_corner_and_an_edge_that_meet_get_a_correspondence_and_stay() -> None:
    rows = inserted(features(("c", 100.0, 0.4), ("v", 102.0, 0.9)))
    pair = rows[rows["type"] == b"f"]
    assert text(rows).replace("n", "") == "cfv"
    assert math.degrees(pair["angle_rad"][0]) == pytest.approx(101.0)
    assert pair["certainty"][0] == pytest.approx(0.6)


def test_a_corner_is_paired_once_with_the_nearest_edge() -> None:
    rows = inserted(features(("v", 8.0, 1.0), ("c", 10.0, 1.0), ("v", 11.0, 1.0), ("v", 12.9, 1.0)))
    pair = rows[rows["type"] == b"f"]
    assert len(pair) == 1
    assert math.degrees(pair["angle_rad"][0]) == pytest.approx(10.5)


def test_pairs_beyond_three_degrees_do_not_correspond() -> None:
    assert "f" not in text(inserted(features(("c", 10.0, 1.0), ("v", 13.1, 1.0))))


def test_a_correspondence_may_span_the_heading() -> None:
    rows = inserted(features(("c", 359.5, 1.0), ("v", 1.5, 1.0)))
    pair = rows[rows["type"] == b"f"]
    assert math.degrees(pair["angle_rad"][0]) == pytest.approx(0.5)


def test_features_at_one_angle_stand_in_the_order_c_colour_v_f() -> None:
    rows = inserted(features(("v", 50.0, 1.0), ("I", 50.1, 1.0), ("c", 50.2, 1.0)))
    assert text(rows).strip("n") == "cIvf"


@pytest.mark.parametrize(("gap", "count"), [(19.9, 0), (20.0, 1), (39.0, 1), (41.0, 2), (120.0, 6)])
def test_empty_space_is_one_n_per_twenty_degrees_evenly_inside_the_gap(
    gap: float, count: int
) -> None:
    rows = inserted(features(("v", 0.0, 1.0), ("v", gap, 1.0)))
    angles = np.degrees(rows["angle_rad"])
    inside = angles[(rows["type"] == b"n") & (angles < gap)]
    assert inside == pytest.approx(gap * np.arange(1, count + 1) / (count + 1))
    assert (rows["certainty"][rows["type"] == b"n"] == 0.5).all()


def test_a_place_without_features_is_empty_all_round() -> None:
    assert text(inserted(features())) == "n" * 18
    assert text(inserted(features(), np.zeros((2, 2)))) == ""


def test_a_single_feature_has_empty_space_all_round() -> None:
    assert text(inserted(features(("A", 90.0, 1.0)))) == "n" * 4 + "A" + "n" * 14


def test_unseen_directions_are_not_empty() -> None:
    half = np.array([[0.0, math.pi], [0.0, 0.0]])
    rows = inserted(features(("c", 10.0, 1.0), ("c", 300.0, 1.0)), half)
    degrees = (np.degrees(rows["angle_rad"]) + 180.0) % 360.0 - 180.0
    assert (np.abs(degrees) <= 90.0).all()
    assert text(rows).count("n") >= 4


def test_the_string_starts_at_the_heading_counter_clockwise() -> None:
    rows = inserted(features(("A", 5.0, 1.0), ("B", 95.0, 1.0), ("C", 275.0, 1.0)))
    assert text(rows).replace("n", "") == "ABC"
    assert text(rows)[0] == "A"


@given(FEATURES)
def test_inserting_again_changes_nothing(rows: list[tuple[str, float, float]]) -> None:
    own = features(*rows)
    once = inserted(own)
    kept = own[once["feature"][once["feature"] >= 0]]
    again = inserted(kept)
    assert text(again) == text(once)
    assert np.array_equal(again["angle_rad"], once["angle_rad"])


@given(FEATURES)
def test_every_feature_is_in_the_string_once_and_knows_its_row(
    rows: list[tuple[str, float, float]],
) -> None:
    own = features(*rows)
    found = inserted(own)
    linked = found[found["feature"] >= 0]
    assert sorted(linked["feature"]) == list(range(len(own)))
    assert np.array_equal(linked["type"], own["type"][linked["feature"]])
    assert set(found["type"][found["feature"] < 0]) <= {b"f", b"n"}
    assert ((found["angle_rad"] >= 0.0) & (found["angle_rad"] < TAU)).all()
