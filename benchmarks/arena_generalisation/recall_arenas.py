"""The arenas in which learners forage: those of the thesis, the named family, and procedural arenas."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from khepera_forage.envs.arena_settings import procedural_settings, settings_of
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS

THESIS, NAMED = "thesis", "named"
"""Groups of arenas; the others are difficulties."""


class RecallArena(NamedTuple):
    """An arena, with the settings of its environments.

    Attributes:
        name: Of the arena.
        group: `THESIS`, `NAMED` or a difficulty.
        arena: As for the environments.
        arguments: What environments, compiled batches and compiled recalls take beside the arena.
    """

    name: str
    group: str
    arena: Arena | str
    arguments: Mapping[str, Any]

    @property
    def limit(self) -> int:
        """Steps of a recall at most."""
        return int(self.arguments["limit"])

    def limited(self, limit: int) -> "RecallArena":
        """The same with recalls of `limit` steps at most."""
        return self._replace(arguments={**self.arguments, "limit": min(limit, self.limit)})


def named_arenas(names: Sequence[str]) -> list[RecallArena]:
    """Arenas of the thesis and of the family.

    Args:
        names: As for `settings_of`.
    """
    return [
        _recall_arena(name, THESIS if name in THESIS_ARENAS else NAMED, settings_of(name)) for name in names
    ]


def procedural_arenas(difficulty: str, split: str, first: int, levels: int) -> list[RecallArena]:
    """Some levels of a difficulty.

    Args:
        difficulty: A name of `DIFFICULTIES`.
        split: `train` or `test`.
        first: First level, counted from the first one of the split.
        levels: How many.
    """
    settings = procedural_settings(difficulty, split, levels, first)
    return [
        _recall_arena(arena.name, difficulty, {**settings, "arena": arena}) for arena in settings["arena"]
    ]


def _recall_arena(name: str, group: str, settings: Mapping[str, Any]) -> RecallArena:
    more = {key: value for key, value in settings.items() if key != "arena"}
    return RecallArena(name, group, settings["arena"], more)
