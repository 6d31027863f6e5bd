"""What learners learn from: paired training (5.3) in the corridor, or in many procedural arenas."""

import math
from collections.abc import Iterator, Sequence
from itertools import count
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arena_generalisation.recall_arenas import RecallArena, procedural_arenas
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arena_settings import training_rounds
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.layouts import random_layout
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arenas.thesis import CORRIDOR as CORRIDOR_ARENA
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES, Decisions
from khepera_forage.task.placement import layout_key

EPISODES = 10
"""Training episodes, as many as the thesis's largest set has."""
ATTEMPTS = 20
"""Incomplete attempts at an episode in a procedural arena after which the next level is taken."""
CORRIDOR, VARIED = "corridor", "varied"
"""The two trainings of every learner."""
HALF, MOVED, WHOLE = "corridor, 5 episodes", "corridor, other places", "varied, all vectors"
"""Further trainings of the thesis's imitator."""
TRAININGS = (HALF, CORRIDOR, MOVED, VARIED, WHOLE)
_Episode = tuple[NDArray[np.int64], NDArray[np.int64]]
"""State vectors and behaviours."""


class Training(NamedTuple):
    """Experience to learn from.

    Attributes:
        vectors: State vectors, shape (n, 5).
        behaviours: What was heard with each, shape (n,).
        episodes: The training episode of each vector, shape (n,).
    """

    vectors: NDArray[np.int64]
    behaviours: NDArray[np.int64]
    episodes: NDArray[np.int64]

    def chosen(self, mask: NDArray[Any]) -> "Training":
        """Some of the vectors.

        Args:
            mask: As for indexing an array.
        """
        return Training(*(part[mask] for part in self))


def corridor_trainings(seed: int, replication: int) -> dict[str, Training]:
    """The experience of one replication in the corridor, by name.

    The corridor has no corner to drive around: straight distances and those along the path are the same.

    Args:
        seed: Of the whole run.
        replication: Its number, from 0.
    """
    same, other = np.random.SeedSequence(seed, spawn_key=(1, replication)).spawn(2)
    corridor = _joined([_episode(CORRIDOR_ARENA, key, DEFAULT_DECISIONS) for key in _keys(same)])
    places = _places(int(other.generate_state(1)[0]))
    keys = _keys(other.spawn(1)[0])
    moved = [_episode(CORRIDOR_ARENA, key, DEFAULT_DECISIONS, options=next(places)) for key in keys]
    return {
        HALF: corridor.chosen(corridor.episodes < EPISODES // 2),
        CORRIDOR: corridor,
        MOVED: _joined(moved),
    }


def varied_trainings(
    seed: int, replication: int, size: int, difficulties: Sequence[str], decisions: Decisions
) -> dict[str, Training]:
    """The experience of one replication in varied arenas, by name.

    Args:
        seed: Of the whole run.
        replication: Its number, from 0. Replications have training levels of their own.
        size: Vectors of `VARIED` at most, drawn at random from those of `WHOLE`.
        difficulties: Of the training arenas, in turn.
        decisions: Of the training; others change nothing else.
    """
    episodes, drawing = np.random.SeedSequence(seed, spawn_key=(2, replication)).spawn(2)
    whole = _joined([own for _, own in _varied_episodes(episodes, replication, difficulties, decisions)])
    number = len(whole.vectors)
    drawn = np.random.default_rng(drawing).choice(number, min(size, number), replace=False)
    return {VARIED: whole.chosen(np.sort(drawn)), WHOLE: whole}


def varied_arenas(seed: int, replication: int, difficulties: Sequence[str]) -> list[RecallArena]:
    """The arenas of the ten episodes of `varied_trainings`, with straight distances.

    Args:
        seed: As for `varied_trainings`; so are the others.
        replication: Its number.
        difficulties: Of the training arenas.
    """
    episodes, _ = np.random.SeedSequence(seed, spawn_key=(2, replication)).spawn(2)
    return [arena for arena, _ in _varied_episodes(episodes, replication, difficulties, DEFAULT_DECISIONS)]


def training_arenas(replication: int, difficulties: Sequence[str]) -> list[RecallArena]:
    """The first training arena of each difficulty in a replication."""
    return [next(_training_levels(name, replication)) for name in difficulties]


def _varied_episodes(
    seeds: np.random.SeedSequence, replication: int, difficulties: Sequence[str], decisions: Decisions
) -> list[tuple[RecallArena, _Episode]]:
    """One episode in each of ten training arenas, of every difficulty in turn."""
    levels = [_training_levels(name, replication) for name in difficulties]
    return [_first_complete(levels[k % len(levels)], key, decisions) for k, key in enumerate(_keys(seeds))]


def _training_levels(difficulty: str, replication: int) -> Iterator[RecallArena]:
    first = 100 * replication
    for level in count(first):
        yield from procedural_arenas(difficulty, "train", level, 1)


def _first_complete(
    levels: Iterator[RecallArena], key: int, decisions: Decisions
) -> tuple[RecallArena, _Episode]:
    """The first level in which a training episode is complete, and the episode; the levels up to it are used up."""
    for level in levels:
        try:
            return level, _episode(
                level.arena,
                key,
                decisions,
                max_cycles=training_rounds(level.limit),
                food_types=level.arguments["food_types"],
                noise=level.arguments["noise"],
                attempts=ATTEMPTS,
            )
        except IncompleteTrainingError:
            continue
    raise AssertionError("there are more levels than any training needs")


def _episode(arena: Any, key: int, decisions: Decisions, **kwargs: Any) -> _Episode:
    """State vectors and behaviours of one training episode."""
    from khepera_forage.rollouts.compiled.training import train_learners

    return train_learners(1, arena, key, decisions=decisions, **kwargs).experience_of(0).arrays()


def _joined(episodes: Sequence[_Episode]) -> Training:
    sizes = [len(behaviours) for _, behaviours in episodes]
    return Training(
        np.concatenate([vectors for vectors, _ in episodes]),
        np.concatenate([behaviours for _, behaviours in episodes]),
        np.repeat(np.arange(len(episodes)), sizes),
    )


def _places(seed: int) -> Iterator[dict[str, Any]]:
    """Start and food of one training episode in the corridor after another, at random as in recalls."""
    corridor, key = checked_arena(CORRIDOR_ARENA, DEFAULT_DECISIONS), key_of(seed)
    for number in count():
        layout = random_layout(corridor, 1, layout_key(key, number), DEFAULT_VALUES)
        start = layout.starts[0]
        yield {"start": (start.x, start.y, math.degrees(start.heading)), "foods": layout.foods}


def _keys(seeds: np.random.SeedSequence) -> list[int]:
    keys: list[int] = seeds.generate_state(EPISODES).tolist()
    return keys
