"""The arenas in which learners forage: those of the thesis, the named family, and procedural test arenas."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from khepera_forage.envs.arguments import FoodOdds
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.family import FAMILY, family_arena
from khepera_forage.sim.arenas.procedural import ProceduralArenas

THESIS, NAMED = "thesis", "named"
"""Groups of arenas; the others are difficulties."""
THESIS_LIMITS = {"corridor": (1, 500), "rectangle": (2, 700)}
"""Food objects and steps (5.4)."""


class RecallArena(NamedTuple):
    """An arena, with the settings of its environments.

    Attributes:
        name: Of the arena.
        group: `THESIS`, `NAMED` or a difficulty.
        arena: As for the environments.
        foods: Number of food objects.
        limit: Steps of a recall at most.
        food_types: Odds of food types.
        noise: Of the devices.
    """

    name: str
    group: str
    arena: Arena | str
    foods: int
    limit: int
    food_types: FoodOdds
    noise: Noise

    @property
    def arguments(self) -> dict[str, Any]:
        """What environments, compiled batches and compiled recalls take beside the arena."""
        names = ("foods", "limit", "food_types", "noise")
        return {name: getattr(self, name) for name in names}


def named_arenas(names: Sequence[str]) -> list[RecallArena]:
    """Arenas of the thesis and of the family.

    Args:
        names: Keys of `THESIS_LIMITS` or `FAMILY`.
    """
    found = []
    for name in names:
        if name in THESIS_LIMITS:
            foods, limit = THESIS_LIMITS[name]
            found.append(RecallArena(name, THESIS, name, foods, limit, None, Noise.laboratory()))
        else:
            known, arena = FAMILY[name], family_arena(name)
            settings = (len(known.foods), known.limit, known.food_types, Noise.laboratory())
            found.append(RecallArena(name, NAMED, arena, *settings))
    return found


def procedural_arenas(difficulty: str, split: str, first: int, levels: int) -> list[RecallArena]:
    """Some levels of a difficulty.

    Args:
        difficulty: A key of `DIFFICULTIES`.
        split: `train` or `test`.
        first: First level, counted from the first one of the split.
        levels: How many.
    """
    known = DIFFICULTIES[difficulty]
    settings = (known.foods, known.limit, known.food_types, known.laboratory())
    return [
        RecallArena(arena.name, difficulty, arena, *settings)
        for arena in ProceduralArenas(difficulty, split, levels, first)
    ]
