"""Reading walls and corners, which are those of the arena, or in lists (`near_walls`) if worlds are in several arenas.

A field of a wall is a number in the first case, and has one number for each lane in the second. Functions with a
`variant` are for the first case, the variants for the second.
"""

from typing import Any, NamedTuple

from khepera_forage.compilation.decorators import inline, types, variant
from khepera_forage.compilation.packing import pack
from khepera_forage.sim.arena import Point
from khepera_forage.sim.compiled.near_walls import most_listed, several
from khepera_forage.sim.compiled.parameters import Parameters


class ListedWall(NamedTuple):
    """A wall in the list of one world: the fields of `wall_dtype`."""

    x1: float
    y1: float
    ex: float
    ey: float
    share: float
    normal_x: float
    normal_y: float
    offset: float


def _over_lanes(value: Any) -> bool:
    return isinstance(value, types.Array)


def _are_listed(records: Any) -> bool:
    return all(_over_lanes(kind) for _, kind in records.dtype.members)


def at(value: Any, i: int) -> Any:
    """The number of one lane, of a field of a wall or corner."""
    return value


@variant(at, _over_lanes)
def _at(value: Any, i: int) -> Any:
    return value[i]


def walls_beside(near: Any, parameters: Parameters, i: int) -> tuple[Any, Any]:
    """All walls and corners that one robot can touch, which `wall_in` and `corner_in` read."""
    return parameters.walls, parameters.corners


@variant(walls_beside, several)
def _walls_beside(near: Any, parameters: Parameters, i: int) -> tuple[Any, Any]:
    lists = near.lists[0]
    return near.walls[: lists.walls[i]], near.corners[: lists.corners[i]]


def wall_in(walls: Any, j: int, i: int) -> Any:
    """Wall number j of one lane."""
    return walls[j]


@variant(wall_in, _are_listed)
def _wall_in(walls: Any, j: int, i: int) -> ListedWall:
    wall = walls[j]
    return ListedWall(
        wall.x1[i],
        wall.y1[i],
        wall.ex[i],
        wall.ey[i],
        wall.share[i],
        wall.normal_x[i],
        wall.normal_y[i],
        wall.offset[i],
    )


def corner_in(corners: Any, j: int, i: int) -> Any:
    """Corner number j of one lane."""
    return corners[j]


@variant(corner_in, _are_listed)
def _corner_in(corners: Any, j: int, i: int) -> Point:
    return Point(corners[j].x[i], corners[j].y[i])


def pack_near_wall(near: Any, scratch: Any) -> int:
    """Pack the lanes with a wall near; returns how many. Those with the longest lists come first."""
    return int(pack(scratch.near_wall, scratch.lane, 0))


@variant(pack_near_wall, several)
def _pack_near_wall(near: Any, scratch: Any) -> int:
    return _pack_longest_first(near.lists[0].walls, scratch.near_wall, scratch)


def pack_near_corner(near: Any, scratch: Any) -> int:
    """Pack the lanes with a corner near; returns how many. Those with the longest lists come first."""
    for i in range(scratch.lane.shape[0]):
        scratch.lane[i] = i
    return int(scratch.lane.shape[0])


@variant(pack_near_corner, several)
def _pack_near_corner(near: Any, scratch: Any) -> int:
    return _pack_longest_first(near.lists[0].corners, 1.0, scratch)


@inline
def _pack_longest_first(counts: Any, marks: Any, scratch: Any) -> int:
    """Pack the marked lanes with something in their lists, the longest lists first; returns the number of lanes."""
    count = 0
    for listed in range(most_listed(counts), 0, -1):
        for i in range(scratch.lane.shape[0]):
            scratch.marked[i] = at(marks, i) if counts[i] == listed else 0.0
        count = pack(scratch.marked, scratch.lane, count)
    return count


def with_wall(near: Any, scratch: Any, count: int, j: int) -> int:
    """How many of the first `count` packed lanes have a wall number j: they come first."""
    return count


@variant(with_wall, several)
def _with_wall(near: Any, scratch: Any, count: int, j: int) -> int:
    return _with_entry(near.lists[0].walls, scratch, count, j)


def with_corner(near: Any, scratch: Any, count: int, j: int) -> int:
    """How many of the first `count` packed lanes have a corner number j: they come first."""
    return count


@variant(with_corner, several)
def _with_corner(near: Any, scratch: Any, count: int, j: int) -> int:
    return _with_entry(near.lists[0].corners, scratch, count, j)


@inline
def _with_entry(counts: Any, scratch: Any, count: int, j: int) -> int:
    while count > 0 and counts[scratch.lane[count - 1]] <= j:
        count -= 1
    return count


def packed_wall(
    near: Any, wall: Any, scratch: Any, count: int
) -> tuple[Any, Any, Any, Any, Any, Any, Any, Any]:
    """The fields of a wall, as `at` reads them for packed lanes: those of `wall_dtype`, in their order.

    Packed lanes behind the first `count`, which have no such wall, keep the last wall of their lists. A loop that
    rounds `count` up looks at that wall once more.
    """
    return wall.x1, wall.y1, wall.ex, wall.ey, wall.share, wall.normal_x, wall.normal_y, wall.offset


@variant(packed_wall, several)
def _packed_wall(
    near: Any, wall: Any, scratch: Any, count: int
) -> tuple[Any, Any, Any, Any, Any, Any, Any, Any]:
    for n in range(count):
        i = scratch.lane[n]
        scratch.wall_x1[n], scratch.wall_y1[n] = wall.x1[i], wall.y1[i]
        scratch.wall_ex[n], scratch.wall_ey[n] = wall.ex[i], wall.ey[i]
        scratch.wall_share[n], scratch.wall_offset[n] = wall.share[i], wall.offset[i]
        scratch.wall_normal_x[n], scratch.wall_normal_y[n] = wall.normal_x[i], wall.normal_y[i]
    return (
        scratch.wall_x1,
        scratch.wall_y1,
        scratch.wall_ex,
        scratch.wall_ey,
        scratch.wall_share,
        scratch.wall_normal_x,
        scratch.wall_normal_y,
        scratch.wall_offset,
    )


def packed_corner(near: Any, corner: Any, scratch: Any, count: int) -> tuple[Any, Any]:
    """The place of a corner, as `at` reads it for packed lanes; the other lanes keep theirs, as in `packed_wall`."""
    return corner.x, corner.y


@variant(packed_corner, several)
def _packed_corner(near: Any, corner: Any, scratch: Any, count: int) -> tuple[Any, Any]:
    for n in range(count):
        i = scratch.lane[n]
        scratch.corner_x[n], scratch.corner_y[n] = corner.x[i], corner.y[i]
    return scratch.corner_x, scratch.corner_y


def packed_share(value: Any, scratch: Any, count: int) -> tuple[Any]:
    """The field `share` of a wall, as `at` reads it for packed lanes; alone in a tuple."""
    return (value,)


@variant(packed_share, _over_lanes)
def _packed_share(value: Any, scratch: Any, count: int) -> tuple[Any]:
    for n in range(count):
        scratch.wall_share[n] = value[scratch.lane[n]]
    return (scratch.wall_share,)
