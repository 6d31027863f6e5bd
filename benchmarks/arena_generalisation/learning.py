"""The learners from vectors and from queries, each fitted once for all arenas."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arena_generalisation.contestants import Contestant
from arena_generalisation.recall_arenas import RecallArena, named_arenas
from arena_generalisation.size import Size
from arena_generalisation.trainings import CORRIDOR, VARIED, Training, training_arenas
from khepera_forage.comparison.learning import ARENA_MAPS
from khepera_forage.comparison.units import all_learners
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies.learners import FromQueries, FromVectors
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.task.decisions import DEFAULT_DECISIONS

CORRIDOR_DIAGONAL = ARENA_MAPS[CORRIDOR].diagonal


def imitating_learners() -> dict[str, FromVectors]:
    """All learners from experience vectors, those of installed packages too, by name."""
    return {name: learner for name, learner in all_learners().items() if isinstance(learner, FromVectors)}


def querying_learners() -> dict[str, FromQueries]:
    """All learners that query the teacher, those of installed packages too, by name."""
    return {name: learner for name, learner in all_learners().items() if isinstance(learner, FromQueries)}


def fitted(learner: FromVectors, training: Training, seed: int) -> Any:
    """A learner's classifier, fitted in the corridor's diagonal if it takes one.

    Args:
        learner: From `imitating_learners`.
        training: Its experience.
        seed: Of its random choices.
    """
    more = {"groups": training.episodes} if learner.grouped else {}
    classifier = learner.classifier(CORRIDOR_DIAGONAL, seed)
    return classifier.fit(training.vectors, training.behaviours, **more)


def queried(name: str, learner: FromQueries, replication: int, seed: int, size: Size) -> list[Contestant]:
    """A learner that queries the teacher, in the corridor alone or as often in varied arenas.

    In varied arenas, each difficulty has one training arena and an equal share of the queries.

    Args:
        name: Of the learner.
        learner: From `querying_learners`.
        replication: Its number.
        seed: Of places and random choices.
        size: Of the run.
    """
    student = learner.learner
    found = []
    for training, arenas in (
        (CORRIDOR, named_arenas([CORRIDOR])),
        (VARIED, training_arenas(replication, size.difficulties)),
    ):
        vectors, behaviours = _query(learner, arenas, size.queries // len(arenas), seed)
        asked = Training(vectors, behaviours, np.zeros(len(vectors), np.int64))
        classifier = fitted(student, asked, seed)
        found.append(Contestant.imitating(name, training, student, classifier, len(vectors)))
    return found


def _query(
    learner: FromQueries, arenas: Sequence[RecallArena], queries: int, seed: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The state vectors and answers of queries in one arena after the other."""
    student, asked = learner.learner, None
    for number, arena in enumerate(arenas):
        env = BehavioursEnv(arena=arena.arena, decisions=DEFAULT_DECISIONS, **arena.arguments)
        result = dagger(
            lambda: student.classifier(CORRIDOR_DIAGONAL, seed),
            env,
            queries,
            seed + number,
            sample=student.sample,
            start=asked,
            **learner.settings,
        )
        env.close()
        asked = result.vectors, result.behaviours
    assert asked is not None
    return asked
