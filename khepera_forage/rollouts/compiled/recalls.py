"""Recalls in compiled worlds, one after the other without Python in between: teacher, imitators and chance forage.

Every recall is a world of its own: what happens in recall i of a seed depends on its policy and on nothing else.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.compilation import entry, rule, share_out
from khepera_forage.counter_rng import DRAW_POLICY, draw, keys_of, upper
from khepera_forage.envs.arguments import ArenaPool, Arenas, FoodOdds, Settings, whole_number
from khepera_forage.envs.compiled.arenas import PreparedArenas, arena_at, map_of, settings_record
from khepera_forage.envs.compiled.step import WorldRecords, begin, carry_out, drive, motors_of, new_worlds, world_of
from khepera_forage.noise import Noise
from khepera_forage.policies.memories import NO_MEMORIES, Memories, plane_key
from khepera_forage.records import dtype_of
from khepera_forage.rollouts.compiled.imitators import clear, draw_label, nearest_votes
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.sim.arena import Arena
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.task.episode import DecisionCounts, count_decision
from khepera_forage.task.food_tracking import is_collected
from khepera_forage.task.states import NUM_BEHAVIOURS, Behaviour, State
from khepera_forage.vision.scene import MM_PER_PIXEL

TEACHER, UNIFORM, WITHOUT_ORIENTING = -1, -2, -3
"""Policies that need no memory: the teacher; every behaviour equally likely; and the teacher with SEARCH FOR FOOD in
the place of ORIENT WITH FOOD. From 0 on: imitators."""

_BEYOND = 1 << 16  # pixels
_NEXT_TO_FOOD, _SEARCH_FOR_FOOD = State.NEXT_TO_FOOD.value, Behaviour.SEARCH_FOR_FOOD.value
_LEAST = 32
"""Recalls for which another thread pays."""


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


@dataclass(slots=True)
class _Recall:
    """One recall: its policy with the latest votes, and what became of it, as in `Episodes`.

    Attributes:
        policy: Number of a memory, or one of the policies above.
        query: State vector of the votes below, as one number; -1 without votes.
        total: Number of votes.
        votes: For each behaviour.
    """

    policy: int = TEACHER
    query: int = -1
    total: int = 0
    votes: list[int] = field(default_factory=lambda: [0] * NUM_BEHAVIOURS)
    ties: int = 0
    conflicts: int = 0
    counts: DecisionCounts = field(default_factory=DecisionCounts)
    deliverable: int = 0
    delivered: int = 0
    poison_home: int = 0
    score: float = 0.0
    penalty: float = 0.0
    steps: int = 0
    correct: int = 0
    start: list[float] = field(default_factory=lambda: [0.0] * 3)


_recall_dtype = dtype_of(_Recall)


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
        noise: Noise | str | None = "laboratory",
        food_types: FoodOdds = None,
        decisions: Decisions | None = None,
    ) -> None:
        settings = Settings.of(arena, noise, food_types, decisions)
        marker = settings.decisions.recall_marker
        self._foods, self._record = foods, settings_record(settings, foods, limit, marker)
        self._arenas = PreparedArenas(ArenaPool(arena, settings.decisions))

    def run(
        self, memories: Memories | None, memory_of_episode: ArrayLike, seed: int | NDArray[np.int64] = 0
    ) -> Episodes:
        """Run recalls; earlier runs do not change their results.

        Args:
            memories: What the imitators have learned, from `policies.memories.memories_of`; None
                without imitators.
            memory_of_episode: The policy of each recall: the number of a memory, `TEACHER`, or `UNIFORM`.
            seed: Recall i has the world of an environment on the backend "compiled" after `reset(seed=seed + i)`. Or
                one seed a recall.

        Raises:
            ValueError: An argument out of range, or an arena with no room.
        """
        memories = NO_MEMORIES if memories is None else memories
        policies = _checked_policies(memory_of_episode, len(memories.planes) - 1)
        count, foods, arenas = len(policies), self._foods, self._arenas
        keys = _keys(seed, count)
        arenas.forget(np.zeros(0, np.int64))
        places = arenas.of_episodes(keys, np.zeros(count, np.int64))
        recalls = np.zeros(count, _recall_dtype)
        recalls["policy"], recalls["query"] = policies, -1
        food_places, collected = np.zeros((count, foods, 2)), np.zeros((count, foods), np.bool_)
        free = np.ones(1, np.bool_)
        share_out(
            _run_recalls,
            count,
            *(arenas.blocks, places, self._record, memories),
            *(keys, recalls, food_places, collected, free),
            scratch=lambda: (new_worlds(1, foods),),
            least=_LEAST,
        )
        if not free[0]:
            raise arenas.no_room(places, foods)
        counts = recalls["counts"]
        return Episodes(
            foods=food_places,
            food_delivered=collected,
            rounds_by_state=counts["by_state"].copy(),
            wrong_by_state=counts["wrong_by_state"].copy(),
            orient_without_food=counts["orient_without_food"].copy(),
            **{name: recalls[name].copy() for name in Episodes._fields if name in (recalls.dtype.names or ())},
        )


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


@entry
def _run_recalls(
    first: int,
    last: int,
    blocks: Any,
    places: Any,
    settings: Any,
    memories: Memories,
    keys: Any,
    recalls: Any,
    food_places: Any,
    collected: Any,
    free: Any,
    worlds: WorldRecords,
) -> None:
    """Run the recalls from `first` to `last`, one after the other in the only one of `worlds`."""
    world = world_of(worlds, 0)
    episode, tracker = world.foragers[0].episode, world.trackers[0]
    for number in range(first, last):
        arena = arena_at(blocks, places[number])
        world.robots[0].key, world.robots[0].round = keys[number], 0
        world.foragers[0].number = 0
        if not begin(world, arena, settings[0], False, False):
            free[0] = False
        recall, start = recalls[number], world.robots[0]
        recall.start[0], recall.start[1], recall.start[2] = start.x, start.y, start.heading
        for k in range(len(world.foods)):
            food_places[number, k, 0], food_places[number, k, 1] = world.foods[k].x, world.foods[k].y
        begun, diagonal = False, arena.numbers[0].map_diagonal
        while not (begun and (episode.terminated or episode.truncated)):
            # The first round takes the first frame; nothing is perceived before.
            behaviour = _decide(world, diagonal, settings[0].decisions, memories, recall) if begun else 0
            drive(world, motors_of(world, map_of(arena), settings[0], behaviour), behaviour)
            carry_out(world, arena, settings[0])
            begun = True
        _record(recall, episode, tracker)
        for k in range(len(world.foods)):
            collected[number, k] = is_collected(world.objects[k])


@rule
def _decide(world: WorldRecords, diagonal: float, decisions: Any, memories: Memories, recall: Any) -> int:
    """The policy's behaviour, which is counted.

    Args:
        world: The world.
        diagonal: Of its arena, pixels.
        decisions: `DecisionValues`.
        memories: Of all imitators.
        recall: The `_Recall` record; changed in place.
    """
    forager, robot = world.foragers[0], world.robots[0]
    behaviour = int(forager.state)  # states and behaviours correspond one to one (4.4.1)
    if recall.policy != TEACHER:
        chance = upper(draw(robot, DRAW_POLICY))
        if recall.policy == UNIFORM:
            behaviour = int(chance * NUM_BEHAVIOURS)
        elif recall.policy == WITHOUT_ORIENTING:
            behaviour = _SEARCH_FOR_FOOD if forager.state == _NEXT_TO_FOOD else int(forager.state)
        else:
            behaviour = _imitate(forager.vector, int(diagonal), decisions, memories, recall, chance)
    count_decision(recall.counts, forager.state, behaviour, forager.vector.robot_food_distance, decisions)
    return behaviour


@rule
def _imitate(vector: Any, diagonal: int, decisions: Any, memories: Memories, recall: Any, chance: float) -> int:
    """The behaviour of an imitator. A state vector that stays is not searched for again."""
    presence, food_type, arm = vector.object_presence, vector.food_type, vector.arms_height
    home, food = vector.robot_home_distance, vector.robot_food_distance
    query = (plane_key(presence, food_type, arm) * _BEYOND + home) * _BEYOND + food
    votes = recall.votes
    if recall.query != query:
        clear(votes)
        seen = presence, home, food_type, arm, food
        _, recall.total = nearest_votes(memories, recall.policy, seen, diagonal, votes, decisions.distance_arithmetic)
        recall.query = query
    behaviour = int(draw_label(votes, recall.total, chance))
    recall.ties += 1 if recall.total > 1 else 0
    recall.conflicts += 1 if votes[behaviour] < recall.total else 0
    return behaviour


@rule
def _record(recall: Any, episode: Any, tracker: Any) -> None:
    """Write down what became of a recall."""
    recall.steps, recall.correct = episode.steps, episode.correct
    recall.penalty, recall.score = episode.penalty, episode.score
    recall.delivered, recall.poison_home = tracker.delivered, tracker.poison_home
    recall.deliverable = tracker.deliverable


def _keys(seed: int | NDArray[np.int64], count: int) -> NDArray[np.uint64]:
    if not isinstance(seed, np.ndarray):
        first = whole_number("seed", seed, 0)
        return keys_of(range(first, first + count))
    if seed.shape != (count,) or seed.dtype.kind not in "iu" or seed.min() < 0:
        raise ValueError(
            f"seed is an array of {seed.dtype} and shape {seed.shape}, the least {seed.min()}; allowed: one whole "
            f"number of at least 0 for each of {count} episodes"
        )
    return keys_of(seed)


def _checked_policies(given: ArrayLike, memories: int) -> NDArray[np.int64]:
    """The policy of each recall.

    Raises:
        ValueError: A policy that does not exist.
    """
    policies = np.asarray(given)
    if policies.ndim != 1 or policies.dtype.kind not in "iu" or not len(policies):
        raise ValueError(f"memory_of_episode is {given!r}; allowed: one whole number an episode, one episode or more")
    for policy in (int(policies.min()), int(policies.max())):
        if not WITHOUT_ORIENTING <= policy < memories:
            raise ValueError(
                f"memory_of_episode has {policy}; allowed: {WITHOUT_ORIENTING} (teacher without orienting), "
                f"{UNIFORM} (uniform), {TEACHER} (teacher), and numbers of "
                f"the {memories} memories, from 0"
            )
    return policies.astype(np.int64)


_NUMBERS = ("correct", "steps", "score", "delivered", "poison_home", "orient_without_food", "ties", "conflicts")
_LISTS = ("food_delivered", "rounds_by_state", "wrong_by_state")


def recall_rows(
    played: Episodes, arena: Arena, own: dict[str, list[Any]], decisions: Decisions, **common: Any
) -> list[RecallRow]:
    """One row an episode.

    Args:
        played: From `run_recalls`.
        arena: Theirs.
        own: Fields of `RecallRow` that an episode cannot know, by name, one value each.
        decisions: Theirs.
        **common: Those that all have in common.
    """
    columns: dict[str, list[Any]] = dict(own)
    for name in _NUMBERS:
        columns[name] = getattr(played, name).tolist()
    for name in _LISTS:
        columns[name] = list(map(tuple, getattr(played, name).tolist()))
    columns["penalty"] = played.penalty.astype(int).tolist()
    home = np.array(arena.home)
    columns["start_x"], columns["start_y"] = _pixels(played.start[:, :2] - home).T.tolist()
    columns["start_heading"] = np.round(np.degrees(played.start[:, 2]), 1).tolist()
    foods = _pixels(played.foods - home)
    columns["food_x"], columns["food_y"] = (list(map(tuple, foods[:, :, k].tolist())) for k in (0, 1))
    common |= {"arena": arena.name, "foods": foods.shape[1], "decisions": decisions_text(decisions)}
    rows = zip(*columns.values(), strict=True)
    return [RecallRow(**common, **dict(zip(columns, row, strict=True))) for row in rows]


def _pixels(places: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.round(places / MM_PER_PIXEL, 2)
