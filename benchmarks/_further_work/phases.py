"""Training and recall, with the rows that they leave: what all experiments do, each in its own way."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from _further_work.rows import Lesson, Recalled, Unit
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import NearestNeighbourImitator, Policy
from khepera_forage.rollouts.recall import recall
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.task.states import FoodType, behaviour_for, classify
from khepera_forage.thesis.replication import TRAINING_DISTANCE

ARENAS = ("corridor", "rectangle")

Setups = Iterable[Mapping[str, Any] | None]
Files = Sequence[Experience]


def training_seeds(unit: Unit) -> np.random.SeedSequence:
    """Seeds of a replication's lessons; the same under every condition."""
    return np.random.SeedSequence(unit.seed, spawn_key=(unit.replication, 0))


def recall_seeds(unit: Unit, arena: str) -> list[int]:
    """Seeds of a replication's recalls in an arena; the same under every condition and for every amount."""
    seeds = np.random.SeedSequence(unit.seed, spawn_key=(unit.replication, 1, ARENAS.index(arena)))
    return [int(seed) for seed in seeds.generate_state(unit.size.recalls)]


def learn(
    env: TrainingEnv,
    unit: Unit,
    seeds: Sequence[np.random.SeedSequence],
    amount: int = 1,
    teacher: Policy | None = None,
    setups: Setups | None = None,
) -> Iterator[tuple[Experience, Lesson]]:
    """Lessons, one a seed.

    Args:
        env: The paired corridors.
        unit: For the rows.
        seeds: One a lesson.
        amount: For the rows.
        teacher: Who shows; by default the teacher of section 4.4.
        setups: Marks of each lesson; by default those of figure 5.1.

    Raises:
        HopelessTraining: As many attempts at one lesson were incomplete as the size allows.
    """
    marks = iter(setups) if setups is not None else None
    for file, seed in enumerate(seeds, 1):
        options = next(marks) if marks is not None else None
        experience, attempts = train(env, seed, teacher=teacher, options=options, attempts=unit.size.attempts)
        complete = attempts[-1]
        yield (
            experience,
            Lesson(
                replication=unit.replication,
                condition=unit.condition,
                amount=amount,
                file=file,
                attempts=len(attempts),
                rounds=complete.rounds,
                all_rounds=sum(row.rounds for row in attempts),
                vectors=len(experience),
                true=_true(experience, env.home_radius),
                separations=complete.separations,
            ),
        )


def imitator(files: Files, diagonal: int, threshold: float = 0.0) -> NearestNeighbourImitator:
    """The thesis' learner, taught by these files."""
    return NearestNeighbourImitator(diagonal=diagonal, threshold=threshold).fit(*arrays(list(files)))


def recall_all(
    env: BehavioursEnv,
    policy: Policy,
    unit: Unit,
    amount: int,
    files: Files = (),
    condition: str = "",
    anew: bool = False,
) -> Iterator[Recalled]:
    """A replication's recalls in one arena.

    Args:
        env: From `recall_env`.
        policy: Who forages.
        unit: For seeds and rows.
        amount: For the rows.
        files: What the policy has learned from, for the rows.
        condition: For the rows; by default the unit's.
        anew: Whether the policy remembers what it does, so that every recall needs a copy that has done nothing yet.
    """
    vectors: NDArray[np.int64] = arrays(list(files))[0] if files else np.zeros((0, 5), np.int64)
    distinct = len(np.unique(vectors, axis=0))
    for number, seed in enumerate(recall_seeds(unit, env.arena.name)):
        row = recall(env, copy(policy) if anew else policy, seed)
        poisonous = sum(kind == FoodType.POISONOUS for kind in env.forager.register.known)
        yield Recalled(
            replication=unit.replication,
            condition=condition or unit.condition,
            arena=row.arena,
            amount=amount,
            number=number,
            seed=seed,
            score=row.score,
            correct=row.correct,
            steps=row.steps,
            foods=row.foods,
            delivered=row.delivered,
            avoided=poisonous - row.poison_home,
            poison_home=row.poison_home,
            beyond=row.food_home_distances[0] - TRAINING_DISTANCE,
            vectors=len(vectors),
            distinct=distinct,
            rounds_by_state=row.rounds_by_state,
            wrong_by_state=row.wrong_by_state,
        )


def _true(experience: Experience, home_radius: int) -> int:
    return sum(behaviour_for(classify(vector, home_radius)) == heard for vector, heard in experience)
