"""The infra-reds: how they answer to distance, and what they see of walls and discs."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.robots.khepera import RADIUS
from khepera_forage.robots.proximity import (
    HIDDEN_BY_ARM,
    MAX_READING,
    RANGE,
    REACH,
    SENSORS,
    cast,
    measured,
    response,
)

PROPERTY = settings(derandomize=True, deadline=None, max_examples=200)
MIRRORED = (5, 4, 3, 2, 1, 0, 7, 6)
"""Which sensor stands where another stands in a mirror held along the heading."""

Wall = tuple[float, float, float, float]
Disc = tuple[float, float, float]

near = st.floats(-120, 120)
walls = st.lists(
    st.tuples(near, near, near, near).filter(lambda w: math.dist(w[:2], w[2:]) > 1.0), max_size=4
)
discs = st.lists(st.tuples(near, near, st.sampled_from([17.5, 27.5])), max_size=3)
angles = st.floats(-math.pi, math.pi)


def read(walls: list[Wall], discs: list[Disc], x: float = 0, y: float = 0, heading: float = 0) -> list[float]:
    return cast(x, y, math.cos(heading), math.sin(heading), walls, discs)


def ahead_of(sensor: int, distance: float) -> tuple[float, float]:
    """The place that far from a sensor, on its axis."""
    forward, left, cosine, sine = SENSORS[sensor]
    return forward + distance * cosine, left + distance * sine


def facing_wall(sensor: int, distance: float) -> Wall:
    """A wall square to a sensor's axis."""
    _, _, cosine, sine = SENSORS[sensor]
    x, y = ahead_of(sensor, distance)
    return x - 200 * sine, y + 200 * cosine, x + 200 * sine, y - 200 * cosine


# ---------------------------------------------------------------- response


@given(st.floats(-10, 200), st.floats(-10, 200))
@PROPERTY
def test_what_is_nearer_never_reads_less(a: float, b: float) -> None:
    assert response(min(a, b)) >= response(max(a, b))


@given(st.floats(8.0, 59.0))
@PROPERTY
def test_within_the_fall_nearer_reads_more(distance: float) -> None:
    assert response(distance) > response(distance + 1.0) or response(distance + 1.0) == MAX_READING


@pytest.mark.parametrize("distance", [-1.0, 0.0, 2.0, 8.0])
def test_contact_reads_full(distance: float) -> None:
    assert response(distance) == MAX_READING


@pytest.mark.parametrize("distance", [RANGE, 60.1, 100.0, 1e6])
def test_beyond_range_nothing(distance: float) -> None:
    assert response(distance) == 0


@pytest.mark.parametrize(("distance", "white_paper"), [(20, 450), (30, 275), (40, 190), (50, 150)])
def test_close_to_the_white_paper_curve_less_its_value_at_the_end_of_the_range(
    distance: float, white_paper: float
) -> None:
    # The curve reads 125 at 60 mm, where the readings of a Khepera I end. 40 counts is a tenth of its 450.
    assert response(distance) == pytest.approx(white_paper - 125, abs=41)


# ---------------------------------------------------------------- cast


def test_nothing_in_range_reads_zero() -> None:
    assert read([], []) == [0.0] * 8
    assert read([(200, -500, 200, 500)], [(0, 150, 17.5), (-120, -10, 17.5)]) == [0.0] * 8


@given(angles, st.floats(REACH + 0.1, 500), st.sampled_from([17.5, 27.5]))
@PROPERTY
def test_beyond_the_reach_nothing_is_seen(bearing: float, distance: float, radius: float) -> None:
    x, y = (distance + radius) * math.cos(bearing), (distance + radius) * math.sin(bearing)
    assert read([], [(x, y, radius)]) == [0.0] * 8


@pytest.mark.parametrize("sensor", range(8))
@pytest.mark.parametrize("distance", [5.0, 20.0, 45.0])
def test_the_sensor_that_faces_a_wall_reads_its_distance(sensor: int, distance: float) -> None:
    readings = read([facing_wall(sensor, distance)], [])
    assert readings[sensor] == pytest.approx(response(distance))
    # All that look away from it see nothing.
    _, _, cosine, sine = SENSORS[sensor]
    for other, reading in zip(SENSORS, readings, strict=True):
        if other[2] * cosine + other[3] * sine < math.cos(math.radians(65)):
            assert reading == 0


@pytest.mark.parametrize("sensor", range(8))
@pytest.mark.parametrize("distance", [5.0, 30.0, 55.0])
def test_the_sensor_that_points_at_a_disc_sees_its_rim(sensor: int, distance: float) -> None:
    x, y = ahead_of(sensor, distance + 17.5)
    readings = read([], [(x, y, 17.5)])
    assert readings[sensor] == pytest.approx(response(distance))
    assert readings[sensor] > 0
    assert readings[sensor] == max(readings)


