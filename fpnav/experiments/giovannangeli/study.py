"""The study as data: its experiments in order, and what the paper claims of each."""

from __future__ import annotations

from fpnav.experiments.giovannangeli import bounded, carried, lines, occlusion, text, trips
from fpnav.experiments.study import Study
from fpnav.report.study import Claim, Heading

OURS = "a test of ours, not the paper's: the same drive under other sun, clouds and shadows"

HEADING = Heading(
    name="giovannangeli",
    system="placecell",
    title="Mapless navigation with visual place cells",
    paper=(
        "After C. Giovannangeli, P. Gaussier and G. Desilles, Robust mapless outdoor vision-based "
        "navigation, IROS 2006. Its figures are described, not copied."
    ),
    introduction=(
        "A robot that keeps no map recognises where it is by local views and their directions, and "
        "goes where each place has taught it to go. The paper's experiments in simulated worlds. "
        "What the paper leaves open was settled in worlds 11 and 12, but for the number of focus "
        "points of figures 3 and 4, which was seen in world 1. The paper changes the light between "
        "learning and test in figure 8 alone; outdoors B2, B4, B7, P5 and P6 are driven the same "
        "afternoon, as there, and once more on another day: these figures are named so."
    ),
    titles={
        "B1": "Soft and strict competition (figure 3)",
        "B2": "Short-term memory outdoors (figure 4)",
        "B3": "Fields grow with the world",
        "B4": "Half of the view hidden (figure 7)",
        "B5": "Homing (figure 6)",
        "B6": "A loop learned in the afternoon, driven in the morning (figure 8)",
        "B7": "Set down elsewhere",
        "P1": "An S-shaped street on several days",
        "P2": "Landmarks added and removed",
        "P3": "Three place-action pairs",
        "P4": "A drifting azimuth",
        "P5": "Partial views that stream",
        "P6": "Bounded memory",
        "S": "What the paper does not say",
    },
)

CLAIMS = (
    Claim("B1", "nearest_wins", "the nearest place wins", "fields in order", least=0.95,
          meaning="worse of soft and strict, of the samples where any cell is active"),
    Claim("B1", "half_width_ratio", "soft competition widens fields", "very wide fields",
          least=2.0, meaning="mean width at half height, soft over strict"),
    Claim("B1", "peak_error_m", "peaks stay where places were learned", "precision kept",
          most=0.1, meaning="largest distance of a peak from its place"),
    Claim("B2", "roughness_ratio", "short-term memory smooths the fields", "noisy without",
          most=0.4, meaning="RMS about the moving average, with over without; the paper's counter"),
    Claim("B2", "roughness_ratio_window", "so does the largest of the last four panoramas",
          "noisy without", most=0.4, meaning="the same, without the counter's reset"),
    Claim("B2", "learned_activity", "places answer where they were learned",
          "low without memory", least=0.6, meaning="least over the places"),
    Claim("B2", "learned_activity_other_day", "also under another day's sun and clouds",
          "not in the paper", least=0.6, meaning=OURS),
    Claim("B3", "field_slope", "fields are homothetic with the world", "25 m outdoors",
          least=0.8, most=1.2, meaning="slope of log diameter over log size"),
    Claim("B4", "occlusion_peak_ratio", "eq. 4 keeps the fields", "kept", least=0.85,
          meaning="peaks with half hidden over peaks without"),
    Claim("B4", "occlusion_winner", "and the winners", "kept", least=0.9,
          meaning="samples whose winner is that without hiding"),
    Claim("B4", "occlusion_peak_ratio_other_day", "the fields, also on another day",
          "not in the paper", least=0.85, meaning=OURS),
    Claim("B4", "occlusion_winner_other_day", "the winners, also on another day",
          "not in the paper", least=0.9, meaning=OURS),
    Claim("B4", "occlusion_peak_ratio_eq3", "eq. 3 collapses", "collapses", most=0.6),
    Claim("B5", "homing_success", "eight places draw the robot home", "from all the basin",
          least=0.98, meaning="trips from the disc of 1.5 m that end within 0.3 m of the goal"),
    Claim("B5", "homing_success_people", "also with somebody walking about", "robust", least=0.9,
          meaning="the same"),
    Claim("B6", "route_closed", "the loop closes at another time of day", "closes", least=1.0,
          meaning="trips that pass all of the loop and end where it ends"),
    Claim("B6", "action_within_45", "actions are those of the teacher", "all the way", least=0.95,
          meaning="within 45 degrees of the way taught, on a log of it in the morning"),
    Claim("B7", "recovered", "set down elsewhere, the right cell wins at once", "robust",
          least=0.95, meaning="jumps after which the first panorama's winner is the nearest place"),
    Claim("B7", "recovered_outdoor", "the same outdoors", "robust", least=0.95,
          meaning="the same"),
    Claim("B7", "recovered_outdoor_other_day", "and on another day", "not in the paper",
          least=0.95, meaning=OURS),
    Claim("P1", "route_closed", "a street learned once is followed on other days", "followed",
          least=1.0, meaning="drives of two other days that come to the end of the street"),
    Claim("P2", "nearest_wins", "places survive added and removed landmarks", "robust",
          meaning="half of what can be moved was moved"),
    Claim("P3", "homing_success", "three pairs make a basin", "enough", least=0.9,
          meaning="trips that end within 0.3 m of the goal"),
    Claim("P3", "end_farthest_m", "none is sent away", "enough", most=1.0,
          meaning="end farthest from the goal; the places are 1 m from it, starts up to 1.5 m"),
    Claim("P4", "winner_kept", "ranks survive azimuth drift", "kept", least=0.9,
          meaning="samples with the winner they have without drift"),
    Claim("P5", "field_correlation", "partial views give the fields of the panorama", "the same",
          least=0.9, meaning="correlation of the activities of one map's cells at the same "
          "positions, streaming on the way against panoramas of the same nine views on the spot"),
    Claim("P5", "field_correlation_other_day", "and on another day", "not in the paper",
          least=0.9, meaning=OURS),
    Claim("P6", "nearest_wins_bounded", "a third of the landmarks tells places apart",
          "growth is an open problem", meaning="chosen by what training showed"),
    Claim("P6", "nearest_wins_plain", "as all of them do", "", meaning="beside the row above"),
    Claim("P6", "nearest_wins_bounded_other_day", "a third, on another day", "not in the paper",
          meaning=OURS),
    Claim("P6", "nearest_wins_plain_other_day", "all, on another day", "not in the paper",
          meaning=OURS),
)  # fmt: skip

STUDY = Study(
    heading=HEADING,
    claims=CLAIMS,
    experiments={
        "B1": lines.soft_and_strict,
        "B2": lines.short_term_memory,
        "B3": lines.growing_fields,
        "B4": occlusion.occluded,
        "B5": trips.homing_from_all_around,
        "B6": trips.closing_the_loop,
        "B7": carried.carried_off,
        "P1": text.street,
        "P2": text.moved,
        "P3": text.three_pairs,
        "P4": text.drifting,
        "P5": text.partial_views,
        "P6": bounded.bounded,
        "S": text.silent_points,
    },
    together={"P6": bounded.over_budgets},
    most={"P1": 2, "P2": 2, "S": 1},
    long=("S", "B6", "P1", "B5"),
)
