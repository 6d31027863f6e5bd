"""The training phase as in version 0.1 of this package: `paired_corridors_v1` with the decisions of version 0.1."""

from typing import Any

from pettingzoo.utils.env import AECEnv, ParallelEnv

from khepera_forage.envs.paired_corridors import wrapped, wrapped_parallel
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.task.decisions import Decisions

__all__ = ["env", "parallel_env", "raw_env"]


class raw_env(TrainingEnv):  # noqa: N801 (PettingZoo's name)
    """`TrainingEnv` with the decisions of version 0.1, unless others are given."""

    metadata = TrainingEnv.metadata | {"name": "paired_corridors_v0"}
    default_decisions = Decisions.v0_1()


def env(**kwargs: Any) -> AECEnv[str, Any, Any]:
    """The environment with PettingZoo's usual wrappers.

    Args:
        **kwargs: Those of `raw_env`.
    """
    return wrapped(raw_env(**kwargs))


def parallel_env(**kwargs: Any) -> ParallelEnv[str, Any, Any]:
    """The same with simultaneous actions. What a learner hears is then what the teacher did a round ago.

    Args:
        **kwargs: Those of `raw_env`.
    """
    return wrapped_parallel(raw_env(**kwargs))
