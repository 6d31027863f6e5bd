"""The training phase as a PettingZoo environment: a teacher and its learners in identical corridors (4.5).

```python
from khepera_forage.envs import paired_corridors_v1

env = paired_corridors_v1.env(num_learners=1, max_cycles=600)
env.reset(seed=1)
for agent in env.agent_iter():
    observation, reward, terminated, truncated, info = env.last()
    env.step(None if terminated or truncated else policies[agent].act(observation))
```
"""

from typing import TYPE_CHECKING, Any

from khepera_forage.envs.training import TrainingEnv as raw_env  # noqa: N813 (PettingZoo's name)
from khepera_forage.envs.training import makers

if TYPE_CHECKING:
    from khepera_forage.envs.compiled.pairs import PairedBatch

__all__ = ["env", "parallel_env", "raw_env", "vector_env"]

env, parallel_env = makers(raw_env)


def vector_env(num_envs: int, **kwargs: Any) -> "PairedBatch":
    """`parallel_env` for many pairs at a time, in compiled worlds; needs numba.

    Args:
        num_envs: How many pairs.
        kwargs: Further arguments of `PairedBatch`.
    """
    from khepera_forage.envs.compiled.pairs import PairedBatch

    return PairedBatch(num_envs, **kwargs)
