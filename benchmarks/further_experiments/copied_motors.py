"""Environments for a learner without behaviours: it copies motor commands, and recalls with learned behaviours."""

from collections.abc import Callable
from typing import Any

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.robots.khepera import Motors
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.perception import RawData


class CopiedMotorsEnv(TrainingEnv):
    """The paired corridors, where learners drive the teacher's motor commands, bent by following (4.5.2).

    A learner's action is the behaviour that it heard and is only recorded; it executes no behaviour of its own.
    """

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt; see `TrainingEnv.reset`."""
        super().reset(seed, options)
        teacher, *learners = self.foragers
        for learner in learners:
            learner.motors_for = teacher.motors_for  # type: ignore[method-assign]


def hand_coded(behaviour: int, raw: RawData) -> Motors:
    """The motor commands of the hand-coded behaviours."""
    return command(behaviour, raw, Decisions().values())


class LearnedBehavioursEnv(BehavioursEnv):
    """Recall with learned behaviours in place of the hand-coded ones.

    The score is that of equation 5.1: a step is correct if the teacher would have chosen the same behaviour.

    Args:
        command: From a behaviour and raw data to motors; may be replaced between episodes.
        **kwargs: Of `BehavioursEnv`.
    """

    def __init__(self, command: Callable[[int, RawData], Motors] = hand_coded, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.command = command

    def reset(self, **kwargs: Any) -> Any:
        """Start an episode, in which the robot has the learned behaviours."""
        begun = super().reset(**kwargs)
        setattr(self.forager, "motors_for", self._command)  # noqa: B010 (a method of this robot alone)
        return begun

    def _command(self, behaviour: int) -> Motors:
        return self.command(behaviour, self.forager.raw)
