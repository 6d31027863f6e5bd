"""The training phase in an arena of the family: a teacher and its learners in copies of it (4.5).

```python
from khepera_forage.envs import paired_arenas_v1

env = paired_arenas_v1.env(arena="t_maze", num_learners=1)
```
"""

from typing import Any

from khepera_forage.envs.arena_settings import settings_of, training_rounds
from khepera_forage.envs.arguments import FoodOdds
from khepera_forage.envs.paired import makers
from khepera_forage.envs.training import TrainingEnv

__all__ = ["env", "parallel_env", "raw_env"]


class raw_env(TrainingEnv):  # noqa: N801 (PettingZoo's name)
    """`TrainingEnv` in a named arena, with its food types and its number of rounds.

    Args:
        arena: One of `ARENAS`.
        max_cycles: Of an episode; by default a fifth more than the arena's step limit.
        food_types: By default those of the arena.
        kwargs: Further arguments of `TrainingEnv`.
    """

    def __init__(
        self,
        arena: str = "t_maze",
        max_cycles: int | None = None,
        food_types: FoodOdds = None,
        **kwargs: Any,
    ) -> None:
        settings = settings_of(arena)
        super().__init__(
            arena=arena,
            max_cycles=training_rounds(settings["limit"]) if max_cycles is None else max_cycles,
            food_types=settings.get("food_types") if food_types is None else food_types,
            **kwargs,
        )
        self.metadata = self.metadata | {"name": f"paired_{arena}_v1"}


env, parallel_env = makers(raw_env)
