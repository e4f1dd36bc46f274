"""The study as data: its experiments in order, and what the paper claims of each."""

from __future__ import annotations

from fpnav.experiments.giovannangeli import lines
from fpnav.experiments.study import Study
from fpnav.report.study import Claim, Heading

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
        "goes where each place has taught it to go. The paper's experiments in simulated worlds."
    ),
    titles={
        "B1": "Soft and strict competition (figure 3)",
        "B2": "Short-term memory outdoors (figure 4)",
        "B3": "Fields grow with the world",
        "B4": "Half of the view hidden (figure 7)",
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
          most=0.4, meaning="RMS about the moving average, with over without"),
    Claim("B2", "learned_activity", "places answer where they were learned",
          "low without memory", least=0.6, meaning="least over the places"),
    Claim("B3", "field_slope", "fields are homothetic with the world", "25 m outdoors",
          least=0.8, most=1.2, meaning="slope of log diameter over log size"),
    Claim("B4", "occlusion_peak_ratio", "eq. 4 keeps the fields", "kept", least=0.85,
          meaning="peaks with half hidden over peaks without"),
    Claim("B4", "occlusion_winner", "and the winners", "kept", least=0.9,
          meaning="samples whose winner is that without hiding"),
    Claim("B4", "occlusion_peak_ratio_eq3", "eq. 3 collapses", "collapses", most=0.6),
)  # fmt: skip

STUDY = Study(
    heading=HEADING,
    claims=CLAIMS,
    experiments={
        "B1": lines.soft_and_strict,
        "B2": lines.short_term_memory,
        "B3": lines.growing_fields,
        "B4": lines.occluded,
    },
)
