"""The training phase as in version 0.1 of this package: `paired_corridors_v1` with the decisions of version 0.1."""

from khepera_forage.envs.training import TrainingEnv, makers
from khepera_forage.task.decisions import Decisions

__all__ = ["env", "parallel_env", "raw_env"]


class raw_env(TrainingEnv):  # noqa: N801 (PettingZoo's name)
    """`TrainingEnv` with the decisions of version 0.1, unless others are given."""

    metadata = TrainingEnv.metadata | {"name": "paired_corridors_v0"}
    default_decisions = Decisions.v0_1()


env, parallel_env = makers(raw_env)
