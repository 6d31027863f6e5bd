"""Polygons against brute force."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.geometry import polygon
from khepera_forage.geometry.polygon import Corner, Segment
from tests.geometry.shapes import PROPERTY, Place, places, radii_lists, segments, star


@given(segments, places)
@PROPERTY
def test_distance_is_that_to_the_nearest_of_many_points(segment: Segment, point: Place) -> None:
    x1, y1, x2, y2 = segment
    steps = 1000
    nearest = min(
        math.dist(point, (x1 + (x2 - x1) * i / steps, y1 + (y2 - y1) * i / steps)) for i in range(steps + 1)
    )
    spacing = math.dist((x1, y1), (x2, y2)) / steps
    assert nearest - spacing <= polygon.distance(*point, segment) <= nearest + 1e-9


@given(radii_lists)
@PROPERTY
def test_area_is_twice_the_area_and_positive_counter_clockwise(radii: list[float]) -> None:
    corners = star(radii)
    turn = 2 * math.pi / len(radii)
    twice = sum(a * b * math.sin(turn) for a, b in zip(radii, (*radii[1:], radii[0]), strict=True))
    assert polygon.area(corners) == pytest.approx(twice)
    assert polygon.area(corners[::-1]) == pytest.approx(-twice)


@given(radii_lists, st.integers(0, 8), st.booleans())
@PROPERTY
def test_check_accepts_simple_polygons_from_any_corner_in_both_directions(
    radii: list[float], first: int, clockwise: bool
) -> None:
    corners = star(radii)
    first %= len(corners)
    turned = (*corners[first:], *corners[:first])
    polygon.check("arena", turned[:: -1 if clockwise else 1])


U_SHAPE = ((0, 0), (600, 0), (600, 400), (400, 400), (400, 200), (200, 200), (200, 400), (0, 400))
COMB = ((0, 0), (700, 0), (700, 300), (500, 300), (500, 100), (300, 100), (300, 300), (0, 300))


@pytest.mark.parametrize("corners", [U_SHAPE, COMB, U_SHAPE[::-1], ((0, 0), (9, 0), (9, 9))])
def test_check_accepts_separate_walls_in_one_line(corners: tuple[Corner, ...]) -> None:
    polygon.check("arena", corners)


@pytest.mark.parametrize(
    ("corners", "complaint"),
    [
        (((0, 0), (100, 0)), "2 corners"),
        ((), "0 corners"),
        (((0, 0), (100, 0), (50, math.nan)), "nan"),
        (((0, 0), (math.inf, 0), (50, 50)), "inf"),
        (((0, 0), (100, 0), (200, 0)), "no area"),
        (((0, 0), (100, 100), (100, 0), (0, 100)), r"cross or touch at \(50, 50\)"),
        (((0, 0), (300, 0), (300, 300), (150, -50), (0, 300)), r"cross or touch at \(\S+, 0\)"),
        (
            ((0, 0), (300, 0), (300, 300), (150, 0), (0, 300)),
            r"cross or touch at \(150, 0\)",
        ),  # a corner
        (
            ((0, 0), (300, 0), (300, 0), (300, 300), (0, 300)),
            r"corner \(300, 0\) follows itself",
        ),  # a wall of no length
        (((0, 0), (300, 0), (300, 300), (0, 300), (0, 0)), r"corner \(0, 0\) follows itself"),
        (((0, 0), (300, 0), (300, 300), (300, 100), (300, 200), (0, 300)), "cross"),  # back on itself
    ],
)
def test_check_refuses_what_is_no_simple_polygon(corners: tuple[Corner, ...], complaint: str) -> None:
    with pytest.raises(ValueError, match=rf"arena.*({complaint})"):
        polygon.check("arena", corners)
