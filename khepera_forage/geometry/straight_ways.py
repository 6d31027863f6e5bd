"""Straight ways between two places: whether a robot can drive them. Plain functions, also compiled.

Robots count in pixels. Walls are `geometry.walls.Wall` records, ways are `geometry.paths.Ways`.
"""

from typing import Any

from khepera_forage.geometry.walls import to_wall

NEARER = 0.85
"""Share of the distance from an end of a way to the walls at a corner, at which the way may pass that corner."""
_BESIDE_HOME = 0.85
"""The same share for a robot or food beside the home."""


def is_clear(x: float, y: float, to_x: float, to_y: float, past_home: bool, walls: Any, ways: Any) -> bool:
    """Whether a robot can drive straight from one place to another.

    A way crosses no wall, and passes every corner at the clearance, or at half its length if that is less: a robot just
    before food drives on to it. It may come about as near to a corner as its ends are to the walls that meet there: so
    a robot that stands beside a wall can leave it, and reach food that lies beside one.

    Args:
        x: Of the one place.
        y: Of the one place.
        to_x: Of the other place.
        to_y: Of the other place.
        past_home: Whether the way must pass the home at its berth. It may come about as near to it as its ends are.
        walls: `geometry.walls.Wall` records in pixels.
        ways: `geometry.paths.Ways`.
    """
    if past_home and crosses_home(x, y, to_x, to_y, ways):
        return False
    return find_blocker(x, y, to_x, to_y, walls, ways) < 0


def find_blocker(x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> int:
    """The first wall that a way crosses, or else the first corner that it passes too closely.

    Returns:
        Number of the wall; number of walls + number of the corner; or -1 if the way is clear. The home is left aside.
    """
    for k in range(len(walls)):
        if is_crossed(x, y, to_x, to_y, walls[k]):
            return k
    for k in range(len(ways.corners)):
        if is_passed_closely(x, y, to_x, to_y, ways.corners[k], walls, ways):
            return len(walls) + k
    return -1


def blocks(number: int, x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> bool:
    """Whether a wall or corner blocks a way.

    Args:
        number: Of the wall or corner, see `find_blocker`.
        x: As for `is_clear`; so are the others.
        y: Of the one place.
        to_x: Of the other place.
        to_y: Of the other place.
        walls: `geometry.walls.Wall` records in pixels.
        ways: `geometry.paths.Ways`.
    """
    if number < len(walls):
        return is_crossed(x, y, to_x, to_y, walls[number])
    return is_passed_closely(x, y, to_x, to_y, ways.corners[number - len(walls)], walls, ways)


def crosses_home(x: float, y: float, to_x: float, to_y: float, ways: Any) -> bool:
    """Whether a way passes the home more closely than at its berth; arguments as for `is_clear`."""
    dx, dy = to_x - x, to_y - y
    home_x, home_y = ways.home_x - x, ways.home_y - y
    squared = dx * dx + dy * dy
    along = home_x * dx + home_y * dy
    if along <= 0.0 or along >= squared:
        return False
    # How far the home lies aside, times the length of the way, squared: roots and quotients would take longer.
    aside = (home_x * dy - home_y * dx) ** 2
    if aside >= ways.berth * ways.berth * squared:
        return False
    nearer_end = min(home_x * home_x + home_y * home_y, (home_x - dx) ** 2 + (home_y - dy) ** 2)
    return bool(aside < _BESIDE_HOME * _BESIDE_HOME * squared * nearer_end)


def is_crossed(x: float, y: float, to_x: float, to_y: float, wall: Any) -> bool:
    """Whether a way crosses a wall."""
    here = wall.normal_x * x + wall.normal_y * y - wall.offset
    there = wall.normal_x * to_x + wall.normal_y * to_y - wall.offset
    if (here > 0.0) == (there > 0.0):
        return False
    share = here / (here - there)
    crossing_x, crossing_y = x + share * (to_x - x) - wall.x1, y + share * (to_y - y) - wall.y1
    along = crossing_x * wall.ex + crossing_y * wall.ey
    return bool(0.0 <= along * wall.share <= 1.0)


def is_passed_closely(
    x: float, y: float, to_x: float, to_y: float, corner: Any, walls: Any, ways: Any
) -> bool:
    """Whether a way passes a corner too closely."""
    dx, dy = to_x - x, to_y - y
    corner_x, corner_y = corner.x - x, corner.y - y
    squared, along = dx * dx + dy * dy, corner_x * dx + corner_y * dy
    if along <= 0.0 or along >= squared:
        return False
    # As in `crosses_home`, with the corner in place of the home.
    aside = (corner_x * dy - corner_y * dx) ** 2
    if aside >= min(ways.clearance * ways.clearance, squared / 4.0) * squared:
        return False
    return bool(aside < NEARER * NEARER * squared * nearest_end(x, y, to_x, to_y, corner, walls))


def nearest_end(x: float, y: float, to_x: float, to_y: float, corner: Any, walls: Any) -> float:
    """The squared distance of the nearer end of a way from the walls that meet at a corner.

    Args:
        x: As for `is_clear`; so are the others.
        y: Of the one place.
        to_x: Of the other place.
        to_y: Of the other place.
        corner: `geometry.paths.Corner`.
        walls: `geometry.walls.Wall` records in pixels.
    """
    before, after = walls[corner.before], walls[corner.after]
    return min(
        _squared_distance(x, y, before),
        _squared_distance(x, y, after),
        _squared_distance(to_x, to_y, before),
        _squared_distance(to_x, to_y, after),
    )


def _squared_distance(x: float, y: float, wall: Any) -> float:
    dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
    return dx * dx + dy * dy
