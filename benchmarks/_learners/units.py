"""One piece of work: a learner and a seed. It learns, and after each amount of learning it is tested."""

from collections.abc import Callable, Mapping
from dataclasses import fields
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from _learners.lessons import REFERENCES, Compared, Learned, lessons
from _learners.rows import ARENAS, Batch, Size
from khepera_forage.policies.learners import LEARNERS, FromQueries, FromSteps, FromVectors
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.rollouts.wheels_recall import WheelsRecall, recall_wheels, recall_wheels_env

_SHOWN = ("title", "algorithm", "settings")
"""Fields of a learner that `told` says in another way, or that stand beside it."""


class Unit(NamedTuple):
    """One piece of work, to be done anywhere and in any order.

    Attributes:
        seed: Of the whole run.
        replication: From 0.
        name: Of the learner.
        learner: It.
        size: Of the whole run.
    """

    seed: int
    replication: int
    name: str
    learner: Compared
    size: Size

    @property
    def key(self) -> tuple[str, int]:
        """Learner and replication, as in its rows."""
        return self.name, self.replication

    def run(self) -> list[Batch]:
        """Learn and be tested; the rows by amount, then arena.

        On one thread for linear algebra, whatever the machine: sums depend on how many there are.
        """
        learning, *testing = np.random.SeedSequence(self.seed, spawn_key=(self.replication,)).spawn(3)
        # The same places for every learner and after every amount.
        places = dict(
            zip(ARENAS, (seeds.generate_state(self.size.recalls).tolist() for seeds in testing), strict=True)
        )
        amounts = self.size.amounts(self.learner.needs)
        with threadpool_limits(1):
            return [
                self._batch(amount, arena, learned, places[arena])
                for amount, learned in zip(amounts, lessons(self.learner, amounts, learning), strict=True)
                for arena in ARENAS
            ]

    def _batch(self, amount: int, arena: str, learned: Learned, seeds: list[int]) -> Batch:
        forage = forager(self.learner, arena)
        rows = [forage(learned.policies[arena], seed) for seed in seeds]
        return Batch(
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


def cells(learner: Compared, size: Size) -> set[tuple[int, str]]:
    """Amount and arena of the rows that a unit comes to."""
    return {(amount, arena) for amount in size.amounts(learner.needs) for arena in ARENAS}


def forager(learner: Compared, arena: str) -> Callable[[Any, int], RecallRow | WheelsRecall]:
    """What lets a policy forage once in an arena, given its seed."""
    if isinstance(learner, FromSteps) and learner.wheels:
        wheels = recall_wheels_env(arena)
        return lambda policy, seed: recall_wheels(wheels, policy, seed)
    env = recall_env(arena)
    return lambda policy, seed: recall(env, policy, seed)


def everyone() -> dict[str, Compared]:
    """All learners of the registry, and the references, by name."""
    return {**REFERENCES, **LEARNERS}


def left_out(learner: Compared) -> str:
    """Why a learner cannot take part here; empty if it can."""
    if isinstance(learner, FromSteps) and find_spec("stable_baselines3") is None:
        return "stable-baselines3 is not installed (pip install 'khepera-forage[baselines]')"
    return ""


def told(learner: Compared) -> str:
    """A learner's settings in one line: they stand on the page, and rows of other settings are refused."""
    match learner:
        case FromVectors():
            name = getattr(learner.make, "__name__", type(learner.make).__name__)
            more = "; diagonal of the arena" if learner.diagonal else ""
            surest = "" if learner.sample else "; most probable behaviour"
            return f"{name}({_arguments(learner.settings)}){more}{surest}"
        case FromQueries():
            return f"{told(learner.learner)}; {_arguments(learner.settings)}"
        case FromSteps():
            own = {f.name: getattr(learner, f.name) for f in fields(learner) if f.name not in _SHOWN}
            return f"{learner.algorithm}({_arguments(learner.settings)}); {_arguments(own)}"
    return "learns nothing"


def plan(learners: Mapping[str, Compared], replications: range, size: Size, seed: int) -> list[Unit]:
    """All work, replication by replication, so that a run that is killed has something of every learner."""
    return [Unit(seed, n, name, learner, size) for n in replications for name, learner in learners.items()]


def _arguments(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in settings.items())
