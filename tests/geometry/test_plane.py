"""Distances to walls, against shapely."""

import pytest
import shapely
from hypothesis import given

from khepera_forage.geometry.plane import clearance, walls_of
from tests.geometry.shapes import PROPERTY, Enclosure, Place, enclosures, places


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
