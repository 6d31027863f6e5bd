"""What environments find in an arena: whether they accept it, its shortest paths, and what is too narrow."""

from collections.abc import Iterable
from contextlib import suppress
from typing import NamedTuple

from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.arena_file import ArenaPlan
from khepera_forage.sim.layout_checks import check_seen
from khepera_forage.sim.ways import check_ways, shortest_path, too_narrow

Paths = tuple[tuple[Point, ...], ...]


class Findings(NamedTuple):
    """What environments find in an arena.

    Attributes:
        refusal: Why they do not accept it; empty if they do.
        to_food: Shortest paths from the start to each food object that can be reached.
        to_home: Shortest paths from each food object to the home, likewise.
        narrow: Parts of the floor in which a robot cannot turn.
    """

    refusal: str
    to_food: Paths = ()
    to_home: Paths = ()
    narrow: Paths = ()


def find(plan: ArenaPlan) -> Findings:
    """What environments find in an arena."""
    try:
        arena = plan.arena()
        check_seen((arena,))
    except ValueError as error:
        return Findings(str(error))
    refusal = ""
    try:
        check_ways(arena)
    except ValueError as error:
        refusal = str(error)
    start = Point(arena.start.x, arena.start.y)
    to_food = _paths(arena, [(start, food) for food in arena.foods])
    to_home = _paths(arena, [(food, arena.home) for food in arena.foods])
    return Findings(refusal, to_food, to_home, tuple(too_narrow(arena)))


def _paths(arena: Arena, ends: Iterable[tuple[Point, Point]]) -> Paths:
    """The shortest paths between places, as far as there are some."""
    found = []
    for start, goal in ends:
        with suppress(ValueError):
            found.append(shortest_path(arena, start, goal))
    return tuple(found)
