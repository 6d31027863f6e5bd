"""Paths through an arena, prepared once: waypoints around corners, and which parts of the floor cannot be reached.

The floor is shrunk by the room that a robot needs to turn with food in its gripper. What remains is where its centre
may drive. The waypoints are the corners of that region that point into it, and the visibility graph between them gives
all shortest paths. `geometry.paths` looks them up in every round.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from khepera_forage.geometry.paths import (
    CELLS,
    NO_CORNERS,
    ChosenWaypoint,
    Corner,
    PathTables,
    Spot,
    has_path,
    next_waypoint,
    shortest_length,
)
from khepera_forage.geometry.plane import wall_of
from khepera_forage.robots.khepera import FINGER_TIP
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.vision.scene import MM_PER_PIXEL

if TYPE_CHECKING:
    from shapely import Polygon

CLEARANCE = FINGER_TIP + 5.0
"""mm from a waypoint's path to walls: a robot can turn there, with food in its gripper."""
_PASSING = CLEARANCE - 7.5
"""mm at which a straight way must pass a corner: less, because the camera sees the robot beside its path."""
_BERTH = 20.0
"""mm by which waypoints past the home lie outside it."""
_SURE = 1e-3
"""Product of two distances from a line, in pixels, or of two areas, above which rounding does not change the sides."""
_ROUNDING = 0.01
"""mm by which a path may leave a region, along whose edges it runs."""
_FAR = Corner(1e9, 1e9, 0, 0)
"""Stands in no way: where there are corners, robots look for ways."""
_BLUNT = 1.1
"""Corners are cut off at this many clearances, so that robots pass diagonally between two of them."""


@lru_cache(maxsize=1 << 14)
def path_tables_of(arena: Arena) -> PathTables:
    """The path tables of an arena, in pixels; `NO_CORNERS` if neither a corner nor the home stands in any way."""
    corners = arena.corners
    if not corners and not _home_divides(arena):
        return NO_CORNERS
    floor = _shrunken_floor(arena)
    home = _octagon(arena.home, arena.home_radius + _BERTH)
    past_home = floor.difference(home)
    waypoints = _waypoints_of(floor, past_home, home)
    walls, (left, bottom, right, top) = pixel_walls(arena), arena.bounds
    home_x, home_y = arena.home.x / MM_PER_PIXEL, arena.home.y / MM_PER_PIXEL
    places, berth = waypoints[1] / MM_PER_PIXEL, (arena.home_radius + _BERTH) / MM_PER_PIXEL - 0.5
    paths = PathTables(
        _PASSING / MM_PER_PIXEL,
        home_x,
        home_y,
        berth,
        left / MM_PER_PIXEL,
        bottom / MM_PER_PIXEL,
        CELLS * MM_PER_PIXEL / (right - left),
        CELLS * MM_PER_PIXEL / (top - bottom),
        tuple(Corner(x / MM_PER_PIXEL, y / MM_PER_PIXEL, before, after) for x, y, before, after in corners) or (_FAR,),
        tuple(Spot(x, y) for x, y in places.tolist()),
        _in_pixels(shortest_lengths(waypoints, floor)),
        (),
        (),
    )
    paths = paths._replace(seen=_seen(paths, walls).tobytes())
    home_lengths = tuple(shortest_length(k, home_x, home_y, math.inf, False, walls, paths) for k in range(len(places)))
    lengths = shortest_lengths(waypoints, past_home)
    lengths[:, np.hypot(*(places - (home_x, home_y)).T) < berth] = np.inf
    return paths._replace(lengths=_in_pixels(lengths), home_lengths=home_lengths)


def _home_divides(arena: Arena) -> bool:
    """Whether the home reaches across an arena without corners, with floor on either side."""
    reach = arena.home_radius + _BERTH + CLEARANCE
    left, bottom, right, top = arena.bounds
    x, y = arena.home
    # Along x, and along y.
    beside = left < x - reach and x + reach < right, bottom < y - reach and y + reach < top
    across = x - reach <= left and right <= x + reach, y - reach <= bottom and top <= y + reach
    return (beside[0] and across[1]) or (beside[1] and across[0])


