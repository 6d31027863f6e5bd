"""Angles and lengths in the plane."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.geometry.plane import bearing_of, cosine_sine, length, turn_to
from tests.geometry.shapes import PROPERTY

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
    cosine, sine_ = cosine_sine(math.radians(degrees))
    assert bearing_of(distance * cosine, distance * sine_) == pytest.approx(degrees, abs=1e-9)
    assert length(distance * cosine, distance * sine_) == pytest.approx(distance)
