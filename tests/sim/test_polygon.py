"""Plane geometry of walls against brute force."""

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from khepera_forage.geometry import polygon
from khepera_forage.geometry.polygon import Corner, Segment

PROPERTY = settings(derandomize=True, deadline=None, max_examples=150)

ring = st.lists(st.floats(20, 500), min_size=3, max_size=9)
place = st.tuples(st.floats(-600, 600), st.floats(-600, 600))
segments = st.tuples(place, place).filter(lambda s: math.dist(*s) > 1).map(lambda s: (*s[0], *s[1]))


def star(radii: list[float]) -> tuple[Corner, ...]:
    """A simple polygon about (0, 0), mostly not convex."""
    n = len(radii)
    return tuple(
        (r * math.cos(2 * math.pi * i / n), r * math.sin(2 * math.pi * i / n)) for i, r in enumerate(radii)
    )


def winding(corners: tuple[Corner, ...], x: float, y: float) -> float:
    """How often the walls run round a place: the sum of the angles under which it sees them, in turns."""
    total = 0.0
    for (x1, y1), (x2, y2) in zip(corners, (*corners[1:], corners[0]), strict=True):
        ax, ay, bx, by = x1 - x, y1 - y, x2 - x, y2 - y
        total += math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    return total / (2 * math.pi)


@given(ring, place, st.booleans())
@PROPERTY
def test_inside_is_where_the_walls_run_round(
    radii: list[float], point: tuple[float, float], clockwise: bool
) -> None:
    corners = star(radii)[:: -1 if clockwise else 1]
    assume(min(polygon.distance(*point, side) for side in polygon.edges(corners)) > 1e-6)
    assert polygon.contains(corners, *point) == (abs(winding(corners, *point)) > 0.5)


@given(segments, place)
@PROPERTY
def test_distance_is_that_of_the_nearest_of_many_points(segment: Segment, point: tuple[float, float]) -> None:
    x1, y1, x2, y2 = segment
    steps = 1000
    nearest = min(
        math.dist(point, (x1 + (x2 - x1) * i / steps, y1 + (y2 - y1) * i / steps)) for i in range(steps + 1)
    )
    spacing = math.dist((x1, y1), (x2, y2)) / steps
    assert nearest - spacing <= polygon.distance(*point, segment) <= nearest + 1e-9


@given(segments, place)
@PROPERTY
def test_a_line_is_never_further_than_its_segment(segment: Segment, point: tuple[float, float]) -> None:
    normal_x, normal_y, offset = polygon.line_of(segment)
    assert math.hypot(normal_x, normal_y) == pytest.approx(1)
    for x, y in (segment[:2], segment[2:]):
        assert normal_x * x + normal_y * y == pytest.approx(offset, abs=1e-6)
    off = abs(normal_x * point[0] + normal_y * point[1] - offset)
    assert off <= polygon.distance(*point, segment) + 1e-6


@given(ring)
@PROPERTY
def test_area_is_positive_counter_clockwise_and_twice_the_area(radii: list[float]) -> None:
    corners = star(radii)
    turn = 2 * math.pi / len(radii)
    twice = sum(a * b * math.sin(turn) for a, b in zip(radii, (*radii[1:], radii[0]), strict=True))
    assert polygon.area(corners) == pytest.approx(twice)
    assert polygon.area(corners[::-1]) == pytest.approx(-twice)


@given(ring)
@PROPERTY
def test_sides_close_the_ring_and_bounds_hold_all_corners(radii: list[float]) -> None:
    corners = star(radii)
    sides = polygon.edges(corners)
    assert len(sides) == len(corners)
    assert all(a[2:] == b[:2] for a, b in zip(sides, (*sides[1:], sides[0]), strict=True))
    x1, y1, x2, y2 = polygon.bounds(corners)
    assert {x1, x2} <= {c[0] for c in corners}
    assert {y1, y2} <= {c[1] for c in corners}
    assert all(x1 <= x <= x2 and y1 <= y <= y2 for x, y in corners)


@given(ring, st.integers(0, 8), st.booleans())
@PROPERTY
def test_simple_polygons_are_accepted_from_any_corner_either_way_round(
    radii: list[float], first: int, clockwise: bool
) -> None:
    corners = star(radii)
    first %= len(corners)
    turned = (*corners[first:], *corners[:first])
    polygon.check("arena", turned[:: -1 if clockwise else 1])


U_SHAPE = ((0, 0), (600, 0), (600, 400), (400, 400), (400, 200), (200, 200), (200, 400), (0, 400))
COMB = ((0, 0), (700, 0), (700, 300), (500, 300), (500, 100), (300, 100), (300, 300), (0, 300))


@pytest.mark.parametrize("corners", [U_SHAPE, COMB, U_SHAPE[::-1], ((0, 0), (9, 0), (9, 9))])
def test_walls_in_one_line_do_not_cross_unless_they_meet(corners: tuple[Corner, ...]) -> None:
    polygon.check("arena", corners)


@pytest.mark.parametrize(
    ("corners", "complaint"),
    [
        (((0, 0), (100, 0)), "2 corners"),
        ((), "0 corners"),
        (((0, 0), (100, 0), (50, math.nan)), "nan"),
        (((0, 0), (math.inf, 0), (50, 50)), "inf"),
        (((0, 0), (100, 0), (200, 0)), "no area"),
        (((0, 0), (100, 100), (100, 0), (0, 100)), "no area|cross"),
        (((0, 0), (300, 0), (300, 300), (100, -50), (0, 300)), "cross"),
        (((0, 0), (300, 0), (300, 300), (150, 0), (0, 300)), "cross"),  # a corner on another wall
        (((0, 0), (300, 0), (300, 0), (300, 300), (0, 300)), "cross|corner"),  # a wall of no length
        (((0, 0), (300, 0), (300, 300), (0, 300), (0, 0)), "cross|corner"),
        (((0, 0), (300, 0), (300, 300), (300, 100), (300, 200), (0, 300)), "cross"),  # back on itself
    ],
)
def test_what_is_no_simple_polygon_is_refused(corners: tuple[Corner, ...], complaint: str) -> None:
    with pytest.raises(ValueError, match=rf"arena.*({complaint})"):
        polygon.check("arena", corners)
