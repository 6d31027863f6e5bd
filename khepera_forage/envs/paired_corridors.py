"""PettingZoo's usual wrappers around the paired corridors, for all their versions."""

from typing import Any

from pettingzoo.utils import OrderEnforcingWrapper
from pettingzoo.utils.conversions import aec_to_parallel
from pettingzoo.utils.env import AECEnv, ParallelEnv
from pettingzoo.utils.wrappers import AssertOutOfBoundsWrapper

from khepera_forage.envs.training import TrainingEnv


def wrapped(raw: TrainingEnv) -> AECEnv[str, Any, Any]:
    """An environment that checks actions and the order of calls."""
    return OrderEnforcingWrapper(AssertOutOfBoundsWrapper(raw))


def wrapped_parallel(raw: TrainingEnv) -> ParallelEnv[str, Any, Any]:
    """The same with simultaneous actions. What a learner hears is then what the teacher did a round ago."""
    return aec_to_parallel(wrapped(raw))
