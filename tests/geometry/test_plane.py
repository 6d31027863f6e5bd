"""Angles, lengths and distances to walls in the plane, against trigonometry and shapely."""

import math

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.geometry.plane import (
    bearing_of,
    clearance,
    cosine_sine,
    length,
    to_wall,
    turn_to,
    wall_of,
    walls_of,
)
from khepera_forage.geometry.polygon import Segment
from tests.geometry.shapes import PROPERTY, Enclosure, Place, enclosures, places, segments

DEGREES = st.floats(-720, 720)


@given(direction=DEGREES, orientation=DEGREES)
@PROPERTY
def test_turn_to_is_the_short_way(direction: float, orientation: float) -> None:
    turn = turn_to(direction, orientation)
    assert -180.0 <= turn <= 180.0
    assert math.cos(math.radians(orientation + turn - direction)) == pytest.approx(1.0)


@given(degrees=st.floats(-179, 179), distance=st.floats(0.1, 1000))
@PROPERTY
def test_bearing_and_length_are_the_polar_coordinates_of_a_vector(degrees: float, distance: float) -> None:
    cosine, sine = cosine_sine(math.radians(degrees))
    assert bearing_of(distance * cosine, distance * sine) == pytest.approx(degrees, abs=1e-9)
    assert length(distance * cosine, distance * sine) == pytest.approx(distance)


@given(enclosures, places)
@PROPERTY
def test_clearance_is_the_distance_to_the_nearest_side_and_negative_off_the_free_floor(
    enclosure: Enclosure, place: Place
) -> None:
    outer, *obstacles = map(shapely.Polygon, enclosure.polygons)
    here = shapely.Point(place)
    distance = min(shape.exterior.distance(here) for shape in (outer, *obstacles))
    free = outer.contains(here) and not any(shape.contains(here) for shape in obstacles)
    found = clearance(*place, walls_of(enclosure.polygons))
    assert found == pytest.approx(distance if free else -distance, rel=1e-9, abs=1e-6)


@given(segments, places)
@PROPERTY
def test_to_wall_points_to_the_nearest_point_of_the_wall(segment: Segment, place: Place) -> None:
    line = shapely.LineString((segment[:2], segment[2:]))
    dx, dy = to_wall(*place, wall_of(segment))
    assert math.hypot(dx, dy) == pytest.approx(line.distance(shapely.Point(place)), abs=1e-6)
    assert line.distance(shapely.Point(place[0] + dx, place[1] + dy)) == pytest.approx(0.0, abs=1e-6)
