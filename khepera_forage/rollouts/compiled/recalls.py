"""Recalls in thousands of compiled worlds: teacher, imitators and chance forage.

Every recall is a world of its own: what happens in recall i of a seed depends on its policy and on nothing else.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.compilation.aligned import aligned_zeros
from khepera_forage.compilation.threads import share_out, threads_for
from khepera_forage.counter_rng import keys_of
from khepera_forage.envs.arena_pool import Arenas
from khepera_forage.envs.arguments import FoodOdds, checked_decisions, whole_number
from khepera_forage.envs.compiled.batch import as_records
from khepera_forage.envs.compiled.prepared_arenas import recall_arenas
from khepera_forage.envs.layouts import no_room
from khepera_forage.noise import Noise
from khepera_forage.policies.nearest_neighbour.memories import NO_MEMORIES, Memories
from khepera_forage.rollouts.compiled.policy_kernel import TEACHER, UNIFORM, WITHOUT_ORIENTING
from khepera_forage.rollouts.compiled.records import decision_dtype, outcome_dtype
from khepera_forage.rollouts.compiled.rollout_kernel import Outcomes, Plan, run_all
from khepera_forage.sim.compiled.records import LANES
from khepera_forage.sim.compiled.stepping import advance_address
from khepera_forage.task.decisions import Decisions

__all__ = ["TEACHER", "UNIFORM", "WITHOUT_ORIENTING", "Episodes", "Recalls", "run_recalls", "run_teacher"]


class Episodes(NamedTuple):
    """What became of recalls, one element or row each; named as the fields of `rollouts.rows.RecallRow`.

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
        orient_without_food: Rounds in which ORIENT WITH FOOD was executed although the teacher would not have, and no
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
    orient_without_food: NDArray[np.int64]
    ties: NDArray[np.int64]
    conflicts: NDArray[np.int64]


