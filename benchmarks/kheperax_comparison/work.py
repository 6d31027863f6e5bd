"""The work of both sides: an arena with four obstacles, starts of robots, and commands of their wheels."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.robots.khepera import (
    FINGER_TIP,
    FOOD_RADIUS,
    MAX_SPEED,
    RADIUS,
    SPEED_UNIT,
)
from khepera_forage.robots.proximity import REACH, SENSORS
from khepera_forage.sim.arenas.thesis import RECTANGLE
from khepera_forage.task.decisions import Decisions

DECISIONS = Decisions.v0_1()
"""Fixed, so that both sides have the same steps of 0.1 s whatever the defaults are."""
ARENA, TIMING = checked_arena(RECTANGLE, DECISIONS), timing_of(DECISIONS)
FOODS = ((200.0, 200.0), (450.0, 200.0), (200.0, 400.0), (450.0, 400.0))
"""mm: centres of the cylinders; for Kheperax each is a square around the cylinder."""
COMMANDS, HELD = 8, 8
"""Commands of an episode, drawn at random, and the rounds that each is held."""
ROUNDS = COMMANDS * HELD
"""Rounds of an episode, after which robots go back to their starts."""
TRAVEL = MAX_SPEED * SPEED_UNIT * TIMING.round_duration
"""mm that a wheel rolls in a round at full speed."""
WHEEL_NOISE = 0.05 * TRAVEL / 2
"""mm: Kheperax adds this to a wheel's travel (standard deviation). The laboratory's slip of 5 %, at half speed."""
SENSOR_NOISE = 1.2
"""mm: Kheperax adds this to a distance. The laboratory's 10 % of a reading (uniform) corresponds to this at 30 mm."""


class Work(NamedTuple):
    """Starts and commands of robots.

    Attributes:
        starts: x mm, y mm and heading in radians, shape (worlds, 3).
        wheels: Left and right wheel as shares of full speed, -1..1 in whole speed units, shape
            (COMMANDS, worlds, 2).
    """

    starts: NDArray[np.float64]
    wheels: NDArray[np.float64]

    @classmethod
    def of(cls, worlds: int, seed: int) -> "Work":
        """Robots on the free floor, clear of walls and food, with random commands.

        Args:
            worlds: How many, at least 1.
            seed: Draws both.
        """
        rng = np.random.default_rng(seed)
        x1, y1, x2, y2 = ARENA.bounds
        room = FINGER_TIP + 1.0
        low, high = (x1 + room, y1 + room, -math.pi), (x2 - room, y2 - room, math.pi)
        starts = np.empty((0, 3))
        while len(starts) < worlds:
            drawn = rng.uniform(low, high, (worlds, 3))
            away = np.linalg.norm(drawn[:, None, :2] - np.array(FOODS), axis=2).min(axis=1)
            starts = np.concatenate((starts, drawn[away > room + FOOD_RADIUS]))
        wheels = rng.integers(-MAX_SPEED, MAX_SPEED + 1, (COMMANDS, worlds, 2)) / MAX_SPEED
        return cls(starts[:worlds], wheels)

    def for_kheperax(self, devices: int) -> dict[str, Any]:
        """Everything that `steps.py` needs, as arrays by name: lengths in mm, angles in radians.

        Args:
            devices: Processors to share the worlds among.
        """
        numbers = {
            "bounds": ARENA.bounds,
            "obstacles": FOODS,
            "half_side": FOOD_RADIUS,
            "radius": RADIUS,
            "reach": REACH,
            "directions": [math.atan2(across, along) for _, _, along, across in SENSORS],
            "travel": TRAVEL,
            "held": HELD,
            "wheel_noise": WHEEL_NOISE,
            "sensor_noise": SENSOR_NOISE,
            "devices": devices,
        }
        arrays = {name: np.asarray(value, np.float64) for name, value in numbers.items()}
        return {**arrays, "starts": self.starts, "wheels": self.wheels}
