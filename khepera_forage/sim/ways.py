"""Ways through an arena, prepared once: waypoints around corners, and which parts of the floor cannot be reached.

The floor is shrunk by the room that a robot needs to turn with food in its gripper. What remains is where its centre
may drive. The waypoints are the corners of that region that point into it, and the visibility graph between them gives
all shortest paths. `geometry.paths` looks them up in every round.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from khepera_forage.geometry.paths import NO_WAYS, Corner, Spot, Ways, find_lengths, next_waypoint
from khepera_forage.geometry.walls import wall_of
from khepera_forage.robots.khepera import FINGER_TIP
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.vision.scene import MM_PER_PIXEL

if TYPE_CHECKING:
    from shapely import Polygon

CLEARANCE = FINGER_TIP + 5.0
"""mm from a waypoint's path to walls: a robot can turn there, with food in its gripper."""
_PASSING = CLEARANCE - 7.5
"""mm at which a straight way must pass a corner: less, because the camera sees the robot beside its path."""
_BLUNT = 1.5
"""Waypoints at sharp corners lie at most this many clearances from them."""
_ROUNDING = 0.01
"""mm by which a path may leave the shrunken floor, along whose edges it runs."""


@lru_cache(maxsize=1024)
def ways_of(arena: Arena) -> Ways:
    """The ways through an arena, in pixels; `NO_WAYS` if no corner points into its floor."""
    corners = arena.corners
    if not corners:
        return NO_WAYS
    waypoints, lengths = _visibility_graph(arena)
    ways = Ways(
        _PASSING / MM_PER_PIXEL,
        tuple(Corner(x / MM_PER_PIXEL, y / MM_PER_PIXEL, before, after) for x, y, before, after in corners),
        tuple(Spot(x / MM_PER_PIXEL, y / MM_PER_PIXEL) for x, y in waypoints.tolist()),
        tuple((lengths / MM_PER_PIXEL).ravel().tolist()),
        (),
    )
    return ways._replace(home_lengths=tuple(_lengths_to(arena, arena.home, ways)))


def pixel_walls(arena: Arena) -> tuple[Any, ...]:
    """The walls of an arena as `geometry.walls.Wall` records in pixels."""
    return tuple(
        wall_of(
            (
                wall.x1 / MM_PER_PIXEL,
                wall.y1 / MM_PER_PIXEL,
                (wall.x1 + wall.ex) / MM_PER_PIXEL,
                (wall.y1 + wall.ey) / MM_PER_PIXEL,
            ),
            wall.polygon,
        )
        for wall in arena.wall_records
    )


def way_out(arena: Arena) -> tuple[float, float]:
    """Where a robot that leaves the home should drive, in mm.

    The middle of the floor, or, where there are waypoints, the first one towards the start.
    """
    x1, y1, x2, y2 = arena.bounds
    ways, home, start = ways_of(arena), arena.home, arena.start
    if not ways.corners:
        return (x1 + x2) / 2, (y1 + y2) / 2
    lengths = _lengths_to(arena, Point(start.x, start.y), ways)
    ends = home.x / MM_PER_PIXEL, home.y / MM_PER_PIXEL, start.x / MM_PER_PIXEL, start.y / MM_PER_PIXEL
    x, y, _ = next_waypoint(*ends, lengths, pixel_walls(arena), ways)
    return x * MM_PER_PIXEL, y * MM_PER_PIXEL


def shortest_path(arena: Arena, start: Point, goal: Point) -> tuple[Point, ...]:
    """The shortest path between two places, as a robot drives it.

    Args:
        arena: Where.
        start: In mm.
        goal: In mm.

    Returns:
        The start, the waypoints, and the goal, in mm.

    Raises:
        ValueError: There is none.
    """
    ways, walls = ways_of(arena), pixel_walls(arena)
    lengths = _lengths_to(arena, goal, ways)
    end = Spot(goal.x / MM_PER_PIXEL, goal.y / MM_PER_PIXEL)
    here, path = Spot(start.x / MM_PER_PIXEL, start.y / MM_PER_PIXEL), [start]
    while here != end:
        x, y, length = next_waypoint(*here, *end, lengths, walls, ways)
        if length == math.inf or len(path) > len(ways.waypoints) + 1:
            raise ValueError(
                f"{arena.name}: there is no way from ({start.x:g}, {start.y:g}) to ({goal.x:g}, {goal.y:g}) mm that is "
                f"{2 * CLEARANCE:g} mm wide"
            )
        here = Spot(x, y)
        path.append(goal if here == end else Point(x * MM_PER_PIXEL, y * MM_PER_PIXEL))
    return tuple(path)


