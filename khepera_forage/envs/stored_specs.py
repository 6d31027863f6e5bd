"""Arguments as Gymnasium stores them: a spec that was written as JSON has a mapping for every dataclass."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.task.decisions import Decisions


def spec_decisions(decisions: Any, default: Decisions) -> Any:
    """The decisions of an environment that Gymnasium makes.

    Args:
        decisions: From the user or the spec; a spec that was stored as JSON has a mapping of all fields.
        default: Of the environment's version.

    Returns:
        The default for None, `Decisions` for such a mapping, and anything else as it is, for `checked_decisions`.

    Raises:
        ValueError: A value in the mapping is not allowed.
    """
    if decisions is None:
        return default
    if isinstance(decisions, Mapping) and decisions.keys() == _DECISIONS:
        return Decisions(**decisions)
    return decisions


def spec_arena(arena: Any) -> Any:
    """The arena of an environment that Gymnasium makes.

    Args:
        arena: From the user or the spec; or a list of these.

    Returns:
        An `Arena` for a mapping of all its fields, and anything else as it is, for `checked_arena`.

    Raises:
        ValueError: The arena in the mapping is not allowed.
    """
    if isinstance(arena, list):
        return [spec_arena(one) for one in arena]
    if not (isinstance(arena, Mapping) and arena.keys() == _ARENA):
        return arena
    return Arena(
        name=arena["name"],
        walls=_points(arena["walls"]),
        home=Point(*arena["home"]),
        home_radius=arena["home_radius"],
        start=Pose(*arena["start"]),
        foods=_points(arena["foods"]),
        obstacles=tuple(map(_points, arena["obstacles"])),
    )


def _points(places: Any) -> tuple[Point, ...]:
    return tuple(Point(*place) for place in places)


_DECISIONS, _ARENA = ({field.name for field in fields(kind)} for kind in (Decisions, Arena))
