"""All arenas that have a name: those of the thesis, whose places are decisions, and the family."""

from typing import Any

from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.family import FAMILY, family_arena
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS, SetUp, thesis_arena

ARENAS = (*THESIS_ARENAS, *FAMILY)
"""Names of arenas that environments, commands and laboratories accept."""


def named_arena(name: Any, set_up: SetUp) -> Arena:
    """An arena by its name.

    Args:
        name: One of `ARENAS`.
        set_up: Where start, food and home are in an arena of the thesis; without effect in other arenas.

    Raises:
        ValueError: An unknown name, or a set-up that does not fit.
    """
    if name not in ARENAS:
        raise ValueError(f"arena is {name!r}; allowed: an Arena, or one of {', '.join(map(repr, ARENAS))}")
    return family_arena(name) if name in FAMILY else thesis_arena(name, set_up)
