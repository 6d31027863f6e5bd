"""From scene and senses to raw data and state vector (4.2.2, 4.3)."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.sim.arena import Point
from khepera_forage.task.perception import own_region
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene
from tests.version_0_1 import RECTANGLE, V0_1

ENV = BehavioursEnv(arena="rectangle", foods=2, noise="none", decisions=V0_1)
FAR = (620.0, 40.0)
STARTS = st.tuples(st.floats(95, 500), st.floats(95, 505))
FOODS = st.tuples(st.floats(20, 430), st.floats(20, 580))  # outside the home


def place_at(start: tuple[float, float], degrees: float, distance: float) -> Point:
    """The place in a direction and at a distance."""
    x, y = start
    return Point(x + distance * math.cos(math.radians(degrees)), y + distance * math.sin(math.radians(degrees)))


@given(start=STARTS, degrees=st.integers(0, 359), food=FOODS)
def test_raw_data_and_state_vector_have_what_the_thesis_lists(
    start: tuple[float, float], degrees: int, food: tuple[float, float]
) -> None:
    """Distances are whole pixels of 5 mm."""
    nearest = min(math.dist(start, place) for place in (food, FAR))
    assume(nearest > 100 and math.dist(food, FAR) > 25)  # not hidden by the marker, and not on top of each other
    observation, _ = ENV.reset(seed=0, options={"start": (*start, degrees), "foods": [food, FAR]})
    raw, senses, home = ENV.forager.raw, ENV.forager.senses, RECTANGLE.home
    assert raw.proximity == senses.proximity[:6]
    assert (raw.arm, raw.jaw, raw.object_presence, raw.food_type, raw.tracked) == (215, 200, 0, 0, True)
    assert (raw.x * MM_PER_PIXEL, raw.y * MM_PER_PIXEL) == pytest.approx(start)
    assert (raw.orientation, raw.home_radius) == (degrees, 20)
    assert raw.wall_distance * MM_PER_PIXEL == pytest.approx(RECTANGLE.clearance(Point(*start)))
    wall = place_at(start, degrees + raw.wall_bearing, raw.wall_distance * MM_PER_PIXEL)
    assert RECTANGLE.clearance(wall) == pytest.approx(0, abs=1e-6)
    assert place_at(start, degrees + raw.home_bearing, math.dist(start, home)) == pytest.approx(home)
    seen = raw.food_x * MM_PER_PIXEL, raw.food_y * MM_PER_PIXEL
    assert place_at(start, degrees + raw.food_bearing, nearest) == pytest.approx(seen)
    assert all(-180 <= turn <= 180 for turn in (raw.wall_bearing, raw.home_bearing, raw.food_bearing))
    distances = observation["robot_home_distance"][0], observation["robot_food_distance"][0]
    assert distances == pytest.approx((math.dist(start, home) / MM_PER_PIXEL, nearest / MM_PER_PIXEL), abs=0.5001)
    assert (observation["object_presence"], observation["food_type"], *observation["arms_height"]) == (0, 0, 215)


def test_marker_that_was_never_seen_has_no_region() -> None:
    assert own_region(Scene(()), arena_map_of(RECTANGLE), 2) is None
