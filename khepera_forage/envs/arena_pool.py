"""The arenas of an environment: one for all episodes, or several of which each episode takes place in one."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.sim.arena import Arena
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import arena_number

Arenas = Arena | str | Sequence[Arena]
"""How users give arenas: an `Arena`, the name of one of the thesis's, or a sequence of arenas.

A sequence may create its arenas when they are first used. If it has an attribute `diagonal`, in mm, no arena of it may
have a larger diagonal; an environment then need not look at all arenas to know how large distances can become.
"""

_MOST_KEPT = 10_000
"""Arenas that are kept after their first episode, each of some 5 kB."""


class ArenaPool:
    """The arenas of an environment, checked when an episode first takes place in them.

    Args:
        arenas: See `Arenas`.
        decisions: Where start, food and home are in a named arena (figure 5.1).

    Raises:
        ValueError: An unknown name, an empty sequence, or something else.
    """

    def __init__(self, arenas: Arenas, decisions: Decisions) -> None:
        self._checked: dict[int, Arena] = {}
        if isinstance(arenas, Sequence) and not isinstance(arenas, str):
            if not len(arenas):
                raise ValueError(f"arena is {arenas!r}; allowed: at least one Arena in a sequence")
            self._arenas: Sequence[Arena] = arenas
        else:
            self._checked[0] = checked_arena(arenas, decisions)
            self._arenas = (self._checked[0],)
        self._decisions = decisions

    def __len__(self) -> int:
        return len(self._arenas)

    def __getitem__(self, number: int) -> Arena:
        """The arena with this number.

        Raises:
            ValueError: It is no arena, or too narrow.
        """
        if number not in self._checked:
            if len(self._checked) == _MOST_KEPT:
                self._checked.clear()
            self._checked[number] = checked_arena(self._given(number), self._decisions)
        return self._checked[number]

    def number(self, key: int, episode: int) -> int:
        """Number of the arena in which an episode of a world takes place; see `task.placement.arena_number`."""
        return int(arena_number(key, episode, len(self))) if len(self) > 1 else 0

    @cached_property
    def diagonal(self) -> int:
        """The largest diagonal of all arenas, in pixels."""
        known = getattr(self._arenas, "diagonal", None)
        if known is None:
            known = max(self._given(number).diagonal for number in range(len(self)))
        return whole_pixels(known)

    def _given(self, number: int) -> Arena:
        arena: Any = self._arenas[number]
        if not isinstance(arena, Arena):
            raise ValueError(f"arena {number} of a sequence is {arena!r}; allowed: an Arena")
        return arena
