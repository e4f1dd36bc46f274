"""The study as data: its experiments in order, and what the paper claims of each."""

from __future__ import annotations

from fpnav.experiments.kortenkamp import (
    changes,
    detection,
    driving,
    recognition,
    scale,
    scenes,
    spacing,
    types,
)
from fpnav.experiments.study import Study
from fpnav.report.study import Claim, Heading

HEADING = Heading(
    name="kortenkamp",
    system="gateway",
    title="Places from gateways and scenes",
    paper=(
        "After D. Kortenkamp and T. Weymouth, Topological mapping for mobile robots using a "
        "combination of sonar and vision sensing, AAAI 1994. Its figures are described, not copied."
    ),
    introduction=(
        "A robot that follows hallways notices openings by sonar, looks at the vertical edges in "
        "view from each, and tells the places apart by both. The paper's experiments in simulated "
        "buildings: seven gateways A to G, of which B, C and D are alike to sonar, on three routes "
        "driven five times with a guide and once more to test."
    ),
    titles={
        "C1": "Gateways found (figure 3)",
        "C2": "Four ways to match scenes",
        "C3": "Scenes only (table 1)",
        "C4": "Gateways only (table 2)",
        "C5": "Scenes and gateways (table 3)",
        "C5-default": "Scenes and gateways, with what this project would use",
        "C6": "A gateway misread",
        "C6-default": "A gateway misread, with what this project would use",
        "C7": "From match percentages to likelihoods",
        "C8": "All types of gateways",
        "C9": "Fifty gateways, ten alike",
        "C9-default": "Fifty gateways, with what this project would use",
        "C10": "A door closed since training",
        "C11": "A robot that stops in gateways by itself",
        "C12": "Scenes at gateways, or at regular spacing",
    },
)

CLAIMS = (
    Claim("C1", "gateway_found", "every gateway is found", "all", least=1.0),
    Claim("C1", "gateway_invented", "and none invented", "none", most=0.0),
    Claim("C1", "gateway_within_70mm", "position along the hallway", "70 mm at most", least=0.95,
          meaning="share of those found within 70 mm; a room counts from the edge of its wall"),
    Claim("C1", "gateway_within_70mm_plan", "the same by the world's plan", "",
          meaning="a room counts from the middle line of its wall, 6 cm before the edge"),
    Claim("C1", "gateway_within_3_5deg", "orientation", "3.5 degrees at most", least=0.95,
          meaning="share of those found within 3.5 degrees"),
    Claim("C1", "gateway_type_accuracy", "types classified right", "no mistake", least=0.95),
    Claim("C1", "gateway_within_70mm_evidence", "position, by evidence over time", "",
          meaning="share within 70 mm; sums of log-likelihood ratios; test traversals only"),
    Claim("C2", "matcher_1", "method 1: features", "7 of 16"),
    Claim("C2", "matcher_2", "method 2: cells by distance and direction", "9 of 16"),
    Claim("C2", "matcher_3", "method 3: cells by direction", "5 of 16"),
    Claim("C2", "matcher_4", "method 4: cells by occupancy", "6 of 16"),
    *(
        Claim("C2", f"matcher_2_over_{n}", f"method 2 is better than {n}", "chosen", above=0.0,
              meaning="difference of the shares; the whole interval above zero")
        for n in (1, 3, 4)
    ),
    Claim("C2", "matcher_soft", "soft cells", "", least=13 / 16),
    Claim("C3", "vision_only", "scenes alone", "4 of 7"),
    Claim("C4", "sonar_only", "gateways alone", "4 of 7", most=4 / 7),
    Claim("C5", "combined", "both", "7 of 7"),
    Claim("C5", "combined_all", "all seven in one world", "yes", least=0.95,
          meaning="share of the worlds"),
    Claim("C5", "posterior_unique_least", "posterior of A, E, F, G", ".95 for A", least=0.9,
          meaning="the least of the four"),
    Claim("C5", "posterior_alike_margin", "posterior of B, C, D over the next", "", least=2.0,
          meaning="the least of the three"),
    Claim("C5", "product_rule_gap", "the answer is the product of both", "", most=1e-9),
    Claim("C5-default", "vision_only", "soft cells: scenes alone", "4 of 7"),
    Claim("C5-default", "combined_all", "all seven in one world, soft cells", "yes", least=0.95,
          meaning="share of the worlds"),
    Claim("C5-default", "posterior_unique_least", "posterior of A, E, F, G", ".95 for A",
          least=0.9, meaning="the least of the four"),
    Claim("C5-default", "posterior_alike_margin", "posterior of B, C, D over the next", "",
          least=2.0, meaning="the least of the three"),
    Claim("C6", "error_corrected", "D misread as RIGHT ROOM is D", ".42 against .25", least=0.8),
    Claim("C6-default", "error_corrected", "the same, soft cells", ".42 against .25",
          least=0.8),
    Claim("C7", "normalisation_gap", "(.25, .90, .75)", "(.13, .47, .40)", most=0.0055,
          meaning="largest difference; the paper rounds .3947 to .40"),
    Claim("C8", "type_accuracy_of_all", "25 types classified right", "25 identified", least=0.95,
          meaning="of all there are, one of each type a world; not found counts as wrong"),
    Claim("C8", "types_told", "types told at least once in each world", "", least=0.95),
    Claim("C9", "scale_alone", "fifty gateways, each alone", "will not hold up"),
    Claim("C9", "scale_after_3", "after three of them", "a handful of possibilities", least=0.95,
          meaning="filter over the map, set down anywhere before"),
    Claim("C9-default", "scale_after_3", "the same, soft cells", "", least=0.95,
          meaning="filter over the map, set down anywhere before"),
    Claim("C10", "closed_combined", "C walled up: the others are told", ""),
    Claim("C10", "closed_combined_default", "the same, soft cells", "", least=0.95),
    Claim("C10", "closed_by_counting", "by counting gateways instead", "dangerous"),
    Claim("C11", "gateway_found_stopped", "it stops in every gateway", "yes", least=1.0),
    Claim("C11", "gateway_within_70mm_stopped", "where it stops", "70 mm at most", least=0.95),
    Claim("C11", "gateway_within_3_5deg_stopped", "how it stands", "3.5 degrees at most",
          least=0.95),
    Claim("C12", "scenes_at_gateways", "scenes stored at gateways", "fewer"),
    Claim("C12", "scenes_spaced", "scenes stored every metre", ""),
    Claim("C12", "gateways_by_scene", "gateways told by their scene", "",
          meaning="soft cells, after one guided traversal"),
    Claim("C12", "gateways_by_both", "and by sonar too", "", meaning="soft cells likewise"),
    Claim("C12", "spaced_by_scene", "spaced scenes placed within a metre", "",
          meaning="soft cells likewise; the rest of the way between gateways is known as well"),
)  # fmt: skip

STUDY = Study(
    heading=HEADING,
    claims=CLAIMS,
    experiments={
        "C1": detection.detection,
        "C2": scenes.matchers,
        "C3": recognition.vision_only,
        "C4": recognition.sonar_only,
        "C5": recognition.combined,
        "C5-default": recognition.combined_default,
        "C6": recognition.sonar_error,
        "C6-default": recognition.sonar_error_default,
        "C7": recognition.normalisation,
        "C8": types.types,
        "C9": scale.scale,
        "C9-default": scale.scale_default,
        "C10": changes.closed_door,
        "C11": driving.stops,
        "C12": spacing.spacing,
    },
    together={"C1": detection.together, "C8": types.together},
    most={"C9": 2, "C9-default": 2, "C12": 2},
)
