"""The training phase in any arena: a teacher and its learners in copies of it (4.5).

```python
from khepera_forage.envs import paired_arenas_v1

env = paired_arenas_v1.env(arena="t_maze", num_learners=1)
```
"""

from typing import Any

from khepera_forage.envs.arena_settings import settings_of, training_rounds
from khepera_forage.envs.arguments import FoodOdds
from khepera_forage.envs.pettingzoo_makers import makers
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.sim.arena import Arena

__all__ = ["env", "parallel_env", "raw_env"]


class raw_env(TrainingEnv):  # noqa: N801 (PettingZoo's name)
    """`TrainingEnv` in any arena, with its food types and a number of rounds that its paths need.

    Args:
        arena: One of `ARENAS`, or an `Arena`.
        max_cycles: Of an episode; by default a fifth more than the arena's step limit.
        food_types: By default those of the arena.
        kwargs: Further arguments of `TrainingEnv`.
    """

    def __init__(
        self,
        arena: Arena | str = "t_maze",
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
        self.metadata = self.metadata | {"name": f"paired_{self.arenas[0].name}_v1"}


env, parallel_env = makers(raw_env)
