"""Parameters of the fingerprint system and its presets."""

from __future__ import annotations

from typing import Literal

from fpnav.params import Count, NotNegative, Params, Positive, Share


class FingerprintParams(Params, frozen=True):
    """Fingerprints of places; values where the paper is silent are those of systems.md 1.12.

    Sensors: ``use_laser``, ``use_camera``; ``laser_fov_deg`` keeps beams around the heading;
    ``white_balance`` grey-world. Symbols: ``pair_deg`` largest angle between a corner and an edge
    that correspond; ``delta_n_deg`` empty space one ``n`` stands for; ``certainty_n``.
    ``use_f``, ``use_colour`` leave out correspondences and hues; ``corner_epsilon_m`` tolerance of
    Douglas-Peucker. ``certainty`` as extracted, all alike (``flat``), or ``calibrated`` on the
    mapping run: how likely a feature is seen again a little further on. ``scores`` of the hand-made
    table, of plain Needleman-Wunsch, or ``learned`` from the mapping run. ``exemplars`` kept beside
    a place's mean, fused where there are more;
    ``exemplar_m`` > 0 keeps a fingerprint as it is after every so many metres in a place; of mean
    and exemplars the best counts.
    ``angle_deg`` > 0 aligns a second time in recall, the turn known, a match losing the square of
    how many times this it is off. ``fuse_gate_deg`` > 0: a match off by more is not fused.
    ``ray_deg`` > 0 keeps the scan's rays that far apart: symbols have ranges, and the best
    candidates of a recall are verified by laying scans over each other. ``window_m`` > 0 makes of
    each scan one all round, from those of so many metres before it, joined by odometry: places are
    known again whatever the heading. ``camera`` symbols are the
    paper's ``letters``, or beside them, without a laser, ``strips`` of angle that carry attributes,
    standardised over the whole run, with keypoints. ``memory`` keeps the ``mean`` of a place, or
    (``chosen``) of a laser or a camera alone its members, of which the best counts.
    Alignment: ``weight_*`` per type of symbol; ``gamma`` share of its weight a gap costs;
    ``cuts`` tries all rotations of any two fingerprints, or (``view``) takes those of views that
    are open (half a circle, a forward camera) as they stand, from their right edge to their left.
    Places: ``compare`` with the previous fingerprint, the place's mean, or both (the larger
    dissimilarity); ``theta`` the largest dissimilarity within a place, or ``auto`` for ``nodes``
    places, or ``otsu``; ``min_node_obs``. ``segment`` by that ``threshold`` as the robot drives, or
    by ``changepoint`` over the whole run: where ``window`` fingerprints before and after are less
    alike than usual by ``penalty``. ``step_m`` least travel between fingerprints: the paper's
    0.15 m less what wheels slip, so that a run recorded at 0.15 m is used whole.
    Mean: features nearer than ``merge_deg`` are one; after ``settle`` observations those under
    ``certainty_min`` are forgotten; ``features_max``. ``headings``: best places of a ranking whose
    orientation is traced back. Verification: ``candidates`` best of a ranking that are verified,
    ``same_m`` and ``same_deg`` how near a place must be to be called the same.
    """

    use_laser: bool = True
    use_camera: bool = True
    laser_fov_deg: NotNegative = 360.0
    white_balance: bool = False
    pair_deg: NotNegative = 3.0
    delta_n_deg: Positive = 20.0
    certainty_n: Share = 0.5
    use_f: bool = True
    use_colour: bool = True
    corner_epsilon_m: NotNegative = 0.06
    certainty: Literal["raw", "flat", "calibrated"] = "raw"
    scores: Literal["table", "plain", "learned"] = "table"
    exemplars: int = 0
    exemplar_m: NotNegative = 0.0
    angle_deg: NotNegative = 0.0
    ray_deg: NotNegative = 0.0
    window_m: NotNegative = 0.0
    camera: Literal["letters", "strips"] = "letters"
    memory: Literal["mean", "chosen"] = "mean"
    candidates: int = 200
    same_m: NotNegative = 1.5
    same_deg: NotNegative = 45.0
    fuse_gate_deg: NotNegative = 0.0
    cuts: Literal["all", "view"] = "all"
    weight_v: NotNegative = 1.0
    weight_colour: NotNegative = 1.0
    weight_c: NotNegative = 1.0
    weight_f: NotNegative = 1.0
    weight_n: NotNegative = 0.3
    gamma: NotNegative = 0.5
    compare: Literal["previous", "mean", "both"] = "previous"
    theta: float | Literal["auto", "otsu"] = 0.55
    nodes: int = 0
    min_node_obs: Count = 2
    segment: Literal["threshold", "changepoint"] = "threshold"
    window: Count = 6
    penalty: NotNegative = 0.05
    step_m: NotNegative = 0.12
    step_heading_deg: NotNegative = 0.0
    merge_deg: NotNegative = 2.0
    settle: int = 4
    certainty_min: NotNegative = 0.15
    features_max: Count = 60
    headings: int = 10


# theta for ``mean`` is systems.md's. certainty_min is not: a feature first met by the sixth of a
# place's fingerprints enters its mean at a sixth of its certainty, so with 0.15 it would be dropped
# the moment it came and the mean would stay what the first five saw; the paper calls the mean a
# characterization of all the fingerprints of its node.
PRESETS = {
    "paper": FingerprintParams(compare="mean", theta=0.50, certainty_min=0.03),
    "default": FingerprintParams(
        compare="mean",
        theta=0.50,
        certainty_min=0.03,
        cuts="view",
        exemplar_m=0.3,
        segment="changepoint",
        ray_deg=1.0,
        camera="strips",
        memory="chosen",
    ),
}

LATE = frozenset(
    {
        "certainty",
        "scores",
        "exemplars",
        "exemplar_m",
        "angle_deg",
        "memory",
        "candidates",
        "same_m",
        "same_deg",
        "fuse_gate_deg",
        "weight_v",
        "weight_colour",
        "weight_c",
        "weight_f",
        "weight_n",
        "gamma",
        "cuts",
        "compare",
        "theta",
        "nodes",
        "min_node_obs",
        "segment",
        "window",
        "penalty",
        "step_m",
        "step_heading_deg",
        "merge_deg",
        "settle",
        "certainty_min",
        "features_max",
        "headings",
    }
)
"""Parameters that act on fingerprints, not in making them."""
