"""The arenas of an environment: one for all episodes, or several of which each episode takes place in one."""

from collections.abc import Sequence
from functools import cached_property

from khepera_forage.envs.arguments import checked_arena, given_arena
from khepera_forage.sim.arena import Arena
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import arena_number

Arenas = Arena | str | Sequence[Arena | str]
"""How users give arenas: an `Arena`, one of the names in `ARENAS`, or a sequence of both: `["corridor", "doors"]`.

A sequence may create its arenas when they are first used. If it has an attribute `diagonal`, in mm, no arena of it may
have a larger diagonal; an environment then need not look at all arenas to know how large distances can become.
"""

_MOST_KEPT = 10_000
"""Arenas that are kept after their first episode, each of some 5 kB."""


class ArenaPool:
    """The arenas of an environment, checked when an episode first takes place in them.

    Args:
        arenas: See `Arenas`.
        decisions: Where start, food and home are in the thesis's arenas (figure 5.1).

    Raises:
        ValueError: An unknown name, an empty sequence, or something else.
    """

    def __init__(self, arenas: Arenas, decisions: Decisions) -> None:
        self._decisions = decisions
        self._checked: dict[int, Arena] = {}
        if isinstance(arenas, Sequence) and not isinstance(arenas, str):
            if not len(arenas):
                raise ValueError(f"arena is {arenas!r}; allowed: at least one arena in a sequence")
            self._arenas: Sequence[Arena | str] = arenas
            if type(arenas) in (list, tuple):  # another sequence may create its arenas when they are used
                self._given()
        else:
            self._checked[0] = checked_arena(arenas, decisions)
            self._arenas = (self._checked[0],)

    def __len__(self) -> int:
        return len(self._arenas)

    def __getitem__(self, number: int) -> Arena:
        """The arena with this number.

        Raises:
            ValueError: It is no arena, its name is unknown, or it is too narrow.
        """
        if number not in self._checked:
            if len(self._checked) == _MOST_KEPT:
                self._checked.clear()
            self._checked[number] = checked_arena(self._arenas[number], self._decisions, _name_of(number))
        return self._checked[number]

    def number(self, key: int, episode: int) -> int:
        """Number of the arena in which an episode of a world takes place; see `task.placement.arena_number`."""
        return int(arena_number(key, episode, len(self))) if len(self) > 1 else 0

    @cached_property
    def diagonal(self) -> int:
        """The largest diagonal of all arenas, in pixels."""
        known = getattr(self._arenas, "diagonal", None)
        if known is None:
            known = max(arena.diagonal for arena in self._given())
        return whole_pixels(known)

    def _given(self) -> list[Arena]:
        """All arenas of the sequence, not yet checked for ways that are too narrow.

        Raises:
            ValueError: One is no arena, or its name is unknown.
        """
        return [
            given_arena(arena, self._decisions, _name_of(number)) for number, arena in enumerate(self._arenas)
        ]


def _name_of(number: int) -> str:
    """What messages call an arena of a sequence."""
    return f"arena {number} of a sequence"
