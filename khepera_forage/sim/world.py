"""The World contract: bodies and time, no task."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from khepera_forage.robots.khepera import Robot, RobotLost
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.vision.scene import Camera
from khepera_forage.vision.video import CameraLost

LOST = RobotLost, CameraLost
"""What any method of a real world may raise: a robot or the camera is gone, and all robots have been stopped."""


class Layout(NamedTuple):
    """Where everything stands at a reset, in mm and radians of the world's frame.

    Attributes:
        starts: One pose a robot, the teacher's first.
        foods: Centres of the food objects.
    """

    starts: tuple[Pose, ...]
    foods: tuple[Point, ...]


class Timing(NamedTuple):
    """How a world moves in time.

    Attributes:
        round_duration: Seconds of one round.
        arm_speed: Positions of the arm a second.
        jaw_speed: Positions of the jaw a second.
    """

    round_duration: float
    arm_speed: float
    jaw_speed: float


class FoodPlace(NamedTuple):
    """Where a food object is.

    Attributes:
        x: Centre in mm.
        y: Centre in mm.
        lifted: Whether a raised gripper holds it.
    """

    x: float
    y: float
    lifted: bool


class World(Protocol):
    """Robots, food and a camera, advancing one round at a time."""

    @property
    def arenas(self) -> Sequence[Arena]:
        """The enclosures of this world."""
        ...

    @property
    def robots(self) -> Sequence[Robot]:
        """The robots, in the order of `Layout.starts`."""
        ...

    @property
    def markers(self) -> Sequence[int]:
        """Holes of each robot's marker, in the same order."""
        ...

    @property
    def camera(self) -> Camera:
        """The camera above all arenas."""
        ...

    @property
    def round_duration(self) -> float:
        """Seconds of one round."""
        ...

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Put everything in its place. Same generator state and layout, same world, bit for bit."""
        ...

    def advance(self) -> None:
        """One round: every command given since the last one takes effect together."""
        ...

    def poses(self) -> tuple[Pose, ...]:
        """Where the robots are, as well as this world knows it: for pictures and records, not for policies."""
        ...

    def food_places(self) -> tuple[FoodPlace, ...]:
        """Where the food is, in the order of `Layout.foods`, as well as this world knows it."""
        ...

    def place(self, robot: int, pose: Pose) -> None:
        """Take a robot up and put it down elsewhere, as an operator does to resume a paused training (5.3.1).

        Args:
            robot: Its number.
            pose: Where to; the robot keeps what it holds.

        Raises:
            ValueError: The place is not on the free floor.
        """
        ...

    def stop(self) -> None:
        """Stop the wheels of all robots, as at the end of every episode."""
        ...

    def close(self) -> None:
        """Stop the robots and let go of them; a second call does nothing."""
        ...
