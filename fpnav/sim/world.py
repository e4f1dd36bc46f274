"""A world: its faces, its light, and all that is true of it and cannot be read from poses."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from fpnav.sim.light import Daylight, Lamp
from fpnav.sim.solids import Face

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Space:
    """Rectangle of free floor between walls: a room, or a piece of corridor."""

    name: str
    kind: str
    x0: float
    y0: float
    x1: float
    y1: float

    def contains(self, x: float, y: float) -> bool:
        """Whether the point lies inside."""
        return self.x0 <= x < self.x1 and self.y0 <= y < self.y1

    @property
    def centre(self) -> Point:
        """Middle of the rectangle."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2


@dataclass(frozen=True, slots=True)
class Door:
    """Opening between two spaces; ``x_m, y_m`` its middle, ``axis_rad`` the way through."""

    name: str
    x_m: float
    y_m: float
    axis_rad: float
    width_m: float
    open: bool
    spaces: tuple[str, str]


@dataclass(frozen=True, slots=True)
class Gateway:
    """Transition met on a route while travelling along ``axis_rad``; ``x_m, y_m`` its centre.

    ``opens_m`` and ``closes_m`` count along the axis from the centre to the edges of the opening;
    ``closes_m`` is where the front wall stands where that is what closes it.
    """

    name: str
    route: str
    x_m: float
    y_m: float
    axis_rad: float
    type: str
    opens_m: float
    closes_m: float


@dataclass(frozen=True, slots=True)
class Change:
    """Something of note at a place: ``kind`` is corner, colour, landmark, added or removed."""

    kind: str
    what: str
    x_m: float
    y_m: float


@dataclass(frozen=True, slots=True)
class Mark:
    """Place with a name that labels the robot while it is within ``radius_m``."""

    name: str
    x_m: float
    y_m: float
    radius_m: float = 0.3

    def near(self, x_m: float, y_m: float) -> bool:
        """Whether a point is within the radius."""
        return math.hypot(self.x_m - x_m, self.y_m - y_m) <= self.radius_m


@dataclass(frozen=True, slots=True)
class Route:
    """Way of the robot.

    ``length_m`` cuts it; ``step_m`` lies between data sets; ``lookahead_m`` is how far ahead the
    robot aims, and so how much it cuts corners; ``stops`` names what it passes, in order;
    ``marks`` are places on it that have a name of their own. Where ``half_width_m`` is given, the
    robot follows the walls of a hallway of that half width by its sonar. Where it is ``carried``,
    it is put from point to point, half a second each, and a data set is taken at every point.
    """

    name: str
    points: tuple[Point, ...]
    length_m: float = math.inf
    speed_mps: float = 0.5
    step_m: float = 0.15
    lookahead_m: float = 0.32
    half_width_m: float = 0.0
    carried: bool = False
    stops: tuple[str, ...] = ()
    marks: tuple[Mark, ...] = ()


@dataclass(frozen=True, slots=True)
class Blocks:
    """A world made of parts on a grid, each built by itself when somebody is in it."""

    pitch_x_m: float
    pitch_y_m: float
    columns: int

    def corner(self, part: int) -> Point:
        """Lower left corner of a part."""
        return (part % self.columns) * self.pitch_x_m, (part // self.columns) * self.pitch_y_m

    def part_at(self, x_m: float, y_m: float) -> int:
        """The part a point lies in."""
        return int(y_m // self.pitch_y_m) * self.columns + int(x_m // self.pitch_x_m)


@dataclass(frozen=True, slots=True)
class Walk:
    """Way of a person, there and back again; a single point is somebody who stays."""

    points: tuple[Point, ...]
    speed_mps: float = 1.0
    start_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Visuals:
    """How the world is rendered: light map resolution, gather rays, ambient share, air."""

    light_resolution_m: float = 0.3
    light_rays: int = 24
    ambient: float = 0.5
    haze_m: float = 1e5


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Everything a run needs to know of the world it happens in."""

    name: str
    seed: int
    run: int
    faces: tuple[Face, ...]
    lamps: tuple[Lamp, ...]
    daylight: Daylight
    visuals: Visuals
    spaces: tuple[Space, ...] = ()
    doors: tuple[Door, ...] = ()
    gateways: tuple[Gateway, ...] = ()
    changes: tuple[Change, ...] = ()
    walls: tuple[tuple[float, float, float, float], ...] = ()
    routes: dict[str, Route] = field(default_factory=dict)
    walks: tuple[Walk, ...] = ()
    blocks: Blocks | None = None
