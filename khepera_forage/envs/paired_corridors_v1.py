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

from typing import Any

from pettingzoo.utils.env import AECEnv, ParallelEnv

from khepera_forage.envs.paired_corridors import wrapped, wrapped_parallel
from khepera_forage.envs.training import TrainingEnv as raw_env  # noqa: N813 (PettingZoo's name)

__all__ = ["env", "parallel_env", "raw_env"]


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
