"""The World contract: bodies and time, no task."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from khepera_forage.robots.khepera import Robot
from khepera_forage.vision.scene import Camera
from khepera_forage.worlds.arena import Arena, Point, Pose


class Layout(NamedTuple):
    """Where everything stands at a reset, in mm and radians of the world's frame.

    Attributes:
        starts: One pose a robot, the teacher's first.
        foods: Centres of the food objects.
    """

    starts: tuple[Pose, ...]
    foods: tuple[Point, ...]


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
    def camera(self) -> Camera:
        """The camera above all arenas."""
        ...

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Put everything in its place. Same generator state and layout, same world, bit for bit."""
        ...

    def advance(self) -> None:
        """One round of 0.1 s: every command given since the last one takes effect together."""
        ...

    def close(self) -> None:
        """Stop the robots and let go of them; a second call does nothing."""
        ...
