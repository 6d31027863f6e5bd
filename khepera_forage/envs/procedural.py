"""Entry points of `gym.make` and `gym.make_vec` for procedural arenas: a difficulty instead of an arena."""

from typing import Any

from khepera_forage.envs import backends
from khepera_forage.envs.arena_settings import procedural_settings
from khepera_forage.envs.backends import EntryPoint, VectorEntryPoint, restored
from khepera_forage.sim.arenas.difficulty import Difficulty


class ProceduralEntryPoint:
    """Makes an environment in which each episode takes place in one of many procedural arenas.

    Args:
        make: The entry point of environments of any arena.
    """

    metadata = EntryPoint.metadata

    def __init__(self, make: EntryPoint | VectorEntryPoint) -> None:
        self._make = make

    def __call__(
        self,
        difficulty: str | Difficulty = "medium",
        split: str = "train",
        num_levels: int = 200,
        start_level: int = 0,
        **kwargs: Any,
    ) -> Any:
        """Make the environment.

        Args:
            difficulty: One of `DIFFICULTIES`, or a `Difficulty` of your own.
            split: `"train"` or `"test"`, which have no level in common.
            num_levels: How many levels.
            start_level: First level, counted from the first one of the split.
            kwargs: Other arguments of the entry point. `limit`, `food_types` and `noise` override those of the
                difficulty.

        Raises:
            ValueError: As `ProceduralArenas`; or an arena or a number of food objects is given.
        """
        for name in ("arena", "foods"):
            if name in kwargs:
                raise ValueError(f"{name} is {kwargs[name]!r}; allowed here: none, because difficulty determines it")
        settings = procedural_settings(restored(difficulty), split, num_levels, start_level)
        return self._make(**{**settings, **kwargs})


behaviours_v1 = ProceduralEntryPoint(backends.behaviours_v1)
wheels_v1 = ProceduralEntryPoint(backends.wheels_v1)
behaviours_vector_v1 = ProceduralEntryPoint(backends.behaviours_vector_v1)
wheels_vector_v1 = ProceduralEntryPoint(backends.wheels_vector_v1)
