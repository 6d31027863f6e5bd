"""Distances to walls, and how much room there is at a place, against the geometry of polygons."""

import math

import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from khepera_forage.geometry import polygon
from khepera_forage.geometry.plane import Wall, clearance, to_wall, wall_of, walls_of
from khepera_forage.geometry.polygon import Segment
from tests.geometry.shapes import PROPERTY, Enclosure, Place, enclosures, places, segments, star

SQUARE = ((0.0, 0.0), (400.0, 0.0), (400.0, 400.0), (0.0, 400.0))
THROUGH_THE_WALL = ((300.0, 150.0), (600.0, 150.0), (600.0, 250.0), (300.0, 250.0))
"""An obstacle of which only a part stands in the square."""


def walls_in(enclosure: Enclosure) -> tuple[Wall, ...]:
    return walls_of(enclosure.polygons)


def nearest_side(enclosure: Enclosure, x: float, y: float) -> float:
    return min(
        polygon.distance(x, y, side) for corners in enclosure.polygons for side in polygon.edges(corners)
    )


def is_on_free_floor(enclosure: Enclosure, x: float, y: float) -> bool:
    inside = [shapely.contains_xy(shapely.Polygon(corners), x, y) for corners in enclosure.polygons]
    return inside[0] and not any(inside[1:])


def check_clearance(enclosure: Enclosure, x: float, y: float) -> None:
    distance = nearest_side(enclosure, x, y)
    expected = distance if is_on_free_floor(enclosure, x, y) else -distance
    assert clearance(x, y, walls_in(enclosure)) == pytest.approx(expected, rel=1e-9, abs=1e-6)


@given(enclosures, places)
@PROPERTY
def test_clearance_is_the_distance_to_the_nearest_side_and_negative_off_the_free_floor(
    enclosure: Enclosure, place: Place
) -> None:
    check_clearance(enclosure, *place)


@given(enclosures, st.floats(-600, 600), st.data())
@PROPERTY
def test_clearance_is_right_beside_a_corner(enclosure: Enclosure, x: float, data: st.DataObject) -> None:
    """A ray along the x axis then passes exactly through the corner, where one wall ends and another starts."""
    corners = [corner for corners in enclosure.polygons for corner in corners]
    check_clearance(enclosure, x, data.draw(st.sampled_from(corners))[1])


@given(st.lists(st.floats(20, 500), min_size=3, max_size=9), st.data())
@PROPERTY
def test_clearance_changes_its_sign_across_a_wall(radii: list[float], data: st.DataObject) -> None:
    corners = star(radii)
    walls = walls_of((corners,))
    wall = data.draw(st.sampled_from(walls))
    x, y = wall.x1 + wall.ex / 2, wall.y1 + wall.ey / 2
    step = 0.01
    assume(all(w is wall or math.hypot(*to_wall(x, y, *w[:5])) > 10 * step for w in walls))
    sides = [clearance(x + side * wall.normal_x, y + side * wall.normal_y, walls) for side in (-step, step)]
    assert sorted(sides) == pytest.approx([-step, step], abs=1e-6)


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        (100.0, 200.0, 100.0),
        (280.0, 200.0, 20.0),
        (350.0, 200.0, -50.0),
        (399.0, 200.0, -1.0),
        (450.0, 200.0, -50.0),
        (410.0, 50.0, -10.0),
        (350.0, 120.0, 30.0),
        (-30.0, 200.0, -30.0),
    ],
)
def test_clearance_is_negative_in_an_obstacle_that_reaches_through_the_outer_wall(
    x: float, y: float, expected: float
) -> None:
    assert clearance(x, y, walls_of((SQUARE, THROUGH_THE_WALL))) == pytest.approx(expected)


def test_clearance_is_negative_where_obstacles_overlap() -> None:
    """An even number of obstacles does not cancel out."""
    block = ((100.0, 100.0), (200.0, 100.0), (200.0, 200.0), (100.0, 200.0))
    shifted = tuple((x + 50.0, y) for x, y in block)
    walls = walls_of((SQUARE, block, shifted))
    assert clearance(175.0, 150.0, walls) == pytest.approx(-25.0)


@given(segments, places)
@PROPERTY
def test_to_wall_points_to_the_nearest_point_of_the_wall(segment: Segment, place: Place) -> None:
    wall = wall_of(segment)
    dx, dy = to_wall(*place, *wall[:5])
    assert math.hypot(dx, dy) == pytest.approx(polygon.distance(*place, segment), abs=1e-6)
    reached = place[0] + dx, place[1] + dy
    assert polygon.distance(*reached, segment) == pytest.approx(0.0, abs=1e-6)


@given(segments)
@PROPERTY
def test_wall_of_keeps_both_ends_length_and_line(segment: Segment) -> None:
    wall = wall_of(segment, polygon=2)
    x1, y1, x2, y2 = segment
    assert (wall.x1, wall.y1, wall.polygon) == (x1, y1, 2)
    assert (wall.x1 + wall.ex, wall.y1 + wall.ey) == pytest.approx((x2, y2))
    assert wall.share * math.dist((x1, y1), (x2, y2)) ** 2 == pytest.approx(1.0)
    assert (wall.normal_x, wall.normal_y, wall.offset) == polygon.line_of(segment)


@given(enclosures)
@PROPERTY
def test_walls_of_numbers_the_polygons_in_order(enclosure: Enclosure) -> None:
    walls = walls_in(enclosure)
    expected = [k for k, corners in enumerate(enclosure.polygons) for _ in corners]
    assert [wall.polygon for wall in walls] == expected
    assert [(wall.x1, wall.y1) for wall in walls] == [c for corners in enclosure.polygons for c in corners]
