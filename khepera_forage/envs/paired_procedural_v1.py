"""The training phase in procedural arenas: each episode in one of them, a teacher and its learners in copies (4.5).

```python
from khepera_forage.envs import paired_procedural_v1

env = paired_procedural_v1.env(difficulty="hard", num_levels=1000)
```
"""

from typing import Any

from khepera_forage.envs.arena_settings import procedural_settings, training_rounds
from khepera_forage.envs.training import TrainingEnv, makers
from khepera_forage.sim.arenas.difficulty import Difficulty

__all__ = ["env", "parallel_env", "raw_env"]


class raw_env(TrainingEnv):  # noqa: N801 (PettingZoo's name)
    """`TrainingEnv` in procedural arenas, with the settings of their difficulty.

    The first four arguments are those of `ProceduralArenas`, the others those of `TrainingEnv`: `max_cycles`,
    `food_types` and `noise` override those of the difficulty.

    Raises:
        ValueError: As `ProceduralArenas`; or an arena is given.
    """

    metadata = TrainingEnv.metadata | {"name": "paired_procedural_v1"}

    def __init__(
        self,
        difficulty: str | Difficulty = "medium",
        split: str = "train",
        num_levels: int = 200,
        start_level: int = 0,
        **kwargs: Any,
    ) -> None:
        if "arena" in kwargs:
            raise ValueError(f"arena is {kwargs['arena']!r}; allowed here: none, because difficulty determines it")
        settings = procedural_settings(difficulty, split, num_levels, start_level)
        rounds = training_rounds(settings.pop("limit"))
        del settings["foods"]  # one for each mark of the arena
        super().__init__(**{**settings, "max_cycles": rounds, **kwargs})


env, parallel_env = makers(raw_env)
