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
from khepera_forage.envs.batch.place import arena_array, site_array, site_walls
from khepera_forage.envs.batch.rounds import begin_episode, carry_out, decide
from khepera_forage.envs.batch.task import drive
from khepera_forage.envs.checks import FoodOdds, food_odds, the_arena, whole_number
from khepera_forage.foraging.scoring import score
from khepera_forage.noise import Noise
from khepera_forage.worlds.arena import Arena
from khepera_forage.worlds.batch import rows as body
from khepera_forage.worlds.batch.compiling import kernel
from khepera_forage.worlds.batch.numbers import keys_of
from khepera_forage.worlds.batch.rows import LANES
from khepera_forage.worlds.batch.setting import edges_of, noise_of, walls_of
from khepera_forage.worlds.batch.sources import SOURCES
from khepera_forage.worlds.standing import cable_anchor, check_seen

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
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    keys: NDArray[np.uint64],
    t: NDArray[np.float64],
    q: NDArray[np.float64],
    foods: int,
    walls: NDArray[np.float64],
    corners: NDArray[np.float64],
    noise: NDArray[np.float64],
    place: NDArray[np.float64],
    pixel_walls: NDArray[np.float64],
    arena: NDArray[np.float64],
    odds: NDArray[np.float64],
    limit: int,
    episode_keys: NDArray[np.uint64],
    first: int,
    stride: int,
    results: NDArray[np.int64],
) -> None:
    """Play the episodes `first`, `first + stride`, `first + 2 * stride` ... in one block."""
    episodes = episode_keys.shape[0]
    coming = first
    playing = 0
    for i in range(LANES):
        t[at.EPISODE * LANES + i] = coming if coming < episodes else -1
        playing += 1 if coming < episodes else 0
        keys[body.KEY * LANES + i] = episode_keys[min(coming, episodes - 1)]
        keys[body.ROUND * LANES + i] = 0
        begin_episode(s, f, keys, t, q, i, foods, walls, arena, noise, odds)
        coming += stride
    while playing > 0:
        _teach(t)
        decide(t, s)
        drive(s, t, place)
        carry_out(s, f, keys, t, q, foods, walls, corners, noise, place, pixel_walls, limit)
        for i in range(LANES):
            if t[at.TERMINATED * LANES + i] == 0.0 and t[at.TRUNCATED * LANES + i] == 0.0:
                continue
            steps = t[at.STEPS * LANES + i]
            episode = int(t[at.EPISODE * LANES + i])
            if episode >= 0:
                results[episode, STEPS] = int(steps)
                results[episode, CORRECT] = int(t[at.CORRECT * LANES + i])
                results[episode, DELIVERED] = int(t[at.DELIVERED * LANES + i])
                results[episode, POISON_HOME] = int(t[at.POISON_HOME * LANES + i])
                results[episode, DELIVERABLE] = int(t[at.DELIVERABLE * LANES + i])
                playing -= 1
            t[at.EPISODE * LANES + i] = coming if coming < episodes else -1
            playing += 1 if coming < episodes else 0
            keys[body.KEY * LANES + i] = episode_keys[min(coming, episodes - 1)]
            keys[body.ROUND * LANES + i] = 0
            begin_episode(s, f, keys, t, q, i, foods, walls, arena, noise, odds)
            coming += stride


def _compile(sources: int):  # type: ignore[no-untyped-def]
    """The kernel that Python calls; see `sources` for why it is made here."""

    @numba.njit(parallel=True, error_model="numpy", boundscheck=False, cache=True)
    def forage(  # type: ignore[no-untyped-def]
        robots,
        food,
        keys,
        tasks,
        registers,
        foods,
        walls,
        corners,
        noise,
        place,
        pixel_walls,
        arena,
        odds,
        limit,
        episode_keys,
        results,
    ):
        blocks = robots.shape[0] if sources else 0
        for block in prange(blocks):
            _play(
                robots[block],
                food[block],
                keys[block],
                tasks[block],
                registers[block],
                foods,
                walls,
                corners,
                noise,
                place,
                pixel_walls,
                arena,
                odds,
                limit,
                episode_keys,
                np.int64(block),  # type: ignore[arg-type]
                blocks,
                results,
            )

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
    the = the_arena(arena)
    check_seen([the])
    episodes, num_worlds = whole_number("episodes", episodes, 1), whole_number("num_worlds", num_worlds, 1)
    if whole_number("foods", foods, 1) > body.MOST_FOODS:
        raise ValueError(f"foods is {foods!r}; allowed: 1 to {body.MOST_FOODS} in a batch")
    blocks = -(-min(num_worlds, episodes) // LANES)
    results = np.zeros((episodes, COLUMNS), np.int64)
    noise = Noise.laboratory() if noise is None else noise
    _forage(
        np.zeros((blocks, body.ROBOT_ROWS * LANES)),
        np.zeros((blocks, foods * body.FOOD_ROWS * LANES)),
        np.zeros((blocks, body.KEY_ROWS * LANES), np.uint64),
        np.zeros((blocks, at.TASK_ROWS * LANES)),
        np.zeros((blocks, foods * at.TASK_FOOD_ROWS * LANES)),
        foods,
        walls_of(the),
        edges_of(the),
        noise_of(noise, cable_anchor([the]), 2, wheel_speed),
        site_array(the),
        site_walls(the),
        arena_array(the),
        np.array(food_odds(food_types)),
        whole_number("limit", limit, 1),
        keys_of(seed, np.arange(episodes)),
        results,
    )
    steps, correct, delivered, poison_home, deliverable = results.T
    scores = [
        score(*row)
        for row in zip(*(c.tolist() for c in (correct, steps, delivered, deliverable)), strict=True)
    ]
    return Episodes(np.array(scores), steps, correct, delivered, poison_home, deliverable)
