"""From a heading to go to speeds for the wheels."""

from __future__ import annotations

import math

from fpnav.geometry import wrap
from fpnav.navigation.base import Command
from fpnav.params import Params


class SteeringParams(Params, frozen=True):
    """Block ``navigate``.

    speed_mps, turn_radps : largest speeds
    settle_s : time in which a heading error would be turned away
    sharp_deg : heading error from which the robot turns on the spot
    reach_m, touch_m : obstacles are felt from ``reach_m`` on, fully at ``touch_m``
    margin : by how much a place must beat the present winner
    end_ratio : how much more active than any other a place that ends the task must be to halt at
    blend : on the way to a goal the speed follows how far the active places agree on the
        direction, weighted by this power of their activity; 0 = the winner alone decides
    hold : decisions for which a direction is kept when no place is recognised
    """

    speed_mps: float = 0.25
    turn_radps: float = 1.0
    settle_s: float = 0.5
    sharp_deg: float = 60.0
    reach_m: float = 0.8
    touch_m: float = 0.3
    margin: float = 0.02
    end_ratio: float = 1.5
    blend: float = 4.0
    hold: int = 20


def steer_to(bearing_rad: float, params: SteeringParams, clear: float = 1.0) -> Command:
    """Speeds that turn the robot to a bearing and drive it there.

    ``clear`` : share of the speed that what lies ahead allows
    """
    error = wrap(bearing_rad)
    turn = max(-params.turn_radps, min(params.turn_radps, error / params.settle_s))
    if abs(error) > math.radians(params.sharp_deg):
        return Command(0.0, turn)
    return Command(params.speed_mps * clear * math.cos(error), turn)
