"""Whole episodes inside the kernel: the teacher forages in thousands of worlds, and no Python runs in between.

Every episode is a world of its own: what happens in episode i of a seed depends on nothing but both. A block of worlds
takes the next of its episodes whenever one of its lanes has ended one.
"""

from typing import NamedTuple

import numba
import numpy as np
from numba import prange
from numpy.typing import NDArray

from khepera_forage.envs.batch import rows as at
from khepera_forage.envs.batch.rounds import begin_episode, carry_out, decide
from khepera_forage.envs.batch.rules import Rules, rules_of
from khepera_forage.envs.batch.task import drive
from khepera_forage.envs.batch.worlds import Worlds, empty_worlds, worlds_of
from khepera_forage.envs.checks import FoodOdds, whole_number
from khepera_forage.foraging.scoring import score
from khepera_forage.noise import Noise
from khepera_forage.worlds.arena import Arena
from khepera_forage.worlds.batch import rows as body
from khepera_forage.worlds.batch.compiling import inline, kernel
from khepera_forage.worlds.batch.numbers import keys_of
from khepera_forage.worlds.batch.rows import LANES
from khepera_forage.worlds.batch.setting import Setting
from khepera_forage.worlds.batch.sources import SOURCES

# Columns of an episode's result.
STEPS, CORRECT, DELIVERED, POISON_HOME, DELIVERABLE, COLUMNS = range(6)


class Episodes(NamedTuple):
    """What became of episodes, one element each.

    Attributes:
        score: Equation 5.1, percent.
        steps: How many it took.
        correct: Steps on which the teacher would have done the same.
        delivered: Food brought home that is not poisonous.
        poison_home: Poisonous food brought home.
        deliverable: Food that was not known to be poisonous in the end.
    """

    score: NDArray[np.float64]
    steps: NDArray[np.int64]
    correct: NDArray[np.int64]
    delivered: NDArray[np.int64]
    poison_home: NDArray[np.int64]
    deliverable: NDArray[np.int64]


@kernel
def _teach(t: NDArray[np.float64]) -> None:
    """What the teacher does: states and behaviours stand one to one (4.4.1)."""
    for i in range(LANES):
        t[at.BEHAVIOUR * LANES + i] = t[at.STATE * LANES + i]


@kernel
def _play(
    worlds: Worlds,
    setting: Setting,
    rules: Rules,
    episode_keys: NDArray[np.uint64],
    first: int,
    stride: int,
    results: NDArray[np.int64],
) -> None:
    """Play the episodes `first`, `first + stride`, `first + 2 * stride` ... in one block."""
    s, t = worlds.bodies.robots, worlds.tasks
    coming = first
    playing = 0
    for i in range(LANES):
        playing += _next(worlds, i, setting, rules, episode_keys, coming)
        coming += stride
    while playing > 0:
        _teach(t)
        decide(t, s)
        drive(s, t, rules.place)
        carry_out(worlds, setting, rules)
        for i in range(LANES):
            if t[at.TERMINATED * LANES + i] == 0.0 and t[at.TRUNCATED * LANES + i] == 0.0:
                continue
            episode = int(t[at.EPISODE * LANES + i])
            if episode >= 0:
                results[episode, STEPS] = int(t[at.STEPS * LANES + i])
                results[episode, CORRECT] = int(t[at.CORRECT * LANES + i])
                results[episode, DELIVERED] = int(t[at.DELIVERED * LANES + i])
                results[episode, POISON_HOME] = int(t[at.POISON_HOME * LANES + i])
                results[episode, DELIVERABLE] = int(t[at.DELIVERABLE * LANES + i])
                playing -= 1
            playing += _next(worlds, i, setting, rules, episode_keys, coming)
            coming += stride


@inline
def _next(
    worlds: Worlds, i: int, setting: Setting, rules: Rules, episode_keys: NDArray[np.uint64], episode: int
) -> int:
    """Begin an episode in a lane, one that does not count when none is left; returns how many begin that count."""
    last = episode_keys.shape[0] - 1
    worlds.tasks[at.EPISODE * LANES + i] = episode if episode <= last else -1
    worlds.bodies.keys[body.KEY * LANES + i] = episode_keys[min(episode, last)]
    worlds.bodies.keys[body.ROUND * LANES + i] = 0
    begin_episode(worlds, i, setting, rules)
    return 1 if episode <= last else 0


def _compile(sources: int):  # type: ignore[no-untyped-def]
    """The kernel that Python calls; see `sources` for why it is made here."""

    @numba.njit(parallel=True, error_model="numpy", boundscheck=False, cache=True)
    def forage(bodies, tasks, registers, setting, rules, episode_keys, results):  # type: ignore[no-untyped-def]
        blocks = tasks.shape[0] if sources else 0
        for block in prange(blocks):
            worlds = worlds_of(bodies, tasks, registers, block)
            _play(worlds, setting, rules, episode_keys, np.int64(block), blocks, results)  # type: ignore[arg-type]

    return forage


_forage = _compile(SOURCES)


def run_teacher(
    arena: Arena | str = "corridor",
    episodes: int = 4096,
    seed: int = 0,
    *,
    foods: int = 1,
    limit: int = 500,
    noise: Noise | None = None,
    food_types: FoodOdds = None,
    num_worlds: int = 4096,
    wheel_speed: float = 1.0,
) -> Episodes:
    """Recalls under the teacher, start to end, from random places: those of `Corridor-v0` and `Rectangle-v0`.

    Args:
        arena: As for the environments.
        episodes: How many.
        seed: Episode i of a seed is the same whatever else is asked for.
        foods: Food objects in each, 1 to 16.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type.
        num_worlds: How many worlds to keep in memory at a time.
        wheel_speed: Share of the commanded speed that wheels reach: what a slower robot would do.

    Raises:
        ValueError: An argument out of range, or an arena with no room.
    """
    setting, rules = rules_of(arena, foods, limit, noise, food_types, wheel_speed)
    episodes, num_worlds = whole_number("episodes", episodes, 1), whole_number("num_worlds", num_worlds, 1)
    results = np.zeros((episodes, COLUMNS), np.int64)
    worlds = empty_worlds(-(-min(num_worlds, episodes) // LANES), foods)
    _forage(*worlds, setting, rules, keys_of(seed, np.arange(episodes)), results)
    steps, correct, delivered, poison_home, deliverable = results.T
    scores = [
        score(*row)
        for row in zip(*(c.tolist() for c in (correct, steps, delivered, deliverable)), strict=True)
    ]
    return Episodes(np.array(scores), steps, correct, delivered, poison_home, deliverable)
