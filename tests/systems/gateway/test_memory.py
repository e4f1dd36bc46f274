"""What is learned at gateways, and how it is recalled."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.gateways import cue, gateway

from fpnav.params import resolve
from fpnav.systems.gateway import Gateway, GatewayParams
from fpnav.systems.gateway.evidence import scene_scores, sonar_evidence, vision_evidence
from fpnav.systems.gateway.memory import GatewayMemory
from fpnav.values import Pose2, Signature

RIGHT, ROOM, LEFT = "RIGHT OPENING", "RIGHT ROOM", "LEFT OPENING"
VIEWS = {
    0: (RIGHT, [cue(60), cue(200, direction=-1)]),
    1: (RIGHT, [cue(110), cue(420)]),
    2: (RIGHT, [cue(300, direction=-1), cue(330)]),
    3: (ROOM, [cue(20, direction=-1), cue(470)]),
}


def learned(params: GatewayParams, visits: int = 2) -> GatewayMemory:
    memory = Gateway(params).memory()
    for session in range(visits):
        for place, (kind, cues) in VIEWS.items():
            memory.learn(place, gateway(kind, cues, session=session))
    return memory


def scores(memory: GatewayMemory, *queries: Signature) -> np.ndarray:
    found, _ = memory.recall(list(queries), len(memory.places), None, None)
    out = np.zeros(found.scores.shape)
    np.put_along_axis(out, found.places, found.scores, axis=1)
    return out


@pytest.mark.parametrize("matcher", [1, 2, 3, 4, "soft"])
def test_places_that_sound_alike_are_told_by_sight(matcher: object) -> None:
    memory = learned(resolve("gateway", GatewayParams(), {"gateway": {"matcher": matcher}}))
    for place, (kind, cues) in VIEWS.items():
        found, _ = memory.recall([gateway(kind, cues)], 1, None, None)
        assert found.places[0, 0] == place


def test_the_score_is_the_log_of_the_product() -> None:
    found = scores(learned(GatewayParams()), gateway(ROOM, VIEWS[2][1]))
    assert math.exp(found[0, 2]) == pytest.approx(1.0 * 0.18)
    assert math.exp(found[0, 3]) == pytest.approx(0.1 * 1.0)
    assert math.exp(found[0, 0]) == pytest.approx(0.1 * 0.18)


def test_a_misread_gateway_is_corrected_by_sight() -> None:
    found, _ = learned(GatewayParams()).recall([gateway(ROOM, VIEWS[2][1])], 4, None, None)
    assert found.places[0].tolist() == [2, 3, 0, 1]


def test_a_type_unlike_every_place_leaves_sight_alone_with_a_floor() -> None:
    memory = learned(GatewayParams(smooth=0.01))
    found, _ = memory.recall([gateway(LEFT, VIEWS[1][1])], 1, None, None)
    assert found.places[0, 0] == 1
    assert np.isfinite(scores(learned(GatewayParams()), gateway(LEFT, VIEWS[1][1]))).all()


def test_without_a_camera_places_of_one_type_tie_and_come_by_id() -> None:
    found, _ = learned(GatewayParams()).recall([gateway(RIGHT, facings=0)], 4, None, None)
    assert found.places[0].tolist() == [0, 1, 2, 3]
    assert found.scores[0, 0] == found.scores[0, 1] == found.scores[0, 2] > found.scores[0, 3]


def test_without_sonar_sight_decides_alone() -> None:
    found = scores(learned(GatewayParams()), gateway("", VIEWS[3][1]))
    assert math.exp(found[0, 3]) == pytest.approx(1.0)
    assert found[0].argmax() == 3


def test_powers_weigh_the_two_senses() -> None:
    query = gateway(ROOM, VIEWS[2][1])
    sight = scores(learned(GatewayParams(sonar_power=0.0)), query)
    sound = scores(learned(GatewayParams(vision_power=0.0)), query)
    both = scores(learned(GatewayParams()), query)
    assert sight + sound == pytest.approx(both)


def test_learned_likelihoods_know_how_often_a_place_was_misread() -> None:
    params = GatewayParams(likelihoods="learned", confusion=5.0)
    memory = Gateway(params).memory()
    for session in range(5):
        memory.learn(0, gateway(ROOM if session < 2 else RIGHT, session=session))
        memory.learn(1, gateway(RIGHT, session=session))
    models = [memory.model(0), memory.model(1)]
    found = sonar_evidence([gateway(ROOM), gateway(RIGHT)], models, params)
    assert found[0, 0] > 3 * found[0, 1] > 0
    assert found[1, 1] > found[1, 0]
    whole = sonar_evidence([gateway(name) for name in _types()], models, params)
    assert whole.sum(axis=0) == pytest.approx([1.0, 1.0])


def _types() -> list[str]:
    from fpnav.systems.gateway.types import NAMES

    return [name for name in NAMES if name]


def test_learned_sight_is_the_beta_mean_of_every_cell() -> None:
    params = GatewayParams(likelihoods="learned")
    memory = Gateway(params).memory()
    for session in range(3):
        memory.learn(0, gateway(RIGHT, [cue(60)] if session else [], session=session))
    model = memory.model(0)
    seen, empty = vision_evidence([gateway(RIGHT, [cue(60)]), gateway(RIGHT)], [model], params)
    rows = 2  # the cue covers two cells
    assert seen[0] - empty[0] == pytest.approx(rows * math.log((3 / 5) / (2 / 5)))


def test_scores_of_scenes_are_those_of_the_stable_cues() -> None:
    memory = learned(GatewayParams())
    memory.learn(0, gateway(RIGHT, [*VIEWS[0][1], cue(400)], session=2))
    found = scene_scores([gateway(RIGHT, VIEWS[0][1])], [memory.model(0)], GatewayParams())
    assert found[0, 0] == 1.0


def test_the_map_says_which_gateway_follows() -> None:
    memory = learned(GatewayParams(prior="topo"))
    blind = [gateway(RIGHT, VIEWS[0][1]), gateway(RIGHT, facings=0), gateway(RIGHT, facings=0)]
    found, trace = memory.recall(blind, 1, None, None)
    assert found.places[:, 0].tolist() == [0, 1, 2]
    more, _ = memory.recall([gateway(ROOM, facings=0)], 1, None, trace)
    assert more.places[0, 0] == 3


def test_another_session_starts_from_anywhere() -> None:
    memory = learned(GatewayParams(prior="topo"))
    queries = [gateway(RIGHT, VIEWS[1][1]), gateway(RIGHT, facings=0, session=1)]
    found, _ = memory.recall(queries, 4, None, None)
    assert found.scores[1, 0] == pytest.approx(found.scores[1, 1])


def test_a_gateway_is_new_unless_it_is_the_last_one_again() -> None:
    memory = Gateway(GatewayParams()).memory()
    first = gateway(RIGHT, at=Pose2(0.0, 0.0, 0.0))
    again = gateway(ROOM, at=Pose2(0.4, 0.0, 0.1))
    later = gateway(RIGHT, at=Pose2(5.0, 0.0, 0.0))
    back = gateway(RIGHT, at=Pose2(0.4, 0.0, 3.1))
    assert memory.novelty(again, first, None)[0] == 0.0
    assert memory.novelty(later, first, None)[0] == 1.0
    assert memory.novelty(back, first, None)[0] == 1.0
    assert memory.novelty(first, None, None)[0] == 1.0


def test_mere_scenes_are_as_new_as_they_look() -> None:
    memory = Gateway(GatewayParams()).memory()
    one, other = gateway("", VIEWS[0][1]), gateway("", VIEWS[1][1])
    assert memory.novelty(one, one, None)[0] == 0.0
    assert memory.novelty(other, one, None)[0] == pytest.approx(0.9)


def test_arcs_follow_a_merge() -> None:
    memory = learned(GatewayParams(prior="topo"))
    memory.merge(1, 2)
    assert memory.places.tolist() == [0, 1, 3]
    state = memory.save()
    assert state["arcs"].tolist() == [[0, 1], [1, 3]]
    assert state["counts"].tolist() == [2, 2]
    assert memory.model(1).types.sum() == 4


def test_headings_are_turns_from_the_first_visit() -> None:
    memory = Gateway(GatewayParams()).memory()
    memory.learn(0, gateway(RIGHT, axis_rad=0.05))
    found, _ = memory.recall([gateway(RIGHT, axis_rad=-0.1)], 1, None, None)
    assert found.headings_rad[0, 0] == pytest.approx(0.15)
