"""Raw data, motors and rewards, round by round: of a learner in training (4.5), and of the teacher alone."""

from collections.abc import Iterable
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv, raw_data_of
from khepera_forage.experience import Experience
from khepera_forage.policies import Observation, Teacher
from khepera_forage.policies.features import raw_data_space
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, MAX_SPEED, Motors, applicable
from khepera_forage.rollouts.training import train
from khepera_forage.task.states import Behaviour


class RawEpisode(NamedTuple):
    """One episode of n rounds, in the form of `CorridorWheels-v1`.

    Attributes:
        observations: Raw data (4.2.2) before each round and after the last, each of shape (n + 1, ...).
        actions: Motors as applied, shape (n, 4): left, right, arm, jaw, each -1..1.
        rewards: Of each round.
        heard: The behaviour that the robot heard, or executed, in each round; 10 is silence.
        truncated: Whether it was out of time.
    """

    observations: dict[str, NDArray[Any]]
    actions: NDArray[np.float32]
    rewards: NDArray[np.float64]
    heard: NDArray[np.int64]
    truncated: bool = False

    @property
    def rewards_of_vectors(self) -> NDArray[np.float64]:
        """The reward from each experience vector to the next: rounds of silence have none, but count."""
        vector = np.maximum(np.cumsum(self.heard != Behaviour.WAIT) - 1, 0)
        return np.bincount(vector, self.rewards).astype(np.float64)


class _Record:
    """The rounds of an episode, as they come; it begins with what is shown before the first."""

    def __init__(self, shown: Any) -> None:
        self._shown: list[Any] = [shown]
        self.heard: list[int] = []
        self._actions: list[tuple[float, ...]] = []
        self._rewards: list[float] = []

    def add(self, motors: Motors, reward: float, shown: Observation) -> None:
        self._actions.append(encoded_motors(motors))
        self._rewards.append(reward)
        self._shown.append(shown)

    def episode(self) -> RawEpisode:
        observations = {name: np.stack([one[name] for one in self._shown]) for name in raw_data_space()}
        return RawEpisode(
            observations, np.array(self._actions, np.float32), np.array(self._rewards), np.array(self.heard, np.int64)
        )


class _LearnerRecorder:
    """The teacher of section 4.4, which records the rounds of its first learner: `teacher` and `callback` of `train`.

    Only the last attempt is kept, as in experience files.
    """

    record: _Record

    def __init__(self, env: TrainingEnv) -> None:
        self._env = env

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The teacher's behaviour; called before anything else in a round."""
        if self._env.infos[TEACHER]["steps"] == 0:
            self._teacher, self.record = Teacher.of(self._env), _Record(self._shown())
        behaviour = self._teacher.act(observation, rng)
        self.record.heard.append(int(behaviour))
        return behaviour

    def __call__(self) -> None:
        """Record what a round has brought."""
        self.record.add(self._env.foragers[1].applied, self._env.rewards["learner_0"], self._shown())

    def _shown(self) -> dict[str, Any]:
        return raw_data_of(self._env.foragers[1].raw)


def recorded(
    env: TrainingEnv | WheelsEnv, seeds: Iterable[np.random.SeedSequence]
) -> list[tuple[Experience, RawEpisode]]:
    """Complete training episodes, or episodes of the teacher alone where the environment has motors; closes it."""
    with closing(env):
        if isinstance(env, WheelsEnv):
            return [teacher_alone(env, int(seed.generate_state(1)[0])) for seed in seeds]
        recorder = _LearnerRecorder(env)
        return [(train(env, seed, teacher=recorder, callback=recorder)[0], recorder.record.episode()) for seed in seeds]


def teacher_alone(env: WheelsEnv, seed: int) -> tuple[Experience, RawEpisode]:
    """An episode of the teacher that forages alone, from random places.

    Args:
        env: Where it commands motors.
        seed: Of the episode.

    Returns:
        Its state vectors and behaviours, and its raw data and motors.
    """
    vectors: list[tuple[int, ...]] = []
    record, done = _Record(env.reset(seed=seed)[0]), False
    while not done:
        forager = env.forager
        motors = applicable(forager.motors_for(forager.correct_behaviour))
        record.heard.append(int(forager.correct_behaviour))
        vectors.append(forager.vector)
        shown, reward, terminated, truncated, _ = env.step(np.array(encoded_motors(motors)))
        record.add(motors, float(reward), shown)
        done = terminated or truncated
    experience = Experience(vectors, record.heard, env.arena.name, seed, decisions=env.decisions)
    return experience, record.episode()._replace(truncated=not terminated)


def encoded_motors(motors: Motors) -> tuple[float, float, float, float]:
    """Motors as an action of `CorridorWheels-v1`: the inverse of `task.behaviours.decode_motors`."""
    middle, half = (ARM_DOWN + ARM_RAISED) / 2, (ARM_DOWN - ARM_RAISED) / 2
    left, right, arm, jaw = motors
    return left / MAX_SPEED, right / MAX_SPEED, (middle - arm) / half, 1.0 if jaw == JAW_CLOSED else -1.0
