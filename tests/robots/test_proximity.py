"""The infra-red model: response to distance, readings of walls and discs, and noise."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.geometry.plane import wall_of
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, FOOD_RADIUS
from khepera_forage.robots.model import KHEPERA
from khepera_forage.robots.proximity import HIDDEN_BY_ARM, MAX_READING, REACH, SENSORS
from khepera_forage.sim.records import FoodState, RobotState, constants_of
from khepera_forage.sim.sensing import sense
from khepera_forage.sim.world import Timing

PROPERTY = settings(derandomize=True, deadline=None, max_examples=200)
MIRRORED = (5, 4, 3, 2, 1, 0, 7, 6)
"""The sensor that mirrors each sensor across the robot's heading."""

Wall = tuple[float, float, float, float]
Disc = tuple[float, float, float]

near = st.floats(-120, 120)
walls = st.lists(st.tuples(near, near, near, near).filter(lambda w: math.dist(w[:2], w[2:]) > 1.0), max_size=4)
discs = st.lists(st.tuples(near, near, st.sampled_from([17.5, 27.5])), max_size=3)
angles = st.floats(-math.pi, math.pi)


def sensed(
    walls: list[Wall],
    discs: list[Disc],
    heading: float = 0,
    noise: Noise | None = None,
    arm: float = ARM_RAISED,
    key: int = 0,
) -> RobotState:
    """A robot at (0, 0) that has sensed walls, food and other robots."""
    state = RobotState(0.0, 0.0, heading, math.cos(heading), math.sin(heading), arm=arm, key=key)
    robots = [state, *(RobotState(x, y) for x, y, radius in discs if radius != FOOD_RADIUS)]
    foods = [FoodState(x, y) for x, y, radius in discs if radius == FOOD_RADIUS]
    constants = constants_of(noise or Noise.none(), Timing(0.1, 0.0, 0.0), KHEPERA)
    sense(robots, 0, foods, list(map(wall_of, walls)), constants)
    return state


def read(walls: list[Wall], discs: list[Disc], heading: float = 0) -> list[float]:
    """Its readings without noise."""
    return sensed(walls, discs, heading).response


def facing_wall(sensor: int, distance: float) -> Wall:
    """A wall perpendicular to a sensor's axis."""
    forward, left, cosine, sine = SENSORS[sensor]
    x, y = forward + distance * cosine, left + distance * sine
    return x - 200 * sine, y + 200 * cosine, x + 200 * sine, y - 200 * cosine


def response(distance: float) -> float:
    """What a sensor reads of a wall before it."""
    return read([facing_wall(0, distance)], [])[0]


@given(st.floats(0.1, 200), st.floats(0.1, 200))
@PROPERTY
def test_response_never_decreases_with_nearness(a: float, b: float) -> None:
    assert response(min(a, b)) >= response(max(a, b)) - 1e-9, "but for rounding"


@pytest.mark.parametrize(("distance", "white_paper"), [(20, 450), (30, 275), (40, 190), (50, 150)])
def test_response_follows_the_white_paper_curve(distance: float, white_paper: float) -> None:
    # The curve reads 125 at 60 mm, where the readings of a Khepera I end. 40 counts is a tenth of its 450.
    assert response(distance) == pytest.approx(white_paper - 125, abs=41)


@given(angles, st.floats(REACH + 0.1, 500), st.sampled_from([17.5, 27.5]))
@PROPERTY
def test_readings_of_discs_beyond_reach_are_zero(bearing: float, distance: float, radius: float) -> None:
    x, y = (distance + radius) * math.cos(bearing), (distance + radius) * math.sin(bearing)
    assert read([], [(x, y, radius)]) == [0.0] * 8


@given(st.integers(0, 7), st.floats(0, 60), st.floats(25, 50))
@PROPERTY
def test_reading_decreases_off_axis_to_zero_at_60_degrees(sensor: int, off: float, distance: float) -> None:
    forward, left, cosine, sine = SENSORS[sensor]

    def at(degrees: float) -> float:
        angle = math.atan2(sine, cosine) + math.radians(degrees)
        food = forward + distance * math.cos(angle), left + distance * math.sin(angle), FOOD_RADIUS
        return read([], [food])[sensor]

    assert at(off) >= at(off + 5) - 1e-9
    assert at(-off) == pytest.approx(at(off))
    assert at(59) > at(60.1) == at(-60.1) == at(180) == 0
    assert at(0) == pytest.approx(response(distance - FOOD_RADIUS))


@given(walls, discs, angles)
@PROPERTY
def test_mirrored_scene_gives_mirrored_readings(walls: list[Wall], discs: list[Disc], heading: float) -> None:
    original = read(walls, discs, heading)
    mirrored_walls = [(x1, -y1, x2, -y2) for x1, y1, x2, y2 in walls]
    mirrored = read(mirrored_walls, [(x, -y, r) for x, y, r in discs], -heading)
    assert [mirrored[i] for i in MIRRORED] == pytest.approx(original, abs=1e-6)


@given(walls, discs)
@PROPERTY
def test_largest_response_counts(walls: list[Wall], discs: list[Disc]) -> None:
    alone = [read([wall], []) for wall in walls] + [read([], [disc]) for disc in discs]
    together = read(walls, discs)
    expected = [max((readings[i] for readings in alone), default=0.0) for i in range(8)]
    assert together == pytest.approx(expected, abs=1e-9)


def test_obstacles_on_top_of_a_sensor_give_finite_readings() -> None:
    forward, left, _, _ = SENSORS[2]
    assert all(math.isfinite(v) for v in read([(forward, left, forward, left + 50)], [(forward, left, 17.5)]))


@given(st.integers(0, 2**63), st.booleans(), walls, discs)
@PROPERTY
def test_noise_stays_within_its_limits(key: int, arm_down: bool, walls: list[Wall], discs: list[Disc]) -> None:
    arm = ARM_DOWN if arm_down else ARM_RAISED
    robot = sensed(walls, discs, noise=Noise.only("infra-reds"), arm=arm, key=key)
    quiet = sensed(walls, discs, arm=arm)
    for i, clean in enumerate(robot.response):
        reading, exact = robot.senses.proximity[i], quiet.senses.proximity[i]
        assert type(reading) is int
        if arm_down and i < 6:
            assert HIDDEN_BY_ARM[0] <= reading <= HIDDEN_BY_ARM[1]
            assert HIDDEN_BY_ARM[0] <= exact <= HIDDEN_BY_ARM[1]
            continue
        assert exact == math.floor(clean), "rounded down"
        if clean <= 5:
            assert 0 <= reading <= 6
        else:
            assert clean * 0.9 - 7 <= reading <= min(clean * 1.1, MAX_READING)
