"""What a policy and a robot agree on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from fpnav.values import Frame


@dataclass(frozen=True, slots=True)
class Command:
    """Speeds asked of the robot, held until the next command."""

    linear_mps: float
    angular_radps: float


HALT = Command(0.0, 0.0)


class Policy(Protocol):
    """Decides, frame by frame, where to go."""

    def act(self, frame: Frame) -> Command:
        """The command for what is seen now."""
        ...


class Body(Protocol):
    """Something that moves and sees: a robot, real or simulated."""

    def step(self, command: Command) -> Frame:
        """Carry out the command for one decision period; what is seen at its end."""
        ...
