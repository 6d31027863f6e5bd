"""Our side: compiled bodies with the same commands, and the whole task under the teacher. Needs numba."""

from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation import entry, share_out
from khepera_forage.counter_rng import keys_of
from khepera_forage.noise import Noise
from khepera_forage.records import array_of
from khepera_forage.robots.khepera import MAX_SPEED
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.sim.camera import forget_tracks
from khepera_forage.sim.compiled.world import (
    advance,
    corner_dtype,
    detection_dtype,
    food_dtype,
    robot_dtype,
    track_dtype,
    wall_dtype,
)
from khepera_forage.sim.driving import put_down
from khepera_forage.sim.layout_checks import cable_anchor
from khepera_forage.sim.records import Enclosure, constants_of
from kheperax_comparison.theirs import Timed
from kheperax_comparison.work import ARENA, FOODS, HELD, ROUNDS, TIMING, Work

EPISODES_A_WORLD = 4
"""Episodes of the whole task for each world of the other lines, so that all threads end at about the same time."""
_TASKS = {"corridor": (1, 500), "rectangle": (len(FOODS), 700)}
"""Food objects and limit of the whole task by arena."""
_HOLES = 2
_LEAST = 512
"""Worlds for which another thread pays."""


class CompiledBodies:
    """The bodies of many worlds, without task.

    Args:
        worlds: How many.
        noise: Of wheels and sensors.
    """

    def __init__(self, worlds: int, noise: Noise) -> None:
        self._robots = np.zeros((worlds, 1), robot_dtype)
        self._robots["holes"] = _HOLES
        self._foods = np.zeros((worlds, len(FOODS)), food_dtype)
        self._tracks = np.zeros((worlds, 2 * len(FOODS)), track_dtype)
        self._detections = np.zeros((worlds, len(FOODS)), detection_dtype)
        self._walls = np.array(list(map(tuple, ARENA.wall_records)), wall_dtype)
        self._corners = np.array([(x, y) for x, y, _, _ in ARENA.corners], corner_dtype)
        self._anchor = cable_anchor([ARENA])
        self._constants = array_of(constants_of(noise, TIMING))

    def reset(self, seed: int, starts: NDArray[np.float64]) -> None:
        """Put robots and food in their places, and take the first frame.

        Args:
            seed: Of all worlds.
            starts: x mm, y mm and heading in radians, shape (worlds, 3).
        """
        worlds = len(self._robots)
        self._robots["key"] = keys_of(np.arange(seed, seed + worlds, dtype=np.uint64))[:, None]
        self._robots["round"] = 0
        self._foods["x"], self._foods["y"] = np.array(FOODS).T
        _begin(self._robots, self._foods, self._tracks, starts, self._constants)
        self.advance(np.zeros((worlds, 2)))

    def advance(self, wheels: NDArray[np.float64]) -> None:
        """One round of 0.1 s; `wheels` in speed units, shape (worlds, 2). The gripper stays raised and open."""
        share_out(
            _advance,
            len(self._robots),
            *(self._robots, self._foods, self._tracks, self._detections, self._walls, self._corners),
            *(*self._anchor, self._constants, wheels),
            least=_LEAST,
        )

    def proximity(self) -> NDArray[np.int64]:
        """The eight infra-red readings of each robot, as a fresh array."""
        return self._robots["proximity"][:, 0].astype(np.int64)

    def poses(self) -> NDArray[np.float64]:
        """X mm, y mm and heading in radians of each robot, shape (worlds, 3)."""
        return np.stack([self._robots[name][:, 0] for name in ("x", "y", "heading")], axis=1)


@entry
def _begin(robots: Any, foods: Any, tracks: Any, starts: Any, constants: Any) -> None:
    for i in range(len(robots)):
        put_down(robots[i, 0], starts[i, 0], starts[i, 1], starts[i, 2], constants[0])
        forget_tracks(foods[i], tracks[i])


@entry
def _advance(
    first: int,
    last: int,
    robots: Any,
    foods: Any,
    tracks: Any,
    detections: Any,
    walls: Any,
    corners: Any,
    anchor_x: float,
    anchor_y: float,
    constants: Any,
    wheels: Any,
) -> None:
    """One round in the worlds from `first` to `last`."""
    for i in range(first, last):
        robots[i, 0].left, robots[i, 0].right = wheels[i, 0], wheels[i, 1]
        everything = Enclosure(robots[i], foods[i], tracks[i], detections[i], walls, corners)
        advance(everything, anchor_x, anchor_y, constants[0])


class OurBodies:
    """Compiled bodies for the same work, by noise and number of worlds.

    Args:
        work: For at least as many worlds as are needed.
        seed: Of the worlds' random numbers.
    """

    def __init__(self, work: Work, seed: int) -> None:
        self._work, self._seed = work, seed
        self._ready: dict[tuple[bool, int], tuple[CompiledBodies, float]] = {}

    def timed(self, noisy: bool, worlds: int, at_least: float, calls: bool) -> Timed:
        """Whole episodes until `at_least` seconds have passed, without the time of the resets.

        Args:
            noisy: With the laboratory's noise; otherwise none.
            worlds: How many together.
            at_least: Seconds.
            calls: Return the readings to Python after every round.
        """
        bodies, first_call = self._bodies(noisy, worlds)
        commands = np.round(self._work.wheels[:, :worlds] * MAX_SPEED)
        seconds, steps = 0.0, 0
        while seconds < at_least:
            bodies.reset(self._seed, self._work.starts[:worlds])
            begun = perf_counter()
            for command in commands:
                for _ in range(HELD):
                    bodies.advance(command)
                    if calls:
                        bodies.proximity()
            seconds += perf_counter() - begun
            steps += ROUNDS * worlds
        return Timed(worlds, steps, seconds, first_call)

    def poses(self, worlds: int) -> NDArray[np.float64]:
        """The present poses of the robots without noise, shape (worlds, 3)."""
        return self._bodies(False, worlds)[0].poses()

    def _bodies(self, noisy: bool, worlds: int) -> tuple[CompiledBodies, float]:
        if (noisy, worlds) not in self._ready:
            bodies = CompiledBodies(worlds, Noise.laboratory() if noisy else Noise.none())
            begun = perf_counter()
            bodies.reset(self._seed, self._work.starts[:worlds])
            self._ready[noisy, worlds] = bodies, perf_counter() - begun
        return self._ready[noisy, worlds]


def whole_task(arena: str, worlds: int, seed: int, at_least: float) -> Timed:
    """The whole task in the kernel: the teacher forages, in the laboratory's noise.

    Args:
        arena: `corridor` with one food object, or `rectangle` with as many as the work has obstacles.
        worlds: How many together.
        seed: Of the episodes.
        at_least: Seconds.
    """
    foods, limit = _TASKS[arena]
    begun = perf_counter()
    run_teacher(arena, 1, seed, foods=foods, limit=1)
    first_call = perf_counter() - begun
    seconds, steps, episodes = 0.0, 0, EPISODES_A_WORLD * worlds
    while seconds < at_least:
        begun = perf_counter()
        foraged = run_teacher(arena, episodes, seed, foods=foods, limit=limit)
        seconds += perf_counter() - begun
        steps += int(foraged.steps.sum())
    return Timed(worlds, steps, seconds, first_call)
