"""The learners from vectors and from queries, each fitted once for all arenas."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arena_generalisation.recall_arenas import RecallArena, named_arenas
from arena_generalisation.trainings import CORRIDOR, VARIED, Training, training_arenas
from khepera_forage.comparison.learning import ARENA_MAPS
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies.learner_registry import installed_learners
from khepera_forage.policies.learners import LEARNERS, FromQueries, FromVectors
from khepera_forage.rollouts.dagger import dagger
from khepera_forage.task.decisions import Decisions

QUERYING = "dagger_tree"
"""The learner that queries the teacher."""
QUERIES = 1000
CORRIDOR_DIAGONAL = ARENA_MAPS[CORRIDOR].diagonal


def imitating_learners() -> dict[str, FromVectors]:
    """All learners from experience vectors, those of installed packages too, by name."""
    known = {**LEARNERS, **installed_learners().learners}
    return {name: learner for name, learner in known.items() if isinstance(learner, FromVectors)}


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


def queried(
    replication: int, seed: int, difficulties: Sequence[str], decisions: Decisions
) -> Mapping[str, tuple[FromVectors, Any, int]]:
    """The learner that queries the teacher: by training, its settings, its classifier, and the number of queries.

    `CORRIDOR`: all queries in the corridor. `VARIED`: as many in a training arena of each difficulty.

    Args:
        replication: Its number.
        seed: Of places and random choices.
        difficulties: Of the training arenas.
        decisions: Of the environments.
    """
    learner = LEARNERS[QUERYING]
    assert isinstance(learner, FromQueries)
    corridor = named_arenas([CORRIDOR])
    found = {}
    for name, arenas, queries in (
        (CORRIDOR, corridor, QUERIES),
        (VARIED, training_arenas(replication, difficulties), QUERIES // len(difficulties)),
    ):
        vectors, behaviours = _query(learner, arenas, queries, seed, decisions)
        training = Training(vectors, behaviours, np.zeros(len(vectors), np.int64))
        found[name] = (learner.learner, fitted(learner.learner, training, seed), len(vectors))
    return found


def _query(
    learner: FromQueries, arenas: Sequence[RecallArena], queries: int, seed: int, decisions: Decisions
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The state vectors and answers of queries in one arena after the other."""
    student, asked = learner.learner, None
    for number, arena in enumerate(arenas):
        env = BehavioursEnv(arena=arena.arena, decisions=decisions, **arena.arguments)
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
