"""Small worlds with known geometry, and sensors without faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fpnav.sim.light import Daylight
from fpnav.sim.plan import segments, wall_runs
from fpnav.sim.rig import Rig, make_rig
from fpnav.sim.sensors.ranges import Laser, Sonar
from fpnav.sim.solids import Face, Material, box, prism, sheet
from fpnav.sim.stage import Stage, set_stage
from fpnav.sim.world import Route, Space, Visuals, Walk, World

DARK = Material(colour=(0.05, 0.05, 0.05))
BRIGHT = Material(colour=(1.0, 1.0, 1.0), emission=5.0)
NIGHT = Daylight(0.0, -1.0, sun=0.0, sky=0.0, clouds=0.0)

TRUE_LASER = Laser(noise_m=0.0, noise_share=0.0, dropouts=0.0, mixed=0.0, step_m=0.0)
TRUE_SONAR = Sonar(noise_m=0.0, misses=0.0, cross_talk=0.0, step_m=0.001, rays_across=31)


def box_room(width: float, depth: float, height: float = 3.0) -> list[Face]:
    """Closed dark room from (0, 0) to (width, depth), seen from inside."""
    x, y, z = (width, 0, 0), (0, depth, 0), (0, 0, height)
    return [
        sheet((0, 0, 0), x, y, DARK),
        sheet((0, 0, height), y, x, DARK),
        sheet((width, 0, 0), (-width, 0, 0), z, DARK),
        sheet((0, depth, 0), x, z, DARK),
        sheet((0, 0, 0), y, z, DARK),
        sheet((width, depth, 0), (0, -depth, 0), z, DARK),
    ]


def pillar(x: float, y: float, radius: float = 0.15, material: Material = BRIGHT) -> list[Face]:
    """Shining pillar from floor to ceiling."""
    return prism((x, y), radius, 0.0, 3.0, material, sides=48, cap=False)


def block(x0: float, y0: float, x1: float, y1: float, material: Material = DARK) -> list[Face]:
    """Block from floor to ceiling."""
    return box((x0, y0, 0.0), (x1, y1, 3.0), material)


def world_of(faces: Sequence[Face], **given: Any) -> World:
    """World of some faces; a night without lamps unless said."""
    values: dict[str, Any] = {
        "name": "test",
        "seed": 1,
        "run": 1,
        "faces": tuple(faces),
        "lamps": (),
        "daylight": NIGHT,
        "visuals": Visuals(light_resolution_m=1.0, light_rays=4),
    }
    return World(**{**values, **given})


def stage_of(faces: Sequence[Face], **given: Any) -> Stage:
    """Stage of some faces."""
    return set_stage(world_of(faces, **given))


def hall_world(**given: Any) -> World:
    """Plain room of 8 x 6 m with a route across it and somebody walking."""
    space = Space("room", "office", 0.0, 0.0, 8.0, 6.0)
    route = Route("across", ((1.0, 3.0), (7.0, 3.0)), step_m=0.5)
    walk = Walk(((6.0, 1.0), (6.0, 5.0)), 1.0)
    walls = tuple(segments(wall_runs([space])))
    values: dict[str, Any] = {
        "spaces": (space,),
        "walls": walls,
        "routes": {"across": route},
        "walks": (walk,),
    }
    return world_of(box_room(8.0, 6.0), **{**values, **given})


def true_rig(*roles: str, **tables: dict[str, Any]) -> Rig:
    """Rig of the roles whose sensors have no faults."""
    plain = {
        "laser": {"noise_m": 0.0, "noise_share": 0.0, "dropouts": 0.0, "mixed": 0.0, "step_m": 0.0},
        "sonar": {"noise_m": 0.0, "misses": 0.0, "cross_talk": 0.0, "step_m": 0.001},
        "drift": {
            "along_m_per_sqrt_m": 0.0,
            "scale": 0.0,
            "heading_deg_per_sqrt_m": 0.0,
            "heading_share": 0.0,
            "slips_per_m": 0.0,
        },
        "compass": {"bias_deg": 0.0, "noise_deg": 0.0, "disturbance_deg": 0.0},
    }
    return make_rig(roles, plain, tables)
