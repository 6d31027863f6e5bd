"""Whole episodes inside the kernel: teacher, imitators and chance forage in thousands of worlds.

Every episode is a world of its own: what happens in episode i of a seed depends on who decides and on nothing beside.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.compilation.threads import share_out, threads_for
from khepera_forage.envs.arguments import FoodOdds, whole_number
from khepera_forage.envs.compiled.parameters import rules_of
from khepera_forage.envs.compiled.worlds import empty_worlds
from khepera_forage.noise import Noise
from khepera_forage.policies.ballot import BEHAVIOURS, Memories
from khepera_forage.policies.ballot_box import NO_MEMORIES
from khepera_forage.rollouts.compiled.policy_kernel import (
    CONFLICTS,
    GHOSTS,
    ROUNDS,
    TEACHER,
    TIES,
    UNIFORM,
    WRONG,
    empty_decisions,
)
from khepera_forage.rollouts.compiled.rollout_kernel import ACCOUNT, Plan, empty_outcomes, play_out
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.numbers import keys_of, keys_of_each
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.scoring import penalty

__all__ = ["TEACHER", "UNIFORM", "Episodes", "run_recalls", "run_teacher"]


class Episodes(NamedTuple):
    """What became of episodes, one element or row each; in the words of `rollouts.rows.RecallRow`.

    Attributes:
        score: Equation 5.1, percent.
        steps: How many it took.
        correct: Steps on which the teacher would have done the same.
        delivered: Food brought home that is not poisonous.
        poison_home: Poisonous food brought home.
        deliverable: Food that was not known to be poisonous in the end.
        penalty: Taken off for food that was left, percent.
        start: Where the robot stood: x, y (mm), heading (radians).
        foods: Where each food object lay: x, y (mm); shape (episodes, foods, 2).
        food_delivered: Whether each food object was delivered; shape (episodes, foods).
        rounds_by_state: Rounds in each of the ten states.
        wrong_by_state: Rounds of each in which the teacher would have done something else.
        orient_ghost: Rounds in which ORIENT WITH FOOD was executed although the teacher would not have, and no
            candidate food was within the close threshold.
        ties: Rounds in which several experience vectors were equally near.
        conflicts: Rounds with a tie between different behaviours.
    """

    score: NDArray[np.float64]
    steps: NDArray[np.int64]
    correct: NDArray[np.int64]
    delivered: NDArray[np.int64]
    poison_home: NDArray[np.int64]
    deliverable: NDArray[np.int64]
    penalty: NDArray[np.float64]
    start: NDArray[np.float64]
    foods: NDArray[np.float64]
    food_delivered: NDArray[np.bool_]
    rounds_by_state: NDArray[np.int64]
    wrong_by_state: NDArray[np.int64]
    orient_ghost: NDArray[np.int64]
    ties: NDArray[np.int64]
    conflicts: NDArray[np.int64]


def run_recalls(
    arena: Arena | str,
    memories: Memories | None,
    memory_of_episode: ArrayLike,
    seed: int | NDArray[np.int64] = 0,
    *,
    foods: int = 1,
    limit: int = 500,
    noise: Noise | None = None,
    food_types: FoodOdds = None,
    wheel_speed: float = 1.0,
) -> Episodes:
    """Recalls, start to end, from random places: those of `Corridor-v0` and `Rectangle-v0` (4.6, 5.4).

    Args:
        arena: As for the environments.
        memories: What the imitators have learned, from `policies.ballot_box.memories_of`; None where there are none.
        memory_of_episode: Who decides in each episode: the number of a memory, `TEACHER`, or `UNIFORM`.
        seed: Episode i of a seed has the same places, noise and draws whatever else is asked for. Or one seed an
            episode: it is then what `gym.make(..., physics="batch")` plays after `reset(seed=...)` with it.
        foods: Food objects in each, 1 to 16.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type.
        wheel_speed: Share of the commanded speed that wheels reach: what a slower robot would do.

    Raises:
        ValueError: An argument out of range, or an arena with no room.
    """
    setting, rules = rules_of(arena, foods, limit, noise, food_types, wheel_speed)
    memories = NO_MEMORIES if memories is None else memories
    policies = _policies(memory_of_episode, len(memories.planes) - 1)
    episodes = len(policies)
    outcomes = empty_outcomes(episodes, foods)
    # As few worlds at a time as keep all threads busy: the fewest are idle while the last episodes end.
    threads = threads_for(-(-episodes // LANES))
    plan = Plan(_keys(seed, episodes), policies, np.zeros(1, np.int64))
    worlds, decisions = empty_worlds(threads, foods), empty_decisions(threads)
    share_out(play_out, threads, worlds, setting, rules, memories, plan, decisions, outcomes)
    if np.isnan(outcomes.places).any():
        raise ValueError(
            f"{arena}: no room for a robot and {foods} food objects outside home; make it larger"
        )
    sums = outcomes.sums.astype(np.int64)
    steps, correct, delivered, poison_home, deliverable = sums.T[:ACCOUNT]
    taken = np.array([[penalty(k, n) for n in range(foods + 1)] for k in range(foods + 1)])
    penalties = taken[delivered, deliverable]
    account = sums[:, ACCOUNT - 1 :]
    return Episodes(
        100.0 * correct / steps - penalties,
        steps,
        correct,
        delivered,
        poison_home,
        deliverable,
        penalties,
        outcomes.places[:, :3],
        outcomes.places[:, 3:].reshape(episodes, foods, 2),
        outcomes.brought,
        account[:, ROUNDS : ROUNDS + BEHAVIOURS],
        account[:, WRONG : WRONG + BEHAVIOURS],
        account[:, GHOSTS],
        account[:, TIES],
        account[:, CONFLICTS],
    )


def run_teacher(
    arena: Arena | str = "corridor",
    episodes: int = 4096,
    seed: int = 0,
    *,
    foods: int = 1,
    limit: int = 500,
    noise: Noise | None = None,
    food_types: FoodOdds = None,
    wheel_speed: float = 1.0,
) -> Episodes:
    """Recalls under the teacher; see `run_recalls`.

    Args:
        arena: As for the environments.
        episodes: How many.
        seed: Episode i of a seed is the same whatever else is asked for.
        foods: Food objects in each, 1 to 16.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type.
        wheel_speed: Share of the commanded speed that wheels reach.

    Raises:
        ValueError: An argument out of range, or an arena with no room.
    """
    return run_recalls(
        arena,
        None,
        np.full(whole_number("episodes", episodes, 1), TEACHER),
        seed,
        foods=foods,
        limit=limit,
        noise=noise,
        food_types=food_types,
        wheel_speed=wheel_speed,
    )


def _keys(seed: int | NDArray[np.int64], episodes: int) -> NDArray[np.uint64]:
    if not isinstance(seed, np.ndarray):
        return keys_of(seed, np.arange(episodes))
    if seed.shape != (episodes,) or seed.min() < 0:
        raise ValueError(
            f"seed is an array of shape {seed.shape}, the least {seed.min()}; allowed: one seed of at least 0 for each "
            f"of {episodes} episodes"
        )
    return keys_of_each(seed.tolist())


def _policies(given: ArrayLike, memories: int) -> NDArray[np.int64]:
    """Who decides in each episode, once it is found to be in range."""
    policies = np.asarray(given)
    if policies.ndim != 1 or policies.dtype.kind not in "iu" or not len(policies):
        raise ValueError(
            f"memory_of_episode is {given!r}; allowed: one whole number an episode, one episode or more"
        )
    for policy in (int(policies.min()), int(policies.max())):
        if not UNIFORM <= policy < memories:
            raise ValueError(
                f"memory_of_episode has {policy}; allowed: {UNIFORM} (uniform), {TEACHER} (teacher), and numbers of "
                f"the {memories} memories, from 0"
            )
    return policies.astype(np.int64)
