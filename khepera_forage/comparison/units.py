"""Units of work: one learner in one replication learns, and is tested after each amount of learning."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from khepera_forage.comparison.learning import REFERENCES, Compared, Learned, learn
from khepera_forage.comparison.rows import ARENAS, RecallBatch, Size
from khepera_forage.policies.learner_registry import installed_learners
from khepera_forage.policies.learners import LEARNERS, FromQueries, FromSteps, FromVectors
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.rollouts.wheels_recall import WheelsRecall, recall_wheels, recall_wheels_env

_SHOWN = ("title", "algorithm", "settings")
"""Fields of a reinforcement learner that `settings_of` does not list."""


class LearnerUnit(NamedTuple):
    """One learner in one replication.

    Attributes:
        seed: Of the whole run.
        replication: From 0.
        name: Of the learner.
        learner: The entry of the registry, or a reference.
        size: Of the whole run.
    """

    seed: int
    replication: int
    name: str
    learner: Compared
    size: Size

    @property
    def key(self) -> str:
        """Learner and replication."""
        return f"{self.name} {self.replication}"

    def run(self) -> list[RecallBatch]:
        """Learn and be tested; the rows by amount, then arena.

        Linear algebra runs on one thread, because sums depend on the number of threads.
        """
        learning, *testing = np.random.SeedSequence(self.seed, spawn_key=(self.replication,)).spawn(3)
        # The same places for every learner and after every amount.
        places = {
            arena: seeds.generate_state(self.size.recalls).tolist()
            for arena, seeds in zip(ARENAS, testing, strict=True)
        }
        amounts = self.size.amounts(self.learner.needs)
        with threadpool_limits(1):
            return [
                self._batch(amount, arena, learned, places[arena])
                for amount, learned in zip(amounts, learn(self.learner, amounts, learning), strict=True)
                for arena in ARENAS
            ]

    def _batch(self, amount: int, arena: str, learned: Learned, seeds: list[int]) -> RecallBatch:
        forage = forager(self.learner, arena)
        rows = [forage(learned.policies[arena], seed) for seed in seeds]
        return RecallBatch(
            learner=self.name,
            replication=self.replication,
            amount=amount,
            arena=arena,
            steps=learned.steps,
            vectors=learned.vectors,
            recalls=len(rows),
            score=float(np.mean([row.score for row in rows])),
            delivered=sum(row.delivered for row in rows),
            foods=sum(row.foods for row in rows),
            recall_steps=sum(row.steps for row in rows),
            seconds=learned.seconds,
        )


def forager(learner: Compared, arena: str) -> Callable[[Any, int], RecallRow | WheelsRecall]:
    """A function that lets a policy forage once in an arena, given its seed."""
    if isinstance(learner, FromSteps) and learner.wheels:
        wheels = recall_wheels_env(arena)
        return lambda policy, seed: recall_wheels(wheels, policy, seed)
    env = recall_env(arena)
    return lambda policy, seed: recall(env, policy, seed)


def all_learners() -> dict[str, Compared]:
    """The references, all learners of the registry, and those of installed packages, by name."""
    return {**REFERENCES, **LEARNERS, **installed_learners().learners}


def missing_extra(learner: Compared) -> str:
    """Why a learner cannot run here; empty if it can."""
    if isinstance(learner, FromSteps) and find_spec("stable_baselines3") is None:
        return "stable-baselines3 is not installed (pip install 'khepera-forage[baselines]')"
    return ""


def settings_of(learner: Compared) -> str:
    """A learner's settings in one line. They stand on the page, and rows of other settings are refused."""
    match learner:
        case FromVectors():
            name = getattr(learner.make, "__name__", type(learner.make).__name__)
            diagonal = "; diagonal of the arena" if learner.diagonal else ""
            choice = "" if learner.sample else "; most probable behaviour"
            return f"{name}({_arguments(learner.settings)}){diagonal}{choice}"
        case FromQueries():
            return f"{settings_of(learner.learner)}; {_arguments(learner.settings)}"
        case FromSteps():
            own = {f.name: getattr(learner, f.name) for f in fields(learner) if f.name not in _SHOWN}
            return f"{learner.algorithm}({_arguments(learner.settings)}); {_arguments(own)}"
    return "learns nothing"


def plan(learners: Mapping[str, Compared], replications: range, size: Size, seed: int) -> list[LearnerUnit]:
    """All work, replication by replication, so that a run that is killed has rows of every learner."""
    return [
        LearnerUnit(seed, number, name, learner, size)
        for number in replications
        for name, learner in learners.items()
    ]


def planned_or_finished(
    units: Sequence[LearnerUnit], finished: Sequence[str], known: Mapping[str, Compared]
) -> list[LearnerUnit]:
    """Units of this run, and before them those of earlier runs whose rows stand in the same folder.

    Args:
        units: Of this run.
        finished: Keys of the folder's finished units.
        known: All learners that may have rows.

    Raises:
        ValueError: The folder has rows of a learner that is not known.
    """
    keys = {unit.key for unit in units}
    earlier = []
    for key in finished:
        name, replication = key.rsplit(" ", 1)
        if name not in known:
            raise ValueError(f"learner is {name!r}; allowed: {', '.join(known)}")
        if key not in keys:
            earlier.append(units[0]._replace(replication=int(replication), name=name, learner=known[name]))
    return [*earlier, *units]


def _arguments(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in settings.items())
