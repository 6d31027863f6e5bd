"""Distances to walls, and how much room there is at a place, against the geometry of polygons."""

import math

import pytest
import shapely
from hypothesis import given

from khepera_forage.geometry import polygon
from khepera_forage.geometry.plane import Wall, clearance, to_wall, wall_of, walls_of
from khepera_forage.geometry.polygon import Segment
from tests.geometry.shapes import PROPERTY, Enclosure, Place, enclosures, places, segments


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


@given(segments, places)
@PROPERTY
def test_to_wall_points_to_the_nearest_point_of_the_wall(segment: Segment, place: Place) -> None:
    wall = wall_of(segment)
    dx, dy = to_wall(*place, *wall[:5])
    assert math.hypot(dx, dy) == pytest.approx(polygon.distance(*place, segment), abs=1e-6)
    reached = place[0] + dx, place[1] + dy
    assert polygon.distance(*reached, segment) == pytest.approx(0.0, abs=1e-6)
