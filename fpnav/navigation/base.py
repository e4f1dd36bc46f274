"""What a policy and a robot agree on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from fpnav.values import Frame, Pose2, Signature


@dataclass(frozen=True, slots=True)
class Command:
    """Speeds asked of the robot, held until the next command."""

    linear_mps: float
    angular_radps: float


HALT = Command(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Task:
    """What a robot is to do on a map: come to a goal, or, without one, go the mapped way again.

    ``goal`` : name or number of a place, or a pose in the frame of the mapping run's poses;
    ``route`` : name of the way, for maps of several
    """

    goal: str | Pose2 | None = None
    route: str = ""


@dataclass(frozen=True, slots=True)
class Decision:
    """What one frame led to.

    ``place`` : the winner, -1 none, and its ``activity``; ``wanted_rad`` : bearing to go, in the
    robot's frame, NaN none; ``agreement`` : how far the active places agree, in [0, 1];
    ``arrived`` : the winner is where the task ends
    """

    place: int
    activity: float
    wanted_rad: float
    agreement: float = 1.0
    arrived: bool = False


class Policy(Protocol):
    """Decides, frame by frame, where to go."""

    @property
    def decision(self) -> Decision:
        """The last decision."""
        ...

    def act(self, frame: Frame) -> Command:
        """The command for what is seen now."""
        ...

    def decide(self, signature: Signature) -> Decision:
        """The decision that a signature leads to, nobody being moved: policies on a log."""
        ...


class Body(Protocol):
    """Something that moves and sees: a robot, real or simulated."""

    def step(self, command: Command) -> Frame:
        """Carry out the command for one decision period; what is seen at its end."""
        ...
