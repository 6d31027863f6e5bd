"""Our side: compiled bodies with the same commands, and the whole task under the teacher. Needs numba."""

from time import perf_counter

import numpy as np
from khepera_forage.compilation.threads import BLOCKS_A_THREAD, threads_for
from khepera_forage.sim.compiled.bodies import empty_bodies
from khepera_forage.sim.compiled.parameters import parameters_of
from khepera_forage.sim.compiled.start import stand_in_blocks
from khepera_forage.sim.compiled.stepping import advance_all
from numpy.typing import NDArray

from khepera_forage.counter_rng import keys_of
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, MAX_SPEED
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.sim.compiled.records import LANES
from kheperax_comparison.theirs import Timed
from kheperax_comparison.work import ARENA, FOODS, HELD, ROUNDS, TIMING, Work

EPISODES_A_WORLD = 4
"""Episodes of the whole task for each world in memory, so that all blocks of worlds end at about the same time."""
_TASKS = {"corridor": (1, 500), "rectangle": (len(FOODS), 700)}
"""Food objects and limit of the whole task by arena."""
_HOLES = 2


class CompiledBodies:
    """The bodies of many worlds, without task.

    Args:
        worlds: How many.
        noise: Of wheels and sensors.
    """

    def __init__(self, worlds: int, noise: Noise) -> None:
        blocks = -(-worlds // LANES)
        self._lanes = np.arange(blocks * LANES) % worlds  # lanes beyond the last world repeat the first ones
        self._worlds = worlds
        self._bodies = empty_bodies(blocks, len(FOODS))
        self._parameters = parameters_of(ARENA, len(FOODS), noise, holes=_HOLES, timing=TIMING)
        self._threads = threads_for(blocks // BLOCKS_A_THREAD)

    def reset(self, seed: int, starts: NDArray[np.float64]) -> None:
        """Put robots and food in their places, and take the first frame.

        Args:
            seed: Of all worlds.
            starts: x mm, y mm and heading in radians, shape (worlds, 3).
        """
        robots, foods = self._bodies.robots, self._bodies.foods
        keys = keys_of(np.arange(seed, seed + len(self._lanes), dtype=np.uint64))
        robots["key"], robots["round"] = keys.reshape(-1, LANES), 0
        stand_in_blocks(self._bodies, self._parameters, starts[self._lanes])
        for number, (x, y) in enumerate(FOODS):
            foods["x"][:, number], foods["y"][:, number] = x, y
        self.advance(np.zeros((self._worlds, 2)))

    def advance(self, wheels: NDArray[np.float64]) -> None:
        """One round of 0.1 s; `wheels` in speed units, shape (worlds, 2). The gripper stays raised and open."""
        robots = self._bodies.robots
        robots["left"], robots["right"] = wheels[self._lanes].T.reshape(2, -1, LANES)
        robots["arm_target"], robots["jaw_target"] = ARM_RAISED, JAW_OPEN
        advance_all(self._bodies, self._parameters, self._threads)

    def proximity(self) -> NDArray[np.int64]:
        """The eight infra-red readings of each robot, as a fresh array."""
        readings: NDArray[np.float64] = self._bodies.robots["proximity"].swapaxes(1, 2).reshape(-1, 8)
        return readings[: self._worlds].astype(np.int64)

    def poses(self) -> NDArray[np.float64]:
        """X mm, y mm and heading in radians of each robot, shape (worlds, 3)."""
        fields = [self._bodies.robots[name].reshape(-1) for name in ("x", "y", "heading")]
        return np.stack(fields, axis=1)[: self._worlds].astype(np.float64)


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