def _seen(paths: PathTables, walls: Sequence[Any]) -> Any:
    """Which waypoints may be seen from the cells of the grid: those that no wall hides from all of a cell.

    What a wall hides from a waypoint is convex: it hides a cell if it hides the corners of that cell. The array has the
    shape (cells + 1, waypoints); its last row is of what lies outside the grid.
    """
    steps = np.arange(CELLS + 1)
    x, y = np.meshgrid(paths.left + steps / paths.columns, paths.bottom + steps / paths.rows)
    x, y = x.reshape(-1, 1), y.reshape(-1, 1)
    to_x, to_y = np.reshape(paths.waypoints, (-1, 2)).T
    between = x * to_y - y * to_x
    seen = np.ones((CELLS * CELLS + 1, len(to_x)), np.bool_)
    for wall in walls:
        here = wall.normal_x * x + wall.normal_y * y - wall.offset
        there = wall.normal_x * to_x + wall.normal_y * to_y - wall.offset
        x2, y2 = wall.x1 + wall.ex, wall.y1 + wall.ey
        # On which sides of the line from a corner to a waypoint the ends of the wall are.
        first = between + (to_x * wall.y1 - to_y * wall.x1) - (x * wall.y1 - y * wall.x1)
        second = between + (to_x * y2 - to_y * x2) - (x * y2 - y * x2)
        hidden = (here * there < -_SURE) & (first * second < -_SURE)
        hidden = hidden.reshape(CELLS + 1, CELLS + 1, -1)
        rows = hidden[:-1] & hidden[1:]
        seen[:-1] &= ~(rows[:, :-1] & rows[:, 1:]).reshape(CELLS * CELLS, -1)
    return seen


def pixel_walls(arena: Arena) -> tuple[Any, ...]:
    """The walls of an arena as `geometry.plane.Wall` records in pixels."""
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
    paths, home, start = path_tables_of(arena), arena.home, arena.start
    if not paths.corners:
        return (x1 + x2) / 2, (y1 + y2) / 2
    here = Spot(home.x / MM_PER_PIXEL, home.y / MM_PER_PIXEL)
    there = Spot(start.x / MM_PER_PIXEL, start.y / MM_PER_PIXEL)
    x, y, _ = next_waypoint(*here, *there, True, ChosenWaypoint(), pixel_walls(arena), paths)
    return x * MM_PER_PIXEL, y * MM_PER_PIXEL


def is_home_free(arena: Arena) -> bool:
    """Whether a robot can leave the home on every side, and drive all the way round it."""
    return arena.clearance(arena.home) >= arena.home_radius + _BERTH + CLEARANCE


def shortest_path(arena: Arena, start: Point, goal: Point) -> tuple[Point, ...]:
    """The shortest path between two places, as a robot drives it: past the home, unless that is the goal.

    Args:
        arena: Where.
        start: In mm.
        goal: In mm.

    Returns:
        The start, the waypoints, and the goal, in mm.

    Raises:
        ValueError: There is none.
    """
    paths, walls = path_tables_of(arena), pixel_walls(arena)
    past_home = goal != arena.home
    end = Spot(goal.x / MM_PER_PIXEL, goal.y / MM_PER_PIXEL)
    here, path = Spot(start.x / MM_PER_PIXEL, start.y / MM_PER_PIXEL), [start]
    while here != end:
        x, y, length = next_waypoint(*here, *end, past_home, ChosenWaypoint(), walls, paths)
        if length == math.inf or len(path) > len(paths.waypoints) + 1:
            raise ValueError(
                f"{arena.name}: there is no way from ({start.x:g}, {start.y:g}) to ({goal.x:g}, {goal.y:g}) mm that is "
                f"{2 * CLEARANCE:g} mm wide{' and does not cross the home' if past_home else ''}"
            )
        here = Spot(x, y)
        path.append(goal if here == end else Point(x * MM_PER_PIXEL, y * MM_PER_PIXEL))
    return tuple(path)


def check_paths(arena: Arena) -> None:
    """Complain unless a robot can drive from the start to every food object past the home, and from there home.

    Args:
        arena: One arena.

    Raises:
        ValueError: It cannot; the message says what cannot be reached, and where the arena is too narrow.
    """
    foods = {f"food {k + 1}": food for k, food in enumerate(arena.foods)}
    start = Point(arena.start.x, arena.start.y)
    for name, place in {"the start": start, **foods}.items():
        if not _is_reachable(arena, place, arena.home, past_home=False):
            raise _unreachable(arena, name, place, "the home", arena.home, _narrow_places(arena))
    for name, place in foods.items():
        if not _is_reachable(arena, place, start, past_home=True):
            raise _unreachable(arena, name, place, "the start", start, " that does not cross the home")


def _is_reachable(arena: Arena, place: Point, goal: Point, past_home: bool) -> bool:
    ends = (place.x / MM_PER_PIXEL, place.y / MM_PER_PIXEL, goal.x / MM_PER_PIXEL, goal.y / MM_PER_PIXEL)
    return has_path(*ends, past_home, pixel_walls(arena), path_tables_of(arena))


def _unreachable(arena: Arena, name: str, place: Point, goal_name: str, goal: Point, why: str) -> ValueError:
    return ValueError(
        f"{arena.name}: there is no way between {name} at ({place.x:g}, {place.y:g}) mm and {goal_name} at "
        f"({goal.x:g}, {goal.y:g}) mm{why}; allowed: passages that are {2 * CLEARANCE:g} mm wide or more "
        "(`khepera-forage arena show` draws them)"
    )