@given(st.integers(0, 7), st.floats(0, 60), st.floats(25, 50))
@PROPERTY
def test_a_disc_further_off_the_axis_reads_less_and_beyond_60_degrees_nothing(
    sensor: int, off: float, distance: float
) -> None:
    forward, left, cosine, sine = SENSORS[sensor]
    pointing = math.atan2(sine, cosine)

    def at(degrees: float) -> float:
        angle = pointing + math.radians(degrees)
        return read([], [(forward + distance * math.cos(angle), left + distance * math.sin(angle), 17.5)])[
            sensor
        ]

    assert at(off) >= at(off + 5) - 1e-9
    assert at(-off) == pytest.approx(at(off))
    assert at(60.1) == at(-60.1) == at(180) == 0
    assert at(0) == pytest.approx(response(distance - 17.5))


@given(walls, discs, angles)
@PROPERTY
def test_a_mirrored_scene_gives_mirrored_readings(
    walls: list[Wall], discs: list[Disc], heading: float
) -> None:
    there = read(walls, discs, heading=heading)
    mirrored = read(
        [(x1, -y1, x2, -y2) for x1, y1, x2, y2 in walls], [(x, -y, r) for x, y, r in discs], heading=-heading
    )
    assert [mirrored[i] for i in MIRRORED] == pytest.approx(there, abs=1e-6)


@given(walls, discs, angles, st.floats(-2000, 2000), st.floats(-2000, 2000))
@PROPERTY
def test_only_what_lies_where_from_the_robot_counts(
    walls: list[Wall], discs: list[Disc], turn: float, dx: float, dy: float
) -> None:
    c, s = math.cos(turn), math.sin(turn)

    def move(x: float, y: float) -> tuple[float, float]:
        return dx + x * c - y * s, dy + x * s + y * c

    moved = read(
        [(*move(x1, y1), *move(x2, y2)) for x1, y1, x2, y2 in walls],
        [(*move(x, y), r) for x, y, r in discs],
        dx,
        dy,
        turn,
    )
    assert moved == pytest.approx(read(walls, discs), abs=0.05)


@given(walls, discs)
@PROPERTY
def test_the_largest_answer_counts(walls: list[Wall], discs: list[Disc]) -> None:
    alone = [read([wall], []) for wall in walls] + [read([], [disc]) for disc in discs]
    together = read(walls, discs)
    expected = [max((readings[i] for readings in alone), default=0.0) for i in range(8)]
    assert together == pytest.approx(expected, abs=1e-9)


@given(walls, discs, st.tuples(near, near, st.just(17.5)))
@PROPERTY
def test_another_obstacle_never_lowers_a_reading(walls: list[Wall], discs: list[Disc], extra: Disc) -> None:
    before, after = read(walls, discs), read(walls, [*discs, extra])
    assert all(a >= b for a, b in zip(after, before, strict=True))


@given(walls, discs)
@PROPERTY
def test_readings_stay_in_range(walls: list[Wall], discs: list[Disc]) -> None:
    assert all(0 <= reading <= MAX_READING for reading in read(walls, discs))


def test_a_wall_on_a_sensor_and_a_disc_over_it_are_no_trouble() -> None:
    forward, left, _, _ = SENSORS[2]
    assert all(math.isfinite(v) for v in read([(forward, left, forward, left + 50)], [(forward, left, 17.5)]))


def test_sensors_before_the_first_stay_dark() -> None:
    wall, behind = (RADIUS + 10, -200, RADIUS + 10, 200), (-RADIUS - 10, -200, -RADIUS - 10, 200)
    readings = cast(0, 0, 1, 0, [wall, behind], [], first=6)
    assert readings[:6] == [0.0] * 6
    assert min(readings[6:]) > 0


# ---------------------------------------------------------------- measured

EIGHT = (0.0, 3.0, 100.0, 500.0, 1023.0, 7.0, 100.0, 900.0)
uniform = st.lists(st.floats(0, 0.999999), min_size=8, max_size=8)


def test_without_noise_readings_are_what_is_there() -> None:
    assert measured(EIGHT, False, 0.0, 0, [0.9] * 8) == (0, 3, 100, 500, 1023, 7, 100, 900)


@given(uniform, st.booleans())
@PROPERTY
def test_noise_stays_within_its_size(draws: list[float], arm_down: bool) -> None:
    readings = measured(EIGHT, arm_down, 0.1, 6, draws)
    for i, (reading, clean) in enumerate(zip(readings, EIGHT, strict=True)):
        assert type(reading) is int
        if arm_down and i < 6:
            assert HIDDEN_BY_ARM[0] <= reading <= HIDDEN_BY_ARM[1]
        elif clean <= 5:
            assert 0 <= reading <= 6
        else:
            assert clean * 0.9 - 7 <= reading <= min(clean * 1.1, MAX_READING)


def test_noise_reaches_its_size() -> None:
    low, high = (measured([500.0] * 8, False, 0.1, 6, [u] * 8) for u in (0.0, 0.999999))
    assert low[0] == 450
    assert high[0] == 549
    floor = {measured([0.0] * 8, False, 0.1, 6, [u / 70] * 8)[0] for u in range(70)}
    assert floor == set(range(7))
