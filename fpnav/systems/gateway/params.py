"""Parameters of the gateway system and its presets."""

from __future__ import annotations

from typing import Literal

from fpnav.params import Params

Matcher = Literal[1, 2, 3, 4, "soft"]


class GatewayParams(Params, frozen=True):
    """Gateways and scenes; values where the paper is silent are those of systems.md 3.10.

    Ranges: ``ranges`` from the sonar ring, from ``sonars`` virtual ones of ``cone_deg`` in the
    laser scan, or auto: the ring where there is one; ``side_deg`` of a side's transducers;
    ``speed_mps`` assumed where a log says nothing of travel; frames where the robot moved
    ``step_m`` or turned ``step_heading_deg``.
    Openings: ``detector`` thresholds (``open_rise_m``, ``close_rise_m``, ``readings`` in a row) or
    evidence over time (``evidence_rise_m``, ``evidence_noise_m``, ``evidence_limit`` nats); the
    other distances are those of ``fpnav.sensing.passages.Rule``.
    Scenes: ``edge_*`` what is a vertical edge; ``fov_deg`` and ``baseline_m`` where the
    calibration is silent; ``offset_camera`` to the left or right, auto: as it is mounted;
    ``look`` only where a side is open, or always; ``keep`` scenes at gateways or every
    ``spacing_m`` of travel, which also holds where there are no ranges.
    Stored scenes: ``strengthen``, ``weaken``, ``stable``, ``forget`` of the links, ``weights``
    those of the paper or the share of visits that saw a cue; distances within ``distance_share`` of
    the larger are alike.
    Matching: ``matcher`` of the paper (1..4) or soft (``soft_*``).
    Places: ``floor`` of a scene without a match; ``smooth`` added to the sonar table;
    ``likelihoods`` from the tables or learned in the mapping run, with ``confusion`` counts of the
    table; ``prior`` uniform, or from the previous place along the map's arcs, ``stray`` of it from
    anywhere; ``vision_power``, ``sonar_power``; a gateway within ``same_m`` of the last one is it.
    """

    ranges: Literal["auto", "sonar", "scan"] = "auto"
    sonars: int = 24
    cone_deg: float = 30.0
    side_deg: float = 15.0
    speed_mps: float = 0.3
    step_m: float = 0.02
    step_heading_deg: float = 5.0
    detector: Literal["threshold", "evidence"] = "threshold"
    open_rise_m: float = 0.5
    close_rise_m: float = 0.25
    readings: int = 2
    evidence_rise_m: float = 0.25
    evidence_noise_m: float = 0.05
    evidence_limit: float = 5.0
    window_m: float = 1.5
    axis_m: float = 1.5
    far_m: float = 2.5
    front_m: float = 0.8
    front_turn_m: float = 1.6
    limit_m: float = 3.0
    past_m: float = 0.5
    least_m: float = 0.85
    together_m: float = 0.5
    room_m: float = 2.5
    hall_m: float = 2.6
    corner_m: float = 0.8
    wide_m: float = 2.0
    settle_m: float = 0.3
    turn_deg: float = 25.0
    aligned_deg: float = 5.0
    edge_steep: float = 4.0
    edge_sigmas: float = 2.0
    edge_floor: float = 0.0
    edge_gap_px: int = 5
    edge_drift_px: int = 6
    edge_least_px: int = 60
    fov_deg: float = 60.0
    baseline_m: float = 0.18
    offset_camera: Literal["auto", "left", "right"] = "auto"
    look: Literal["openings", "always"] = "openings"
    keep: Literal["gateways", "spacing"] = "gateways"
    spacing_m: float = 1.0
    strengthen: float = 0.3
    weaken: float = 0.7
    stable: float = 0.3
    forget: float = 0.05
    weights: Literal["paper", "count"] = "paper"
    matcher: Matcher = 2
    distance_share: float = 0.25
    soft_width_px: float = 48.0
    soft_shift_px: float = 47.0
    soft_off: float = 0.15
    soft_beta: float = 2.0
    floor: float = 0.1
    smooth: float = 0.0
    likelihoods: Literal["table", "learned"] = "table"
    confusion: float = 5.0
    prior: Literal["uniform", "topo"] = "uniform"
    stray: float = 0.05
    vision_power: float = 1.0
    sonar_power: float = 1.0
    same_m: float = 1.0


LATE = frozenset(
    {
        "strengthen", "weaken", "stable", "forget", "weights", "matcher", "distance_share",
        "soft_width_px", "soft_shift_px", "soft_off", "soft_beta", "floor", "smooth",
        "likelihoods", "confusion", "prior", "stray", "vision_power", "sonar_power", "same_m",
    }
)  # fmt: skip
"""Parameters that act on signatures, not in making them."""

PRESETS = {
    "paper": GatewayParams(),
    "default": GatewayParams(
        side_deg=5.0,
        detector="evidence",
        axis_m=3.0,
        edge_floor=0.03,
        weights="count",
        matcher="soft",
        soft_width_px=36.0,
        soft_beta=1.0,
        vision_power=8.0,
        smooth=0.01,
    ),
}