def too_narrow(arena: Arena) -> list[tuple[Point, ...]]:
    """Where a robot cannot turn: narrow passages between parts of the floor, and dead ends.

    Returns:
        Polygons in mm.
    """
    import shapely

    if not arena.corners:
        return []
    floor, region = _floor(arena), _shrunken_floor(arena)
    rest = floor.difference(region.buffer(CLEARANCE * (1.0 + 1e-6)))
    # The rounded corners of the floor that remain are no dead ends.
    narrow = [part for part in getattr(rest, "geoms", [rest]) if part.area > CLEARANCE**2]
    for one, other in combinations(getattr(region, "geoms", [region]), 2):
        across = shapely.shortest_line(one, other)
        if floor.covers(across):
            narrow.append(across.buffer(CLEARANCE / 2).intersection(floor))
    return [tuple(Point(x, y) for x, y in shapely.get_coordinates(part.exterior)[:-1]) for part in narrow]


def _narrow_places(arena: Arena) -> str:
    places = []
    for corners in too_narrow(arena):
        xs, ys = [corner.x for corner in corners], [corner.y for corner in corners]
        places.append(f"({sum(xs) / len(xs):.0f}, {sum(ys) / len(ys):.0f})")
    return f"; it is too narrow near {', '.join(places)} mm" if places else ""


def _floor(arena: Arena) -> "Polygon":
    import shapely  # takes 0.1 s, which importing this package should not

    obstacles = shapely.union_all([shapely.Polygon(corners) for corners in arena.obstacles])
    floor: Polygon = shapely.Polygon(arena.walls).difference(obstacles)
    return floor


def _shrunken_floor(arena: Arena) -> Any:
    """Where the centre of a robot that turns on the spot may be: a polygon, or several."""
    return _floor(arena).buffer(-CLEARANCE, join_style="mitre", mitre_limit=_BLUNT)


def _octagon(centre: Point, radius: float) -> Any:
    """A regular octagon around a circle."""
    import shapely

    return shapely.Point(centre).buffer(radius / math.cos(math.pi / 8), quad_segs=2)


def _waypoints_of(floor: Any, past_home: Any, home: Any) -> Any:
    """The waypoints of paths past the home, and of those into it, as of `inward_corners`."""
    import shapely

    into = inward_corners(floor)
    return np.concatenate([inward_corners(past_home), into[:, shapely.contains_xy(home, into[1])]], axis=1)


def _in_pixels(lengths: Any) -> tuple[float, ...]:
    return tuple((lengths / MM_PER_PIXEL).ravel().tolist())


def inward_corners(region: Any) -> Any:
    """The corners that point into a region, with the corners before and after each.

    Args:
        region: A shapely polygon, or several.

    Returns:
        Shape (3, corners, 2): the corners before, the corners themselves, and the corners after.
    """
    return np.concatenate([_of_polygon(part) for part in getattr(region, "geoms", [region])], axis=1)


def shortest_lengths(waypoints: Any, region: Any) -> Any:
    """Lengths of the shortest paths between waypoints within a region.

    Args:
        waypoints: As of `inward_corners`.
        region: A shapely polygon, or several: where the paths run.

    Returns:
        Shape (waypoints, waypoints); infinite without a path.
    """
    import shapely
    from scipy.sparse.csgraph import shortest_path

    before, here, after = waypoints
    count = len(here)
    first, second = np.triu_indices(count, 1)
    # A shortest path touches each corner that it goes round: only such pairs can be part of one.
    touched = _is_touched(here[first], here[second], before[first], after[first]) & _is_touched(
        here[second], here[first], before[second], after[second]
    )
    first, second = first[touched], second[touched]
    lines = shapely.linestrings(np.stack([here[first], here[second]], axis=1))
    allowed = region.buffer(_ROUNDING, join_style="mitre")
    shapely.prepare(allowed)
    seen = shapely.covers(allowed, lines)
    graph = np.full((count, count), np.inf)
    graph[first[seen], second[seen]] = shapely.length(lines[seen])
    return shortest_path(graph, directed=False)


def _of_polygon(part: "Polygon") -> Any:
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


def path_length(path: Sequence[Point]) -> float:
    """Length of a path from waypoint to waypoint."""
    return sum(math.dist(*leg) for leg in pairwise(path))


def longest_path(arena: Arena) -> float:
    """Length of the shortest path from the home to the furthest place that a robot can reach and where it can turn."""
    import shapely

    # No place is further than the corners of this region.
    region = _floor(arena).buffer(-(CLEARANCE + 5.0), quad_segs=2)
    lengths = [0.0]
    for x, y in shapely.get_coordinates(region).tolist():
        with suppress(ValueError):  # a part of the floor without a way to the home
            lengths.append(path_length(shortest_path(arena, Point(x, y), arena.home)))
    return max(lengths)
