"""Our side: `BatchWorld` given the same commands, and the whole task under the teacher. Needs numba."""

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from _kheperax.theirs import Timed
from _kheperax.work import ARENA, FOODS, HELD, ROUNDS, Work
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, MAX_SPEED
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.sim.compiled import BatchWorld

EPISODES_A_WORLD = 4
"""Episodes of the whole task for each world in memory: the blocks of worlds then end at about the same time."""
_TASKS = {"corridor": (1, 500), "rectangle": (len(FOODS), 700)}
"""Food objects and limit of the whole task by arena."""


class Bodies:
    """`BatchWorld`s of the same work, by noise and number of worlds.

    Args:
        work: For at least as many worlds as will be asked for.
        seed: Of the worlds' random numbers.
    """

    def __init__(self, work: Work, seed: int) -> None:
        self._work, self._seed = work, seed
        self._ready: dict[tuple[bool, int], tuple[BatchWorld, float]] = {}

    def timed(self, noisy: bool, worlds: int, at_least: float, calls: bool) -> Timed:
        """Whole episodes until `at_least` seconds have passed; putting robots back is not counted.

        Args:
            noisy: The laboratory's noise; otherwise none.
            worlds: How many together.
            at_least: Seconds.
            calls: Hand the readings to Python after every round.
        """
        batch, first_call = self._batch(noisy, worlds)
        motors = self._motors(worlds)
        seconds, steps = 0.0, 0
        while seconds < at_least:
            self._reset(batch)
            begun = perf_counter()
            for command in motors:
                for _ in range(HELD):
                    batch.advance(command)
                    if calls:
                        batch.senses()
            seconds += perf_counter() - begun
            steps += ROUNDS * worlds
        return Timed(worlds, steps, seconds, first_call)

    def poses(self, worlds: int) -> NDArray[np.float64]:
        """Where the robots without noise stand now, shape (worlds, 3)."""
        return self._batch(False, worlds)[0].poses()

    def _batch(self, noisy: bool, worlds: int) -> tuple[BatchWorld, float]:
        if (noisy, worlds) not in self._ready:
            noise = Noise.laboratory() if noisy else Noise.none()
            batch = BatchWorld(ARENA, worlds, len(FOODS), noise)
            begun = perf_counter()
            self._reset(batch)  # advances once
            self._ready[noisy, worlds] = batch, perf_counter() - begun
        return self._ready[noisy, worlds]

    def _reset(self, batch: BatchWorld) -> None:
        batch.reset(self._seed, self._work.starts[: batch.num_worlds], FOODS)

    def _motors(self, worlds: int) -> NDArray[np.float64]:
        wheels = np.round(self._work.wheels[:, :worlds] * MAX_SPEED)
        gripper = np.broadcast_to((ARM_RAISED, JAW_OPEN), wheels.shape)
        return np.concatenate((wheels, gripper), axis=2).astype(np.float64)


def whole_task(arena: str, worlds: int, seed: int, at_least: float) -> Timed:
    """The whole task in the kernel: the teacher forages, the laboratory's noise.

    Args:
        arena: `corridor`, with one food object, or `rectangle`, with as many as the work has obstacles.
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
