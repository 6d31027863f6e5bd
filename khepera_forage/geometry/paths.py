"""Shortest paths around walls: where to drive next to get to a place. Plain functions, also compiled.

An arena is prepared once (`sim.waypoints`): the waypoints lie around the corners of walls and obstacles that point into
the floor, with room for a robot that turns with food in its gripper. Two tables hold the lengths of the shortest paths
between them, and which of them may be seen from each cell of a coarse grid. The functions here look up, in every round,
which waypoint comes next. An arena without such corners, like those of the thesis, has no waypoints, and every way is
straight.

All lengths are in pixels. Arguments that functions have in common: a robot drives from (x, y) to (to_x, to_y);
`walls` are `geometry.plane.Wall` records, and `paths` is what is prepared of the arena. With `past_home` a way must
pass the home at its berth, but may come about as near to it as its ends are; without, it leads to the home.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from khepera_forage.geometry.plane import length, to_wall

_NEARER = 0.85
"""Share of the distance from an end of a way to the walls at a corner, or to the home, at which it may pass that."""
_REACHED = 1e-6
"""Pixels to a waypoint at which the next one is looked for."""
_AT_LEAST = 1.0 - 1e-9
"""Share of the straight way below which no path is, whatever is rounded."""
CELLS = 8
"""Columns and rows of the grid of an arena."""
KEPT = 8.0
"""Pixels (40 mm) for which a robot drives to a waypoint before it looks for a shorter way. Nearer than this to the
waypoint, it looks in every round, so that it turns to the next one in time."""


@dataclass(slots=True)
class ChosenWaypoint:
    """The next waypoint on the way of a robot to one place, while walls block the straight way.

    Attributes:
        x: Where the robot was when it chose the waypoint, pixels; infinite without one.
        y: Likewise.
        number: Of the waypoint.
        rest: Length of the path from the waypoint to the place, pixels.
    """

    x: float = math.inf
    y: float = math.inf
    number: int = 0
    rest: float = 0.0


class Spot(NamedTuple):
    """A place in pixels."""

    x: float
    y: float


class Corner(NamedTuple):
    """A corner of walls that points into the floor.

    Attributes:
        x: In pixels.
        y: In pixels.
        before: Number of the wall that ends there.
        after: Number of the wall that begins there.
    """

    x: float
    y: float
    before: int
    after: int


class PathTables(NamedTuple):
    """What is prepared of an arena.

    Attributes:
        clearance: Pixels at which a straight way must pass the corners of walls.
        home_x: Centre of the home in pixels.
        home_y: Likewise.
        berth: Pixels from that centre at which a robot on its way to food must pass the home, out of which it would be
            turned.
        left: Of the grid.
        bottom: Likewise.
        columns: Of the grid, a pixel.
        rows: Likewise.
        corners: `Corner` records.
        waypoints: `Spot` records.
        lengths: Of the shortest path past the home from waypoint a to waypoint b, at a * number of waypoints + b;
            infinite without, and to a waypoint in the home, to which only the way home leads.
        home_lengths: Of the shortest path from each waypoint to the home; infinite without.
        seen: Whether waypoint k may be seen from some place in a cell, at cell * number of waypoints + k. The last cell
            is what lies outside the grid.
    """

    clearance: float
    home_x: float
    home_y: float
    berth: float
    left: float
    bottom: float
    columns: float
    rows: float
    corners: Any
    waypoints: Any
    lengths: Any
    home_lengths: Any
    seen: Any


NO_CORNERS = PathTables(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (), (), (), (), b"")
"""Of an arena in which every way is straight."""


def has_path(x: float, y: float, to_x: float, to_y: float, past_home: bool, walls: Any, paths: PathTables) -> bool:
    """Whether there is a path from one place to another."""
    return (
        is_clear(x, y, to_x, to_y, past_home, walls, paths)
        or _choose_waypoint(x, y, to_x, to_y, past_home, walls, paths)[0] >= 0
    )


def is_clear(x: float, y: float, to_x: float, to_y: float, past_home: bool, walls: Any, paths: PathTables) -> bool:
    """Whether a robot can drive straight from one place to another.

    A way crosses no wall, and passes every corner at the clearance, or at half its length if that is less: a robot just
    before food drives on to it. It may come about as near to a corner as its ends are to the walls that meet there: so
    a robot that stands beside a wall can leave it, and reach food that lies beside one.
    """
    if past_home and crosses_home(x, y, to_x, to_y, paths):
        return False
    return not is_blocked(x, y, to_x, to_y, walls, paths)


def is_blocked(x: float, y: float, to_x: float, to_y: float, walls: Any, paths: PathTables) -> bool:
    """Whether a way crosses a wall, or passes a corner too closely; the home is left aside."""
    for k in range(len(walls)):
        if _is_crossed(x, y, to_x, to_y, walls[k]):
            return True
    for k in range(len(paths.corners)):  # noqa: SIM110 (numba compiles no generator expressions)
        if _is_passed_closely(x, y, to_x, to_y, paths.corners[k], walls, paths):
            return True
    return False


def crosses_home(x: float, y: float, to_x: float, to_y: float, paths: PathTables) -> bool:
    """Whether a way passes the home more closely than at its berth."""
    dx, dy = to_x - x, to_y - y
    home_x, home_y = paths.home_x - x, paths.home_y - y
    squared = dx * dx + dy * dy
    along = home_x * dx + home_y * dy
    if along <= 0.0 or along >= squared:
        return False
    # How far the home lies aside, times the length of the way, squared: roots and quotients would take longer.
    aside = (home_x * dy - home_y * dx) ** 2
    if aside >= paths.berth * paths.berth * squared:
        return False
    nearer_end = min(home_x * home_x + home_y * home_y, (home_x - dx) ** 2 + (home_y - dy) ** 2)
    return bool(aside < _NEARER * _NEARER * squared * nearer_end)


def _is_crossed(x: float, y: float, to_x: float, to_y: float, wall: Any) -> bool:
    """Whether a way crosses a wall: the ends of each lie on different sides of the other."""
    here = wall.normal_x * x + wall.normal_y * y - wall.offset
    there = wall.normal_x * to_x + wall.normal_y * to_y - wall.offset
    dx, dy = to_x - x, to_y - y
    first = dx * (wall.y1 - y) - dy * (wall.x1 - x)
    second = first + dx * wall.ey - dy * wall.ex
    return bool(((here > 0.0) != (there > 0.0)) & ((first > 0.0) != (second > 0.0)))


def _is_passed_closely(
    x: float, y: float, to_x: float, to_y: float, corner: Any, walls: Any, paths: PathTables
) -> bool:
    """Whether a way passes a corner too closely."""
    dx, dy = to_x - x, to_y - y
    corner_x, corner_y = corner.x - x, corner.y - y
    squared, along = dx * dx + dy * dy, corner_x * dx + corner_y * dy
    # As in `crosses_home`, with the corner in place of the home.
    aside = (corner_x * dy - corner_y * dx) ** 2
    # Without `and`, which compiled code would guess wrongly at many corners.
    close = aside < min(paths.clearance * paths.clearance, squared / 4.0) * squared
    if not (close & (along > 0.0) & (along < squared)):
        return False
    before, after = walls[corner.before], walls[corner.after]
    nearer_end = min(
        _squared_distance(x, y, before),
        _squared_distance(x, y, after),
        _squared_distance(to_x, to_y, before),
        _squared_distance(to_x, to_y, after),
    )
    return bool(aside < _NEARER * _NEARER * squared * nearer_end)


def _squared_distance(x: float, y: float, wall: Any) -> float:
    dx, dy = to_wall(x, y, wall)
    return dx * dx + dy * dy


def next_waypoint(
    x: float, y: float, to_x: float, to_y: float, past_home: bool, chosen: Any, walls: Any, paths: PathTables
) -> tuple[float, float, float]:
    """Where to drive next on the shortest path to a place: to the place itself if the straight way is clear.

    Returns x and y of the waypoint, and the length of the path, which is infinite where there is none. `chosen` is the
    `ChosenWaypoint` record of this way; it is changed in place.
    """
    blocked = is_blocked(x, y, to_x, to_y, walls, paths)
    if not blocked:
        chosen.x = chosen.y = math.inf
        if not (past_home and crosses_home(x, y, to_x, to_y, paths)):
            return to_x, to_y, length(to_x - x, to_y - y)
    if not _is_kept(x, y, past_home, chosen, walls, paths):
        number, rest = _choose_waypoint(x, y, to_x, to_y, past_home, walls, paths)
        if number < 0:
            return x, y, math.inf
        chosen.number, chosen.rest = number, rest
        # Where only the home is in the way, a robot looks for a shorter way in every round.
        if blocked:
            chosen.x, chosen.y = x, y
    point = paths.waypoints[chosen.number]
    return point.x, point.y, length(point.x - x, point.y - y) + chosen.rest


def _is_kept(x: float, y: float, past_home: bool, chosen: Any, walls: Any, paths: PathTables) -> bool:
    """Whether the waypoint last chosen still comes next."""
    if length(x - chosen.x, y - chosen.y) >= KEPT:
        return False
    point = paths.waypoints[chosen.number]
    if length(point.x - x, point.y - y) <= KEPT:
        return False
    return is_clear(x, y, point.x, point.y, past_home, walls, paths)


def _choose_waypoint(
    x: float, y: float, to_x: float, to_y: float, past_home: bool, walls: Any, paths: PathTables
) -> tuple[int, float]:
    """The next waypoint on the shortest path, -1 without a path, and the length of the path from there."""
    best, found, rest = math.inf, -1, math.inf
    count = len(paths.waypoints)
    row = _cell_of(x, y, paths) * count
    for k in range(count):
        if paths.seen[row + k]:
            point = paths.waypoints[k]
            first = length(point.x - x, point.y - y)
            if first > _REACHED and first + _AT_LEAST * length(to_x - point.x, to_y - point.y) < best:
                if past_home:
                    beyond = shortest_length(k, to_x, to_y, best - first, True, walls, paths)
                else:
                    beyond = float(paths.home_lengths[k])
                if first + beyond < best and is_clear(x, y, point.x, point.y, past_home, walls, paths):
                    best, found, rest = first + beyond, k, beyond
    return found, rest


def shortest_length(
    number: int, to_x: float, to_y: float, most: float, past_home: bool, walls: Any, paths: PathTables
) -> float:
    """Length of the shortest path from waypoint `number` to a place; infinite without one shorter than `most`."""
    count = len(paths.waypoints)
    row, column = number * count, _cell_of(to_x, to_y, paths) * count
    tried, last = 0.0, -1
    while True:
        # The shortest of those not tried: whether a way is clear takes longest to find out.
        best, found = math.inf, -1
        for k in range(count):
            if paths.seen[column + k]:
                point = paths.waypoints[k]
                total = paths.lengths[row + k] + length(to_x - point.x, to_y - point.y)
                if total < best and (total > tried or (total == tried and k > last)):
                    best, found = total, k
        if best >= most:
            return math.inf
        point = paths.waypoints[found]
        if is_clear(point.x, point.y, to_x, to_y, past_home, walls, paths):
            return best
        tried, last = best, found


def _cell_of(x: float, y: float, paths: PathTables) -> int:
    """Number of the cell of a place in the grid."""
    column, row = math.floor((x - paths.left) * paths.columns), math.floor((y - paths.bottom) * paths.rows)
    if 0 <= column < CELLS and 0 <= row < CELLS:
        return int(row * CELLS + column)
    return CELLS * CELLS
