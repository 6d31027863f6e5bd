"""Training with a record of what the learner perceives and drives, which experience files do not hold."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from further_experiments.episodes import Setups, train_files
from further_experiments.experiment import Trial
from further_experiments.rows import TrainingEpisode
from khepera_forage.envs.recalls import Forager
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import Observation, Teacher
from khepera_forage.robots.khepera import Motors
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour


class Moment(NamedTuple):
    """One step of the learner.

    Attributes:
        raw: Its raw data when it hears the behaviour.
        heard: The behaviour.
        motors: The motor command that was really applied then.
    """

    raw: RawData
    heard: Behaviour
    motors: Motors


class Observed(NamedTuple):
    """One complete training episode.

    Attributes:
        experience: The learner's experience file.
        row: For the table.
        moments: Every step with a behaviour.
    """

    experience: Experience
    row: TrainingEpisode
    moments: list[Moment]


class ObservingTeacher:
    """The teacher of section 4.4, which also records the steps of its first learner.

    Only the last attempt is kept, as in experience files: an attempt begins with new robots, and the record of the
    attempt before is dropped.

    Args:
        env: The environment that it teaches in.
    """

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
