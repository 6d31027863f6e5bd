"""What the environments of an arena have besides the arena: food objects, food types, step limit and noise."""

from typing import Any

from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.difficulty import Difficulty, checked_difficulty
from khepera_forage.sim.arenas.named import ARENAS, FAMILY, step_limit
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.sim.arenas.thesis import CORRIDOR, RECTANGLE
from khepera_forage.sim.waypoints import longest_path

_THESIS = {CORRIDOR: {"foods": 1, "limit": 500}, RECTANGLE: {"foods": 2, "limit": 700}}
"""Of recalls (5.4)."""


def environment_name(arena: str) -> str:
    """The name of an arena in the names of its environments: `t_maze` is `TMaze`."""
    return "".join(word.capitalize() for word in arena.split("_"))


def settings_of(arena: str | Arena) -> dict[str, Any]:
    """The arguments of a recall environment of an arena.

    Args:
        arena: One of `ARENAS`; or an arena of your own, whose step limit follows from its paths, as in the family.

    Raises:
        ValueError: Another name.
    """
    if isinstance(arena, Arena):
        foods = len(arena.foods)
        return {"arena": arena, "foods": foods, "limit": step_limit(foods, longest_path(arena))}
    if arena not in ARENAS:
        raise ValueError(f"arena is {arena!r}; allowed: an Arena, or one of {', '.join(map(repr, ARENAS))}")
    if arena in _THESIS:
        return {"arena": arena, **_THESIS[arena]}
    data = FAMILY[arena]
    settings = {"arena": arena, "foods": len(data.foods), "limit": data.limit}
    return settings if data.food_types is None else {**settings, "food_types": dict(data.food_types)}


def procedural_settings(difficulty: str | Difficulty, split: str, num_levels: int, start_level: int) -> dict[str, Any]:
    """The arguments of a recall environment in procedural arenas; own arguments and errors as of `ProceduralArenas`."""
    chosen = checked_difficulty(difficulty)
    return {
        "arena": ProceduralArenas(difficulty, split, num_levels, start_level),
        "foods": chosen.foods,
        "limit": chosen.limit,
        "food_types": chosen.food_types,
        "noise": chosen.scaled_noise(),
    }


def training_rounds(limit: int) -> int:
    """Rounds of a training episode: as many more than the steps of a recall as in the corridor, 600 to 500."""
    return limit * 6 // 5
