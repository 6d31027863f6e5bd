"""The training phase one level down: teacher and learners in identical corridors command wheels, arm and jaw.

```python
from khepera_forage.envs import paired_corridors_wheels_v1

env = paired_corridors_wheels_v1.parallel_env(num_learners=1)
observations, infos = env.reset(seed=1)
```
"""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.envs.arguments import motor_action
from khepera_forage.envs.training import TrainingEnv, makers
from khepera_forage.envs.training_episode import TrainingEpisode
from khepera_forage.envs.wheels_env import raw_data_of
from khepera_forage.policies.features import raw_data_space
from khepera_forage.policies.policy import HEARD
from khepera_forage.task.behaviours import decode_motors
from khepera_forage.task.states import Behaviour

__all__ = ["env", "parallel_env", "raw_env"]


class WheelsTrainingEnv(TrainingEnv):
    """`TrainingEnv` one level down: raw data in, motors out, so that a learner can learn the behaviours too (4.8).

    ## Action space
    `Box(-1, 1, (4,), float32)` for every agent, as in `CorridorWheels-v1`: left wheel, right wheel, arm, jaw.

    ## Observation space
    `Box((24,), float64)` for every agent: the 22 numbers of `CorridorWheels-v1` in the order of its table, then heard
    (a behaviour; 10 is silence) and separated 0/1, as in `PairedCorridors-v1`. The teacher shouts the behaviour that
    its state demands if its motors, as applied, are those that this behaviour commands; otherwise it is silent.

    ## Rewards, starting state, episode end, info, arguments
    Those of `PairedCorridors-v1`. Following (4.5.2) changes the wheels that a learner commands, by the behaviour that
    it hears. A step is correct when the motors are those of the teacher's behaviour on the same raw data.

    ## Version history
    - v1: first version.
    """

    metadata = TrainingEnv.metadata | {"name": "paired_corridors_wheels_v1"}

    def _observation_space(self) -> spaces.Space[Any]:
        parts = [*raw_data_space().values(), spaces.Discrete(len(Behaviour)), spaces.Discrete(2)]
        boxes = [
            (part.low, part.high) if isinstance(part, spaces.Box) else (0, part.n - 1)  # type: ignore[attr-defined]
            for part in parts
        ]
        low, high = (np.hstack(ends).astype(np.float64) for ends in zip(*boxes, strict=True))
        return spaces.Box(low, high, dtype=np.float64)

    def _action_space(self) -> spaces.Space[Any]:
        return spaces.Box(-1.0, 1.0, (4,), np.float32)

    def observe(self, agent: str) -> NDArray[np.float64]:
        """The raw data of an agent, what it hears, and whether it is separated; a fresh array."""
        attempt, i = self._begun, self.possible_agents.index(agent)
        raw = raw_data_of(attempt.foragers[i].raw)
        return np.hstack([*raw.values(), attempt.observe(i)[HEARD:]]).astype(np.float64)

    def checked_action(self, action: Any, agent: str) -> NDArray[np.float64]:
        """An action, once it is known to be four numbers in -1..1.

        Raises:
            ValueError: It is not.
        """
        return motor_action(action, agent)

    def _take(self, attempt: TrainingEpisode, i: int, action: NDArray[np.float64]) -> None:
        attempt.command(i, decode_motors(*action.tolist()))


raw_env = WheelsTrainingEnv
env, parallel_env = makers(raw_env)