class Recalls:
    """Recalls from random places: those of `Corridor-v1` and `Rectangle-v1` (4.6, 5.4).

    An arena is checked and prepared when a recall first takes place in it, which takes some milliseconds, and stays
    prepared for later runs.

    Args:
        arena: As for the environments.
        foods: Food objects in each recall, 1 to 16.
        limit: Steps after which a recall ends.
        noise: The laboratory's troubles by default.
        food_types: One type, or odds by type.
        wheel_speed: Share of the commanded speed that wheels reach: what a slower robot would do.
        decisions: Ours by default.

    Raises:
        ValueError: An argument out of range.
    """

    def __init__(
        self,
        arena: Arenas = "corridor",
        *,
        foods: int = 1,
        limit: int = 500,
        noise: Noise | str | None = None,
        food_types: FoodOdds = None,
        wheel_speed: float = 1.0,
        decisions: Decisions | None = None,
    ) -> None:
        self._foods = foods
        self._arenas = recall_arenas(
            arena, foods, limit, noise, food_types, checked_decisions(decisions), wheel_speed
        )

    def run(
        self, memories: Memories | None, memory_of_episode: ArrayLike, seed: int | NDArray[np.int64] = 0
    ) -> Episodes:
        """Run recalls; earlier runs do not change their results.

        Args:
            memories: What the imitators have learned, from `policies.nearest_neighbour.memories.memories_of`; None
                without imitators.
            memory_of_episode: The policy of each recall: the number of a memory, `TEACHER`, or `UNIFORM`.
            seed: Recall i is the one that an environment on the backend "compiled" has after `reset(seed=seed + i)`.
                Or one seed a recall.

        Raises:
            ValueError: An argument out of range, or an arena with no room.
        """
        memories = NO_MEMORIES if memories is None else memories
        policies = _checked_policies(memory_of_episode, len(memories.planes) - 1)
        count, foods, arenas = len(policies), self._foods, self._arenas
        outcomes = Outcomes(
            np.zeros(count, outcome_dtype),
            np.zeros((count, foods, 2)),
            np.zeros((count, foods), np.bool_),
            np.ones(1, np.bool_),
        )
        # As few worlds at a time as keep all threads busy: fewest are idle while the last recalls end.
        threads = threads_for(-(-count // LANES))
        keys, several = _keys(seed, count), arenas.several
        arenas.forget()
        indices = arenas.next(keys, np.zeros(count, np.int64)) if several else ()
        plan = Plan(keys, policies, indices, np.zeros(1, np.int64), *as_records(None, None, foods))
        worlds, state = arenas.empty_worlds(threads), aligned_zeros((threads, LANES), decision_dtype)
        common = (worlds, arenas.parameters, arenas.task, memories, plan, state, outcomes)
        share_out(run_all, threads, *common, advance_address(LANES, run_all, 0, *common, 0, several=several))
        if not outcomes.free[0]:
            raise no_room(arenas[0].name if not several else "an arena", foods)
        return _episodes(outcomes)


def run_recalls(
    arena: Arenas,
    memories: Memories | None,
    memory_of_episode: ArrayLike,
    seed: int | NDArray[np.int64] = 0,
    **settings: Any,
) -> Episodes:
    """Run recalls once, without keeping what is prepared of their arenas.

    Args:
        arena: As for the environments.
        memories: As for `Recalls.run`.
        memory_of_episode: As for `Recalls.run`.
        seed: As for `Recalls.run`.
        **settings: Further arguments of `Recalls`.

    Raises:
        ValueError: An argument out of range, or an arena with no room.
    """
    return Recalls(arena, **settings).run(memories, memory_of_episode, seed)


def run_teacher(arena: Arenas = "corridor", episodes: int = 4096, seed: int = 0, **settings: Any) -> Episodes:
    """Run recalls under the teacher.

    Args:
        arena: As for the environments.
        episodes: How many.
        seed: As for `Recalls.run`.
        **settings: Further arguments of `Recalls`.

    Raises:
        ValueError: An argument out of range, or an arena with no room.
    """
    return run_recalls(arena, None, np.full(whole_number("episodes", episodes, 1), TEACHER), seed, **settings)


def _episodes(outcomes: Outcomes) -> Episodes:
    """What became of the recalls, in arrays of their own."""

    def whole(name: str) -> NDArray[np.int64]:
        values: NDArray[Any] = outcomes.recalls[name]
        return values.astype(np.int64)

    return Episodes(
        score=outcomes.recalls["score"].copy(),
        steps=whole("steps"),
        correct=whole("correct"),
        delivered=whole("delivered"),
        poison_home=whole("poison_home"),
        deliverable=whole("deliverable"),
        penalty=outcomes.recalls["penalty"].copy(),
        start=outcomes.recalls["start"].copy(),
        foods=outcomes.foods,
        food_delivered=outcomes.collected,
        rounds_by_state=whole("by_state"),
        wrong_by_state=whole("wrong_by_state"),
        orient_without_food=whole("orient_without_food"),
        ties=whole("ties"),
        conflicts=whole("conflicts"),
    )


def _keys(seed: int | NDArray[np.int64], count: int) -> NDArray[np.uint64]:
    if not isinstance(seed, np.ndarray):
        first = np.uint64(whole_number("seed", seed, 0) & 0xFFFFFFFFFFFFFFFF)
        return keys_of(first + np.arange(count, dtype=np.uint64))
    if seed.shape != (count,) or seed.min() < 0:
        raise ValueError(
            f"seed is an array of shape {seed.shape}, the least {seed.min()}; allowed: one seed of at least 0 for each "
            f"of {count} episodes"
        )
    return keys_of(seed.astype(np.uint64))


def _checked_policies(given: ArrayLike, memories: int) -> NDArray[np.int64]:
    """The policy of each recall.

    Raises:
        ValueError: A policy that does not exist.
    """
    policies = np.asarray(given)
    if policies.ndim != 1 or policies.dtype.kind not in "iu" or not len(policies):
        raise ValueError(
            f"memory_of_episode is {given!r}; allowed: one whole number an episode, one episode or more"
        )
    for policy in (int(policies.min()), int(policies.max())):
        if not WITHOUT_ORIENTING <= policy < memories:
            raise ValueError(
                f"memory_of_episode has {policy}; allowed: {WITHOUT_ORIENTING} (teacher without orienting), "
                f"{UNIFORM} (uniform), {TEACHER} (teacher), and numbers of "
                f"the {memories} memories, from 0"
            )
    return policies.astype(np.int64)
