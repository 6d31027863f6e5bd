"""A learner without behaviours: in training it drives the teacher's motors, in recall what it has learned of them."""

from collections.abc import Callable
from typing import Any

from khepera_forage.envs.arguments import behaviour_number
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.forager import Forager
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.robots.khepera import Motors
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import BEHAVIOURS


class CopyingEnv(TrainingEnv):
    """The paired corridors, where the teacher's motor commands are heard beside its word.

    A learner drives just those, bent by following (4.5.2) as in the thesis; what it acts is its word alone. It has no
    behaviour of its own to execute.
    """

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt; see `TrainingEnv.reset`."""
        super().reset(seed, options)
        teacher, *learners = self.foragers
        for learner in learners:
            learner.motors_for = teacher.motors_for  # type: ignore[method-assign]


class OwnBehavioursEnv(BehavioursEnv):
    """Recall in which behaviours command what the learner has learned that they command.

    The score stays that of equation 5.1, which is of behaviours: a step is correct if the teacher would have chosen
    the same one.

    Args:
        command: From a behaviour and raw data to motors; may be changed between episodes.
        **kwargs: Of `BehavioursEnv`.
    """

    def __init__(self, command: Callable[[int, RawData], Motors], **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.command = command

    def _motors(self, action: int, forager: Forager) -> Motors:
        behaviour = behaviour_number(action, 10)
        self._executed = BEHAVIOURS[behaviour]
        return self.command(behaviour, forager.raw)
