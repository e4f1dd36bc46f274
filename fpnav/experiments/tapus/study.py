"""The study as data: its experiments in order, and what the paper claims of each."""

from __future__ import annotations

from fpnav.experiments.study import Study
from fpnav.experiments.tapus import beyond, locating, mapping, variants
from fpnav.report.study import Claim, Heading

HEADING = Heading(
    name="tapus",
    system="fingerprint",
    title="Topological maps from fingerprints of places",
    paper=(
        "After A. Tapus, F. Battaglia and R. Siegwart, The hippocampal place cells and "
        "fingerprints of places: spatial representation animals, animats and robots, IAS-9, 2006. "
        "Its figures are described, not copied."
    ),
    introduction=(
        "A robot with a laser and a panoramic camera describes each place by a circular string of "
        "what it sees around it, maps an office as a graph of such places, and finds itself again "
        "on another day. The paper's experiments in simulated offices, one building a seed."
    ),
    titles={
        "A1": "The mapping run (figures 1, 3, 4)",
        "A2": "Where places start",
        "A3": "Matching alone, on a new path (with A6 heading, A7 place fields)",
        "A3-default": "Matching alone, with what this project would use",
        "A4": "With the motion of the robot: a belief over places",
        "A4-default": "A belief over places, with what this project would use",
        "kidnapped": "Set down elsewhere ten times",
        "A5": "Closing loops",
        "ablations": "What each part is worth",
        "sensitivity": "The weakest assumptions",
        "certainty": "Is a feature seen again as often as stated?",
        "remapping": "Landmarks moved apart",
        "dark": "Belief by odometry alone",
    },
)

_ANYWHERE = "starts anywhere on ground driven for the first time"
_FRONT = "the way through a door, 1 m to either side of it"
_BELIEF = (
    "Where the paper says POMDP, states are spots of the mapping path, told by likeness to all "
    "places and, the likeliest, by what the mapping run saw there"
)
_TOLERANT = "a neighbour counts within 0.5 m of the border"

