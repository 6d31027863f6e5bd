"""The training phase in any arena: a teacher and its learners in copies of it (4.5).

```python
from khepera_forage.envs import paired_arenas_v1

env = paired_arenas_v1.env(arena="t_maze", num_learners=1)
env = paired_arenas_v1.env(arena=["t_maze", "doors"], max_cycles=2500)  # every attempt in one of them
```
"""

from collections.abc import Sequence
from typing import Any

from khepera_forage.envs.arena_settings import settings_of, training_rounds
from khepera_forage.envs.arguments import Arenas, FoodOdds
from khepera_forage.envs.training import TrainingEnv, makers
from khepera_forage.sim.arena import Arena

__all__ = ["env", "parallel_env", "raw_env"]


class raw_env(TrainingEnv):  # noqa: N801 (PettingZoo's name)
    """`TrainingEnv` in any arena, with its food types and a number of rounds that its paths need.

    Args:
        arena: One of `ARENAS`, or an `Arena`; or a sequence of both, of which every attempt takes place in one.
        max_cycles: Of an episode; by default a fifth more than the arena's step limit. Several arenas need it.
        food_types: By default those of the arena; with several arenas, all PICKABLE.
        kwargs: Further arguments of `TrainingEnv`.

    Raises:
        ValueError: An argument is not allowed, or several arenas have no `max_cycles`.
    """

    def __init__(
        self, arena: Arenas = "t_maze", max_cycles: int | None = None, food_types: FoodOdds = None, **kwargs: Any
    ) -> None:
        if isinstance(arena, Sequence) and not isinstance(arena, str):
            name = "arenas"
            if max_cycles is None:
                raise ValueError("max_cycles is None; allowed with several arenas: a whole number of at least 1")
        else:
            settings, name = settings_of(arena), arena.name if isinstance(arena, Arena) else arena
            max_cycles = training_rounds(settings["limit"]) if max_cycles is None else max_cycles
            food_types = settings.get("food_types") if food_types is None else food_types
        super().__init__(arena=arena, max_cycles=max_cycles, food_types=food_types, **kwargs)
        self.metadata = self.metadata | {"name": f"paired_{name}_v1"}


env, parallel_env = makers(raw_env)