def check_ways(arena: Arena) -> None:
    """Complain unless a robot can drive from the start to every food object, and from there home.

    Args:
        arena: One arena.

    Raises:
        ValueError: It cannot; the message says what cannot be reached, and where the arena is too narrow.
    """
    ways, walls = ways_of(arena), pixel_walls(arena)
    home_x, home_y = arena.home.x / MM_PER_PIXEL, arena.home.y / MM_PER_PIXEL
    places = {"the start": arena.start, **{f"food {k + 1}": food for k, food in enumerate(arena.foods)}}
    for name, place in places.items():
        x, y = place[0] / MM_PER_PIXEL, place[1] / MM_PER_PIXEL
        if next_waypoint(x, y, home_x, home_y, ways.home_lengths, walls, ways)[2] == math.inf:
            raise ValueError(
                f"{arena.name}: there is no way between {name} at ({place[0]:g}, {place[1]:g}) mm and the home at "
                f"({arena.home.x:g}, {arena.home.y:g}) mm{_narrow_places(arena)}; allowed: passages that are "
                f"{2 * CLEARANCE:g} mm wide or more (`khepera-forage arena show` draws them)"
            )


def too_narrow(arena: Arena) -> list[tuple[Point, ...]]:
    """The parts of the floor in which a robot cannot turn and that separate others, or lead nowhere.

    Returns:
        Polygons in mm.
    """
    import shapely

    if not arena.corners:
        return []
    region = _shrunken_floor(arena)
    reached = region.buffer(CLEARANCE * (1.0 + 1e-6))
    rest = _floor(arena).difference(reached)
    # Corners of the floor that the robot's round outline leaves out are no passages.
    parts = [part for part in getattr(rest, "geoms", [rest]) if _is_passage(part, reached)]
    return [tuple(Point(x, y) for x, y in shapely.get_coordinates(part.exterior)[:-1]) for part in parts]


def _is_passage(part: Any, reached: Any) -> bool:
    pieces = getattr(reached, "geoms", [reached])
    touched = sum(piece.distance(part) < 1.0 for piece in pieces)
    return bool(touched != 1 or part.area > CLEARANCE**2)


def _narrow_places(arena: Arena) -> str:
    places = []
    for corners in too_narrow(arena):
        xs, ys = [corner.x for corner in corners], [corner.y for corner in corners]
        places.append(f"({sum(xs) / len(xs):.0f}, {sum(ys) / len(ys):.0f})")
    return f"; it is too narrow near {', '.join(places)} mm" if places else ""


def _floor(arena: Arena) -> "Polygon":
    import shapely

    obstacles = shapely.union_all([shapely.Polygon(corners) for corners in arena.obstacles])
    floor: Polygon = shapely.Polygon(arena.walls).difference(obstacles)
    return floor


def _shrunken_floor(arena: Arena) -> Any:
    """Where the centre of a robot that turns on the spot may be: a polygon, or several."""
    return _floor(arena).buffer(-CLEARANCE, join_style="mitre", mitre_limit=_BLUNT)


def _visibility_graph(arena: Arena) -> tuple[Any, Any]:
    """Waypoints in mm, shape (n, 2), and the lengths of the shortest paths between them, shape (n, n)."""
    import shapely
    from scipy.sparse.csgraph import shortest_path as shortest_lengths

    region = _shrunken_floor(arena)
    corners = [_inward_corners(part) for part in getattr(region, "geoms", [region])]
    before, waypoints, after = np.concatenate(corners, axis=1)
    count = len(waypoints)
    first, second = np.triu_indices(count, 1)
    # A shortest path touches each corner that it goes round: only such pairs can be part of one.
    touches = [
        _is_touched(waypoints[a], waypoints[b], before[a], after[a])
        for a, b in ((first, second), (second, first))
    ]
    first, second = first[touches[0] & touches[1]], second[touches[0] & touches[1]]
    lines = shapely.linestrings(np.stack([waypoints[first], waypoints[second]], axis=1))
    allowed = region.buffer(_ROUNDING, join_style="mitre")
    shapely.prepare(allowed)
    seen = shapely.covers(allowed, lines)
    graph = np.full((count, count), np.inf)
    graph[first[seen], second[seen]] = shapely.length(lines[seen])
    return waypoints, shortest_lengths(graph, directed=False)


def _inward_corners(part: "Polygon") -> Any:
    """The corners of a polygon, and of its holes, that point into it, with the corners before and after each.

    Returns:
        In mm, shape (3, corners, 2): the corners before, the corners themselves, and the corners after.
    """
    from shapely.geometry.polygon import orient

    found = [np.zeros((3, 0, 2))]
    turned = orient(part)
    for ring in (turned.exterior, *turned.interiors):
        here = np.asarray(ring.coords)[:-1]
        before, after = np.roll(here, 1, axis=0), np.roll(here, -1, axis=0)
        found.append(np.stack([before, here, after])[:, _cross(here - before, after - here) < 0])
    return np.concatenate(found, axis=1)


def _is_touched(place: Any, to: Any, before: Any, after: Any) -> Any:
    """Whether lines from corners touch them: the sides that meet there are on the same side of the line."""
    way = to - place
    return _cross(way, before - place) * _cross(way, after - place) >= -_ROUNDING


def _cross(a: Any, b: Any) -> Any:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _lengths_to(arena: Arena, goal: Point, ways: Ways) -> list[float]:
    lengths = [math.inf] * len(ways.waypoints)
    find_lengths(goal.x / MM_PER_PIXEL, goal.y / MM_PER_PIXEL, lengths, pixel_walls(arena), ways)
    return lengths
