"""The table of metrics: name, function, meaning. A new metric is one line here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fpnav.evaluation.calibration import brier_skill, ece
from fpnav.evaluation.guidance import action_within, homing_success, route_closed
from fpnav.evaluation.loops import loop_precision, loop_recall
from fpnav.evaluation.measure import Measure
from fpnav.evaluation.places import (
    kidnap_recovered,
    kidnap_recovery,
    mission_success,
    place_accuracy,
    places,
)
from fpnav.evaluation.poses import field_rho, heading_error, position_error
from fpnav.evaluation.precision import over_curve
from fpnav.evaluation.ranking import decision_precision, new_place_recall, not_localized, recall_at
from fpnav.evaluation.starts import (
    node_precision,
    node_precision_chance,
    node_recall,
    node_recall_chance,
    nodes_at_closed_doors,
    nodes_at_closed_doors_chance,
    starting,
)
from fpnav.evaluation.topology import topology_equal
from fpnav.evaluation.transfer import carried_precision, carried_recall

_DC = "; a wrong best match within 3 m and 90 degrees counts neither way"
_TOLERANT = "; a graph neighbour counts while the query is within 0.5 m of their border"


@dataclass(frozen=True, slots=True)
class Entry:
    """One metric: how it is measured, what it says, what ``n`` of ``of`` counts, what is good."""

    measure: Measure
    title: str
    meaning: str
    counts: str
    better: Literal["higher", "lower", "neither"] = "higher"


def _recall(depth: int) -> dict[str, Entry]:
    first = "first" if depth == 1 else f"first {depth}"
    title = "Recall at 1" if depth == 1 else f"Recall at {depth}"
    return {
        f"recall_at_{depth}": Entry(
            recall_at(depth),
            title,
            f"share of the queries that have a match and find one among the {first} of the "
            "ranking; abstaining does not change the ranking",
            "queries that find one, of those that have a match",
        ),
        f"recall_at_{depth}_all": Entry(
            recall_at(depth, every_query=True),
            f"{title}, of all queries",
            f"the same count over all judged queries, also those without any match: a run in "
            f"which half the places are new cannot exceed one half ({first})",
            "queries that find one, of all judged queries",
        ),
    }


_POSITIVES = "queries with a match, of all judged queries"


def _carried(percent: int) -> dict[str, Entry]:
    """Precision and recall at the threshold of another run."""
    where = (
        f"at the threshold where another run of the same system reached {percent} % precision, "
        "carried over by its quantile among the best scores; no truth of this run is used"
    )
    return {
        f"precision_at_carried_{percent}": Entry(
            carried_precision(percent / 100),
            f"Precision, threshold for {percent} % carried over",
            f"share right of the best matches accepted {where}",
            "right best matches, of those accepted on judged queries",
        ),
        f"recall_at_carried_{percent}": Entry(
            carried_recall(percent / 100),
            f"Recall, threshold for {percent} % carried over",
            f"share of queries whose best match is right and accepted {where}",
            "right and accepted, of the queries with a match",
        ),
    }


_ANYWHERE = "starts anywhere on the ground the mapping run drove for the first time"


def _starting(suffix: str) -> dict[str, Entry]:
    """Where places start, by the distance to a door itself or to its front, and by chance."""
    front = suffix == "_front"
    near, closed = "1 m of a listed open door or change", "a closed door"
    if front:
        near = "1 m of a listed change or of the way through an open door, 1 m to either side of it"
        closed = "the way through a closed door, 1 m to either side of it,"
    title = ", before doors too" if front else ""
    return {
        f"node_precision{suffix}": Entry(
            starting(node_precision, front=front),
            f"Places that start at something{title}",
            f"share of places that start within {near}",
            "places, of those that start along the way",
        ),
        f"node_precision{suffix}_chance": Entry(
            starting(node_precision_chance, front=front),
            f"Places that start at something{title}, by chance",
            f"the share expected of {_ANYWHERE}",
            "mapping poses near enough, of those on new ground",
            "neither",
        ),
        f"node_recall{suffix}": Entry(
            starting(node_recall, front=front),
            f"Doors and changes that got a place{title}",
            f"share of the doors and changes passed that a place starts at, within {near}",
            "doors and changes, of those passed",
        ),
        f"node_recall{suffix}_chance": Entry(
            starting(node_recall_chance, front=front),
            f"Doors and changes that got a place{title}, by chance",
            f"the share expected of as many {_ANYWHERE}",
            "doors and changes passed",
            "neither",
        ),
        f"nodes_at_closed_doors{suffix}": Entry(
            starting(nodes_at_closed_doors, front=front),
            f"Places at closed doors{', driven past too' if front else ''}",
            f"places that start within 1 m of {closed} and of nothing else that is listed",
            "places, of those that start along the way",
            "lower",
        ),
        f"nodes_at_closed_doors{suffix}_chance": Entry(
            starting(nodes_at_closed_doors_chance, front=front),
            f"Places at closed doors{', driven past too' if front else ''}, by chance",
            f"their number expected of as many {_ANYWHERE}",
            "places that start along the way",
            "neither",
        ),
    }


METRICS: dict[str, Entry] = {
    **_recall(1),
    **_recall(5),
    **_recall(10),
    "average_precision": Entry(
        over_curve("average_precision"),
        "Average precision",
        "step sum of precision over recall of the best match per query; recall base = queries "
        "with a match, queries without one are negatives",
        _POSITIVES,
    ),
    "average_precision_dc": Entry(
        over_curve("average_precision", dont_care=True),
        "Average precision, near misses aside",
        f"average precision{_DC}",
        _POSITIVES,
    ),
    "auc_pr": Entry(
        over_curve("area"),
        "Area under precision-recall",
        "trapezoid over recall of all queries with a match, anchored at recall 0 with the first "
        "precision",
        _POSITIVES,
    ),
    "auc_pr_vprbench": Entry(
        over_curve("area_of_correct"),
        "The same area as VPR-Bench has it",
        "recall counted over the right best matches only, so that queries without a right answer "
        "do not lower it; for comparison with figures published under that definition",
        _POSITIVES,
    ),
    "recall_at_100_precision": Entry(
        over_curve("recall_at_100"),
        "Recall at 100 % precision",
        "largest recall at a threshold that lets no wrong best match through; exact sweep over "
        "every score; the threshold is picked on this very run, so no run could have known it",
        _POSITIVES,
    ),
    "recall_at_100_precision_dc": Entry(
        over_curve("recall_at_100", dont_care=True),
        "Recall at 100 % precision, near misses aside",
        f"recall at 100 % precision{_DC}",
        _POSITIVES,
    ),
    "recall_at_99_precision": Entry(
        over_curve("recall_at_99"),
        "Recall at 99 % precision",
        "largest recall at a threshold with at least 99 % of the accepted matches right; hangs "
        "less on a single query than 100 %",
        _POSITIVES,
    ),
    "recall_at_99_precision_dc": Entry(
        over_curve("recall_at_99", dont_care=True),
        "Recall at 99 % precision, near misses aside",
        f"recall at 99 % precision{_DC}",
        _POSITIVES,
    ),
    **_carried(100),
    **_carried(99),
    "extended_precision": Entry(
        over_curve("extended_precision"),
        "Extended precision",
        "(precision of the highest scored answers + recall at 100 % precision) / 2, with recall "
        "over the right best matches, as VPR-Bench has it",
        _POSITIVES,
    ),
    "brier_skill": Entry(
        brier_skill,
        "Brier skill of the stated probability",
        "1 - Brier score / Brier score of always stating the share right: 1 is perfect, 0 no "
        "better than the base rate, below 0 worse",
        "queries with a stated probability, of all judged queries",
    ),
    "ece": Entry(
        ece,
        "Expected calibration error",
        "mean gap between stated probability and share right, over ten bins of equal width",
        "queries with a stated probability, of all judged queries",
        "lower",
    ),
    "place_accuracy_top1": Entry(
        place_accuracy(1),
        "Right place",
        "share of queries whose best answer is the place owning the nearest mapping pose",
        "queries in the right place, of those that stand within 1 m of a mapping pose",
    ),
    "place_accuracy_top1_tolerant": Entry(
        place_accuracy(1, tolerant=True),
        "Right place, or its neighbour at the border",
        f"right place{_TOLERANT}",
        "queries in the right place, of those that stand within 1 m of a mapping pose",
    ),
    "place_accuracy_top3": Entry(
        place_accuracy(3),
        "Right place among the first three",
        "share of queries whose true place is among the first three answers",
        "queries, of those that stand within 1 m of a mapping pose",
    ),
    "place_accuracy_top3_tolerant": Entry(
        place_accuracy(3, tolerant=True),
        "Right place or neighbour among the first three",
        f"true place among the first three{_TOLERANT}",
        "queries, of those that stand within 1 m of a mapping pose",
    ),
    "place_accuracy_settled": Entry(
        place_accuracy(1, skip=20),
        "Right place once settled",
        "right place, the first 20 queries left out: a belief needs some travel",
        "queries, of those that stand within 1 m of a mapping pose",
    ),
    "place_accuracy_settled_tolerant": Entry(
        place_accuracy(1, tolerant=True, skip=20),
        "Right place or neighbour once settled",
        f"right place, the first 20 queries left out{_TOLERANT}",
        "queries, of those that stand within 1 m of a mapping pose",
    ),
    "mission_success": Entry(
        mission_success(),
        "Missions that succeed",
        "share of missions (stretches of the run, at least 20) that end in the right place with "
        "every decision on the way right",
        "missions",
    ),
    "mission_success_tolerant": Entry(
        mission_success(tolerant=True),
        "Missions that succeed, borders tolerated",
        f"missions that succeed{_TOLERANT}",
        "missions",
    ),
    "kidnap_recovery_m": Entry(
        kidnap_recovery,
        "Recovery from kidnapping",
        "median metres of travel from a jump of the robot to the first right decision",
        "kidnappings recovered from, of all",
        "lower",
    ),
    "kidnap_recovered_3m": Entry(
        kidnap_recovered,
        "Recovered within 3 m",
        "share of jumps of the robot after which a right decision comes within 3 m of travel",
        "kidnappings recovered from in time, of all",
    ),
    "not_localized": Entry(
        not_localized,
        "Decisions withheld",
        "share of queries for which nothing was near enough: an answer of its own, never a guess",
        "queries without a decision, of all queries",
        "neither",
    ),
    "decision_precision": Entry(
        decision_precision,
        "Right when decided",
        "share of the decisions made that are right",
        "right decisions, of those made on judged queries",
    ),
    "new_place_recall": Entry(
        new_place_recall,
        "New places recognised as new",
        "share of the queries without any match whose decision was withheld",
        "withheld, of judged queries without a match",
    ),
    "position_error_median_m": Entry(
        position_error,
        "Position error",
        "median distance from the truth of the query to that of the best member signature, the "
        "relative pose applied where verified",
        "queries measured, of those that have a match",
        "lower",
    ),
    "heading_error_median_deg": Entry(
        heading_error,
        "Heading error",
        "median error of the stated heading where the best answer is right",
        "queries measured, of those answered right",
        "lower",
    ),
    "places": Entry(places, "Places", "number of places of the map", "places", "neither"),
    "topology_equal": Entry(
        topology_equal,
        "Shape of the building",
        "1 where the map, places of one room merged, joins exactly the rooms that the mapping run "
        "drove between; spaces joined without a door are one room",
        "passages in both map and building, of those in either",
    ),
    **_starting(""),
    **_starting("_front"),
    "loop_precision": Entry(
        loop_precision,
        "Loops that are loops",
        "share of the loops claimed that are loops in truth",
        "right, of those claimed",
    ),
    "loop_recall": Entry(
        loop_recall,
        "Loops found",
        "share of the returns in truth that were claimed right",
        "found, of those in truth",
    ),
    "field_rho": Entry(
        field_rho,
        "Place fields",
        "Spearman correlation of matching score and distance to the place's centre, over the true "
        "place and its neighbours: strongly negative where scores fall off around a place",
        "pairs of query and place in the ranking, of all such pairs",
        "lower",
    ),
    "homing_success": Entry(
        homing_success,
        "Trips that come home",
        "share of the trips of a robot that end within 0.3 m of their goal",
        "trips",
    ),
    "route_closed": Entry(
        route_closed,
        "Trips that follow their route to its end",
        "share of the trips that pass at least nine tenths of the route, never more than 5 m from "
        "it, and end within 3 m of its end",
        "trips",
    ),
    "action_within_45": Entry(
        action_within(45.0),
        "Actions within 45 degrees of the teacher's",
        "share of the decisions whose direction is within 45 degrees of that to the goal, or of "
        "that of the route at its nearest point; a decision without a direction is wrong",
        "decisions, of those at which the teacher has a direction",
    ),
}
"""Every metric of ``evaluate``, in the order they are printed."""