CLAIMS = (
    Claim("A1", "places", "nodes from 75 m and 500 data sets", "20",
          meaning="theta fixed, not asked for"),
    Claim("A1", "topology_equal", "the map has the shape of the building", "yes", least=1.0,
          meaning="places of one room merged = the visited part of the room graph"),
    Claim("A2", "node_precision", "nodes at doors or salient changes", "yes", least=0.8,
          meaning="places that start within 1 m of an open door or listed change"),
    Claim("A2", "node_precision_chance", "the same by chance", "",
          meaning=f"as many {_ANYWHERE}"),
    Claim("A2", "node_recall", "doors and changes get a node", "yes", least=0.8,
          meaning="of those within 1 m of the path"),
    Claim("A2", "node_recall_chance", "the same by chance", "", meaning=f"as many {_ANYWHERE}"),
    Claim("A2", "node_precision_front", "nodes at doors or changes, doors driven past too", "yes",
          meaning=f"within 1 m of {_FRONT}, or of a listed change"),
    Claim("A2", "node_precision_front_chance", "the same by chance", "",
          meaning=f"as many {_ANYWHERE}"),
    Claim("A2", "node_recall_front", "doors and changes, doors driven past too, get a node", "yes",
          meaning="of those passed"),
    Claim("A2", "node_recall_front_chance", "the same by chance", "",
          meaning=f"as many {_ANYWHERE}"),
    Claim("A2", "nodes_at_closed_doors", "no node at closed doors", "none", most=0.0,
          meaning="starts within 1 m of the door itself and of nothing else listed; what drives "
          "past in the middle of the corridor is never as near"),
    Claim("A2", "nodes_at_closed_doors_front", "no node in front of closed doors", "none",
          most=0.0,
          meaning=f"starts within 1 m of {_FRONT}, closed, and of nothing else listed"),
    Claim("A2", "nodes_at_closed_doors_front_chance", "the same by chance", "",
          meaning=f"as many {_ANYWHERE}: more nodes than that would be caused by the doors"),
    Claim("A3", "place_accuracy_top1_tolerant", "matching alone finds the place", "81 %",
          least=0.81, meaning=f"best answer owns the nearest mapping pose; {_TOLERANT}"),
    Claim("A3", "place_accuracy_top1", "the same, strictly", "81 %",
          meaning="no neighbour counts"),
    Claim("A3", "place_accuracy_top3_tolerant", "else it is second or third", "yes", least=0.95,
          meaning=_TOLERANT),
    Claim("A3", "heading_error_median_deg", "heading from the alignment", "no number", most=3.0,
          meaning="median over correct matches"),
    Claim("A3", "field_rho", "matching falls off from the centre", "qualitative",
          meaning="Spearman of score and distance to the centre of the place"),
    Claim("A3-default", "place_accuracy_top1_tolerant", "matching with our defaults", "",
          least=0.92, meaning=_TOLERANT),
    Claim("A3-default", "place_accuracy_top1", "the same, strictly", ""),
    Claim("A3-default", "place_accuracy_top3_tolerant", "among the first three", "", least=0.98,
          meaning=_TOLERANT),
    Claim("A4", "mission_success_tolerant", "missions with the filter", "100 %", least=1.0,
          meaning=f"ends right, no wrong decision on the way, at least 20 a run; {_TOLERANT}"),
    Claim("A4", "place_accuracy_settled_tolerant", "each step after the first 20", "",
          least=0.99, meaning=f"{_TOLERANT}. {_BELIEF}"),
    Claim("A4", "place_accuracy_settled_tolerant_smooth", "the same, smoothed offline", "",
          meaning="forward-backward over the whole run"),
    Claim("A4-default", "mission_success_tolerant", "missions with our defaults", "100 %",
          least=1.0, meaning=_TOLERANT),
    Claim("A4-default", "place_accuracy_settled_tolerant", "each step after the first 20", "",
          least=0.99, meaning=_TOLERANT),
    Claim("kidnapped", "kidnap_recovered_3m", "recovered from a jump", "", least=0.95,
          meaning="a right decision within 3 m of travel"),
    Claim("A5", "loop_recall", "all loops are closed", "all", least=1.0,
          meaning="returns along an earlier path that meet a place of it"),
    Claim("A5", "loop_precision", "and no false one", "", least=1.0,
          meaning="closed where the robot truly was within 1.5 m"),
    Claim("certainty", "certainty_ece", "stated certainty of features holds", "", most=0.05,
          meaning="of standing again where it must, 0.3 to 1 m further on; calibrated on another "
          "run"),
    Claim("certainty", "certainty_brier_skill", "and tells features apart", "", least=0.1,
          meaning="against always stating the base rate"),
    Claim("certainty", "certainty_aligned_ece", "the same, seen again as the alignment says", "",
          most=0.05, meaning="matched with one of its type within 15 degrees, no pose asked"),
    Claim("certainty", "certainty_aligned_brier_skill", "and tells features apart", "", least=0.1,
          meaning="against always stating the base rate"),
    Claim("remapping", "remapped_at_deg", "moved landmarks make another place", "qualitative",
          meaning="turn of every second feature at which matching halves"),
    Claim("dark", "dark_right", "belief by odometry alone", "qualitative",
          meaning="right or at the border after 3 m without light or laser"),
)  # fmt: skip

STUDY = Study(
    heading=HEADING,
    claims=CLAIMS,
    experiments={
        "A1": mapping.mapping_run,
        "A2": mapping.node_placement,
        "A3": locating.matching,
        "A3-default": locating.matching_default,
        "A4": locating.belief,
        "A4-default": locating.belief_default,
        "kidnapped": locating.set_down_elsewhere,
        "A5": mapping.loops,
        "ablations": variants.ablations,
        "sensitivity": variants.sensitivity,
        "certainty": beyond.certainty,
        "remapping": beyond.remapping,
        "dark": beyond.dark,
    },
    most={"ablations": 2, "sensitivity": 1},
    long=("ablations", "sensitivity"),
)
