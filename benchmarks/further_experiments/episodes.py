"""Training and recall with the rows that they leave, and training with a record of what the learner perceives."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from further_experiments.experiment import RecallEpisode, TrainingEpisode, Trial
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recalls import Forager
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import NearestNeighbourImitator, Observation, Policy, Teacher
from khepera_forage.robots.khepera import Motors
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour, FoodType, behaviour_for, classify
from khepera_forage.thesis.design import training_distance

ARENAS = ("corridor", "rectangle")

Setups = Iterable[Mapping[str, Any] | None]
Files = Sequence[Experience]


def training_seeds(trial: Trial) -> np.random.SeedSequence:
    """Seeds of a replication's training episodes; the same under every condition."""
    return np.random.SeedSequence(trial.seed, spawn_key=(trial.replication, 0))


def recall_seeds(trial: Trial, arena: str) -> list[int]:
    """Seeds of a replication's recalls in an arena; the same under every condition and for every amount."""
    seeds = np.random.SeedSequence(trial.seed, spawn_key=(trial.replication, 1, ARENAS.index(arena)))
    return [int(seed) for seed in seeds.generate_state(trial.size.recalls)]


def train_files(
    env: TrainingEnv,
    trial: Trial,
    seeds: Sequence[np.random.SeedSequence],
    amount: int = 1,
    teacher: Policy | None = None,
    setups: Setups | None = None,
) -> Iterator[tuple[Experience, TrainingEpisode]]:
    """Training episodes, one a seed; by default of the teacher of section 4.4, in the set-up of figure 5.1.

    Raises:
        IncompleteTrainingError: One episode failed in as many attempts as the size allows.
    """
    marks = iter(setups) if setups is not None else None
    for file, seed in enumerate(seeds, 1):
        options = next(marks) if marks is not None else None
        experience, attempts = train(
            env, seed, teacher=teacher, options=options, attempts=trial.size.attempts
        )
        complete = attempts[-1]
        row = TrainingEpisode(
            replication=trial.replication,
            condition=trial.condition,
            amount=amount,
            file=file,
            attempts=len(attempts),
            rounds=complete.rounds,
            all_rounds=sum(row.rounds for row in attempts),
            vectors=len(experience),
            true=_true(experience, env),
            separations=complete.separations,
        )
        yield experience, row


def thesis_files(
    trial: Trial, env: TrainingEnv | None = None
) -> tuple[list[Experience], list[TrainingEpisode]]:
    """As many training episodes as the size says, with the set-up of figure 5.1; the environment is closed."""
    env = env or TrainingEnv(max_cycles=trial.size.rounds)
    trained = list(train_files(env, trial, training_seeds(trial).spawn(trial.size.files)))
    env.close()
    return [experience for experience, _ in trained], [row for _, row in trained]


def imitator(files: Files, diagonal: int, threshold: float = 0.0) -> NearestNeighbourImitator:
    """The thesis's learner with the experience of these files."""
    # A threshold needs exact arithmetic.
    arithmetic = "exact" if threshold else DEFAULT_DECISIONS.distance_arithmetic
    return NearestNeighbourImitator(diagonal, threshold, arithmetic).fit(*arrays(list(files)))


def recall_all(
    env: BehavioursEnv,
    policy: Policy,
    trial: Trial,
    amount: int,
    files: Files = (),
    condition: str = "",
    fresh: bool = False,
) -> list[RecallEpisode]:
    """A replication's recalls in one arena.

    Args:
        env: From `recall_env`.
        policy: Forages.
        trial: For seeds and rows.
        amount: For the rows.
        files: The policy's experience, for the rows.
        condition: For the rows; by default the trial's.
        fresh: Copy the policy for every recall, because it remembers what it does.
    """
    vectors: NDArray[np.int64] = arrays(list(files))[0] if files else np.zeros((0, 5), np.int64)
    distinct = len(np.unique(vectors, axis=0))
    rows = []
    for number, seed in enumerate(recall_seeds(trial, env.arena.name)):
        row = recall(env, copy(policy) if fresh else policy, seed)
        poisonous = sum(food.known == FoodType.POISONOUS for food in env.forager.tracker.foods)
        rows.append(
            RecallEpisode(
                replication=trial.replication,
                condition=condition or trial.condition,
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
                beyond=row.food_home_distances[0] - training_distance(env.decisions),
                vectors=len(vectors),
                distinct=distinct,
                rounds_by_state=row.rounds_by_state,
                wrong_by_state=row.wrong_by_state,
            )
        )
    return rows


def recall_imitators(env: BehavioursEnv, trial: Trial, files: Files) -> list[RecallEpisode]:
    """Recalls of the thesis's learner after every number of training episodes for which there are files."""
    return [
        row
        for amount in trial.size.amounts
        if amount <= len(files)
        for row in recall_all(env, imitator(files[:amount], env.diagonal), trial, amount, files[:amount])
    ]


def recall_everywhere(trial: Trial, files: Files) -> list[RecallEpisode]:
    """The same in both arenas."""
    rows = []
    for arena in ARENAS:
        env = recall_env(arena, limit=trial.size.steps)
        rows += recall_imitators(env, trial, files)
        env.close()
    return rows


def _true(experience: Experience, env: TrainingEnv) -> int:
    """Vectors whose behaviour the teacher of section 4.4 would have chosen."""
    radius, decisions = env.home_radius, env.decisions.values()
    return sum(behaviour_for(classify(vector, radius, decisions)) == heard for vector, heard in experience)


class Moment(NamedTuple):
    """One step of the learner: its raw data when it hears a behaviour, and the motors that were applied then."""

    raw: RawData
    heard: Behaviour
    motors: Motors


class Observed(NamedTuple):
    """One complete training episode, with every step in which the learner heard a behaviour."""

    experience: Experience
    row: TrainingEpisode
    moments: list[Moment]


class ObservingTeacher:
    """The teacher of section 4.4, which also records the steps of its first learner in the last attempt."""

    def __init__(self, env: TrainingEnv) -> None:
        self._env = env
        self._teacher = Teacher.of(env)
        self._learner: Forager | None = None
        self._heard: list[tuple[RawData, Behaviour]] = []
        self._motors: list[Motors] = []

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The teacher's behaviour; called before anything else in a round."""
        learner = self._env.foragers[1]
        if learner is self._learner:
            self._motors.append(learner.applied)
        else:
            self._learner, self._heard, self._motors = learner, [], []
        heard = self._teacher.act(observation, rng)
        self._heard.append((learner.raw, heard))
        return heard

    def moments(self) -> list[Moment]:
        """The steps of the last attempt in which the learner heard a behaviour."""
        assert self._learner is not None, "there was no training"
        motors = [*self._motors, self._learner.applied]
        return [
            Moment(raw, heard, applied)
            for (raw, heard), applied in zip(self._heard, motors, strict=True)
            if heard != Behaviour.WAIT
        ]


def observe(
    env: TrainingEnv, trial: Trial, seeds: Sequence[np.random.SeedSequence], setups: Setups | None = None
) -> list[Observed]:
    """Training episodes with their steps, one a seed; see `train_files`."""
    teacher = ObservingTeacher(env)
    episodes = train_files(env, trial, seeds, teacher=teacher, setups=setups)
    return [Observed(experience, row, teacher.moments()) for experience, row in episodes]
