"""What a learner perceives and is driven with in training, beside the word that it hears: more than files keep."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from _further_work.phases import Setups, learn
from _further_work.rows import Lesson, Unit
from khepera_forage.envs.forager import Forager
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import Observation, Teacher
from khepera_forage.robots.khepera import Motors
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour


class Moment(NamedTuple):
    """One step of the learner.

    Attributes:
        raw: Its own raw data as it hears the word.
        heard: The behaviour.
        motors: What its motors then were really told.
    """

    raw: RawData
    heard: Behaviour
    motors: Motors


class Taught(NamedTuple):
    """One complete training episode.

    Attributes:
        experience: What the learner's file holds.
        lesson: For the rows.
        moments: What the witness noted.
    """

    experience: Experience
    lesson: Lesson
    moments: list[Moment]


class Witness:
    """The teacher of section 4.4, with somebody beside it who notes what goes on in its first learner.

    Only complete episodes are kept, as with experience files: an attempt begins with new robots, and what was noted
    of the one before is forgotten.

    Args:
        env: Where it teaches.
    """

    def __init__(self, env: TrainingEnv) -> None:
        self._env = env
        self._teacher = Teacher(env.home_radius)
        self._learner: Forager | None = None
        self._noted: list[tuple[RawData, Behaviour]] = []
        self._motors: list[Motors] = []

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """What the teacher does; called before anything else in a round."""
        learner = self._env.foragers[1]
        if learner is self._learner:
            self._motors.append(learner.applied)
        else:
            self._learner, self._noted, self._motors = learner, [], []
        heard = self._teacher.act(observation, rng)
        self._noted.append((learner.raw, heard))
        return heard

    def moments(self) -> list[Moment]:
        """The steps of the last attempt in which the learner heard a behaviour."""
        assert self._learner is not None, "nothing was taught"
        motors = [*self._motors, self._learner.applied]
        return [
            Moment(raw, heard, applied)
            for (raw, heard), applied in zip(self._noted, motors, strict=True)
            if heard != Behaviour.WAIT
        ]


def witnessed(
    env: TrainingEnv, unit: Unit, seeds: Sequence[np.random.SeedSequence], setups: Setups | None = None
) -> list[Taught]:
    """Lessons with a witness, one a seed; see `learn`."""
    witness = Witness(env)
    lessons = learn(env, unit, seeds, teacher=witness, setups=setups)
    return [Taught(experience, lesson, witness.moments()) for experience, lesson in lessons]
