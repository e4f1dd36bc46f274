"""Links of scenes over visits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from fpnav.sensing.cues import CUE
from fpnav.systems.gateway.asr import EMPTY, Asr, stable, strongest, united, visited
from fpnav.systems.gateway.params import GatewayParams

PAPER = GatewayParams()
Row = tuple[float, ...]


def cue(x: float, metres: float = 3.0, direction: int = 1, facing: int = 0, long: int = 200) -> Row:
    return (facing, direction, x, 100, 99 + long, 1.0, metres)


def after(*visits: list[Row], facings: int = 1) -> Asr:
    scene = EMPTY
    for rows in visits:
        scene = visited(scene, np.array(rows, CUE), facings, PAPER)
    return scene


def test_a_new_link_starts_at_0_3_and_strengthens() -> None:
    weights = [after(*[[cue(100)]] * visits).links["weight"][0] for visits in (1, 2, 3)]
    assert weights == pytest.approx([0.3, 0.51, 0.657])


def test_a_link_weakens_where_the_cue_is_absent_and_is_forgotten_in_the_end() -> None:
    assert after([cue(100)], []).links["weight"] == pytest.approx([0.21])
    assert len(after([cue(100)], *[[]] * 5).links) == 1
    assert len(after([cue(100)], *[[]] * 6).links) == 0


@pytest.mark.parametrize(
    ("other", "same"),
    [
        (cue(150), True),
        (cue(196), False),
        (cue(150, direction=-1), False),
        (cue(150, metres=9.0), False),
        (cue(150, long=90), False),
        (cue(150, facing=1), False),
    ],
    ids=["near", "far across", "direction", "distance", "length", "facing"],
)
def test_what_makes_a_cue_the_same(other: Row, same: bool) -> None:
    scene = after([cue(100)], [other], facings=3)
    assert len(scene.links) == (1 if same else 2)


def test_a_link_moves_to_the_mean_of_where_it_was_seen() -> None:
    scene = after([cue(100, 3.0)], [cue(110, math.nan)], [cue(120, 3.4)])
    assert len(scene.links) == 2
    assert scene.links["x_px"].tolist() == pytest.approx([110.0, 110.0])
    known = scene.links[~np.isnan(scene.links["distance_m"])]
    assert known["distance_m"] == pytest.approx([3.2])
    assert known["seen"].tolist() == [2]


def test_the_nearest_cue_is_the_same() -> None:
    scene = after([cue(100), cue(130)], [cue(104), cue(128)])
    assert scene.links["x_px"].tolist() == pytest.approx([102.0, 129.0])


def test_only_directions_looked_in_weaken() -> None:
    scene = after([cue(100), cue(100, facing=2)], facings=0b101)
    scene = visited(scene, np.zeros(0, CUE), 0b001, PAPER)
    assert scene.links["weight"].tolist() == pytest.approx([0.21, 0.3])
    assert scene.visits.tolist() == [2, 0, 1, 0, 0, 0, 0, 0]
    assert scene.facings == 0b101


def test_after_one_visit_all_cues_count_and_later_those_seen_twice() -> None:
    assert len(stable(after([cue(100), cue(300)]), PAPER)[0]) == 2
    cues, weights = stable(after([cue(100), cue(300)], [cue(100)]), PAPER)
    assert cues["x_px"].tolist() == [100.0]
    assert cues.dtype == CUE
    assert weights == pytest.approx([0.51])


def test_links_can_weigh_as_often_as_they_were_seen() -> None:
    _, weights = stable(
        after([cue(100), cue(300)], [cue(100), cue(300)], [cue(100)]),
        GatewayParams(weights="count"),
    )
    assert weights == pytest.approx([4 / 5, 3 / 5])


def test_two_scenes_of_one_place_unite() -> None:
    first, second = after([cue(100), cue(300)]), after([cue(110)], [cue(110)])
    scene = united(first, second, PAPER)
    assert scene.visits[0] == 3
    shared = scene.links[scene.links["x_px"] < 200][0]
    assert shared["weight"] == pytest.approx(1 - 0.7 * 0.49)
    assert shared["seen"] == 3
    assert shared["x_px"] == pytest.approx((100 + 2 * 110) / 3)
    lonely = scene.links[scene.links["x_px"] > 200][0]
    assert lonely["weight"] == pytest.approx(0.3 * 0.7**2)


def test_uniting_with_nothing_keeps_everything() -> None:
    first = after([cue(100), cue(300)])
    for scene in (united(first, EMPTY, PAPER), united(EMPTY, first, PAPER)):
        assert scene.links.tobytes() == first.links.tobytes()


def test_the_strongest_links_stay_in_their_order() -> None:
    scene = after([cue(100), cue(200, direction=-1), cue(400)], [cue(100), cue(400)], [cue(400)])
    assert strongest(scene, 2).links["x_px"].tolist() == [100.0, 400.0]
    assert strongest(scene, 9).links.tobytes() == scene.links.tobytes()


def test_links_are_kept_in_one_order_whatever_order_they_came_in() -> None:
    rows: list[Row] = [cue(100), cue(200, direction=-1), cue(400)]
    one: NDArray[np.void] = after(rows).links
    assert one.tobytes() == after(rows[::-1]).links.tobytes()
