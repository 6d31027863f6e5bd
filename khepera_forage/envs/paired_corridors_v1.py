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

from khepera_forage.envs.pettingzoo_makers import makers
from khepera_forage.envs.training import TrainingEnv as raw_env  # noqa: N813 (PettingZoo's name)

__all__ = ["env", "parallel_env", "raw_env"]

env, parallel_env = makers(raw_env)
