"""Bodies and camera of a batch against those of `PymunkWorld`, and what must hold of any simulation."""

import math
from typing import Any

import numba
import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import (
    ARM_RAISED,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    RADIUS,
    Motors,
    half_gap,
)
from khepera_forage.robots.proximity import clean_readings
from khepera_forage.sim.arena import CORRIDOR, RECTANGLE, Arena, Point, Pose
from khepera_forage.sim.compiled import BatchWorld
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.vision.association import Detection, Tracks
from khepera_forage.vision.shapes import Plate, under_plate

HALL = Arena(
    name="hall",
    walls=(Point(0, 0), Point(2300, 0), Point(2300, 2300), Point(0, 2300)),
    home=Point(1150, 1150),
    home_radius=100,
    start=Pose(1150, 1150, 0),
    foods=(Point(100, 100),),
)
PILLAR = Arena(
    name="pillar",
    walls=RECTANGLE.walls,
    home=RECTANGLE.home,
    home_radius=90,
    start=RECTANGLE.start,
    foods=RECTANGLE.foods,
    obstacles=((Point(300, 280), Point(340, 300), Point(300, 320)),),
)


def test_free_driving_is_that_of_pymunk_to_rounding() -> None:
    rng = np.random.default_rng(0)
    single, batch = PymunkWorld([HALL], (2,), Noise.none()), BatchWorld(HALL, 1, 1, Noise.none())
    single.reset(rng, Layout((HALL.start,), HALL.foods))
    batch.reset(0, HALL.start, HALL.foods)
    for _ in range(400):
        motors = Motors(rng.uniform(-12, 12), rng.uniform(-12, 12), ARM_RAISED, JAW_OPEN)
        single.robots[0].drive(motors)
        single.advance()
        batch.advance(motors)
        assert np.allclose(single.poses()[0], batch.poses()[0], rtol=0, atol=1e-9)
    senses = single.robots[0].sense()
    assert (senses.left_pulses, senses.right_pulses) == (
        batch.senses().left_pulses[0],
        batch.senses().right_pulses[0],
    )


@pytest.mark.parametrize("arena", [CORRIDOR, PILLAR], ids=lambda arena: arena.name)
def test_rays_are_those_of_proximity_to_rounding(arena: Any) -> None:
    rng = np.random.default_rng(1)
    worlds = 300
    low, high = np.array(arena.bounds[:2]) + 30, np.array(arena.bounds[2:]) - 30
    starts = np.column_stack((rng.uniform(low, high, (worlds, 2)), rng.uniform(-7, 7, worlds)))
    foods = starts[:, None, :2] + rng.uniform(-130, 130, (worlds, 2, 2))
    batch = BatchWorld(arena, worlds, 2, Noise.none())
    batch.reset(0, starts, foods)
    readings = batch.senses().proximity
    seen = 0
    for (x, y, heading), places, got in zip(starts.tolist(), foods.tolist(), readings.tolist(), strict=True):
        discs = [(*place, FOOD_RADIUS) for place in places]
        clean = clean_readings(x, y, math.cos(heading), math.sin(heading), arena.segments, discs)
        assert all(
            abs(int(value) - reading) <= (abs(value - round(value)) < 1e-6)
            for value, reading in zip(clean, got, strict=True)
        )
        seen += sum(value > 0 for value in clean)
    assert seen > 500


def test_picking_up_carrying_and_releasing_as_in_pymunk() -> None:
    """The same commands in both: within 3 mm at every round, and the same senses but where 3 mm tell."""
    start, food = Pose(200, 115, 0.05), Point(330, 120)
    single, batch = PymunkWorld([CORRIDOR], (2,), Noise.none()), BatchWorld(CORRIDOR, 1, 1, Noise.none())
    single.reset(np.random.default_rng(0), Layout((start,), (food,)))
    batch.reset(0, start, [food])
    script = (
        [Motors(0, 0, 255, 200)] * 11  # lower
        + [Motors(5, 5, 255, 200)] * 16  # push up to it
        + [Motors(0, 0, 255, 0)] * 8  # grip
        + [Motors(0, 0, 215, 0)] * 11  # raise
        + [Motors(8, 9, 215, 0)] * 15  # carry
        + [Motors(0, 0, 255, 0)] * 11  # lower
        + [Motors(0, 0, 255, 200)] * 7  # let go
        + [Motors(-6, -6, 255, 200)] * 10  # back off
    )
    held = []
    for motors in script:
        single.robots[0].drive(motors)
        single.advance()
        batch.advance(motors)
        assert math.dist(single.poses()[0][:2], batch.poses()[0][:2]) < 3.0
        assert abs(single.poses()[0].heading - batch.poses()[0][2]) < 0.03
        place = single.food_places()[0]
        assert math.dist(place[:2], batch.food_places()[0, 0, :2]) < 3.0
        assert place.lifted == bool(batch.food_places()[0, 0, 2])
        senses, many = single.robots[0].sense(), batch.senses()
        assert (senses.arm, senses.jaw, senses.object_presence) == (
            many.arm[0],
            many.jaw[0],
            many.object_presence[0],
        )
        held.append(int(batch.held()[0]))
    assert 0 in held
    assert held[-1] == -1
    assert math.dist(batch.food_places()[0, 0, :2], food) > 60


@pytest.mark.parametrize(
    ("off", "stays"), [(-0.7, True), (0.0, True), (0.7, True), (0.9, False), (-0.9, False)]
)
def test_food_before_a_fingertip_stays_within_the_cone_of_friction(off: float, stays: bool) -> None:
    """At 0.04 a tip carries food along that is up to 0.78 mm off its middle; further off, it slips aside."""
    aside, ahead = half_gap(JAW_OPEN) + FINGER_THICKNESS / 2 + off, FINGER_TIP + FOOD_RADIUS
    batch = BatchWorld(HALL, 1, 1, Noise.none())
    batch.reset(0, HALL.start, [(HALL.start.x + ahead + 3.0, HALL.start.y + aside)])
    for motors in [Motors(0, 0, 255, 200)] * 11 + [Motors(8, 8, 255, 200)] * 30:
        batch.advance(motors)
    x, y = batch.food_places()[0, 0, :2] - batch.poses()[0, :2]
    assert (abs(x - ahead) < 0.1) == stays
    assert (abs(y - aside) < 0.1) == stays


def test_an_arm_does_not_come_down_on_food() -> None:
    batch = BatchWorld(CORRIDOR, 1, 1, Noise.none())
    batch.reset(0, (200, 115, 0), [(200 + FINGER_TIP, 115 + 28)])
    for _ in range(15):
        batch.advance((0, 0, 255, 200))
    assert batch.senses().arm[0] == 234


@pytest.mark.parametrize("arena", [CORRIDOR, RECTANGLE, PILLAR], ids=lambda arena: arena.name)
def test_whatever_is_commanded_nothing_ends_up_in_a_wall_or_in_food(arena: Any) -> None:
    rng = np.random.default_rng(5)
    worlds, foods = 256, 3
    batch = BatchWorld(arena, worlds, foods)
    places = np.array(((150, 60), (250, 170), (420, 60)))
    batch.reset(5, (80, 115, 0), places)
    arms = rng.choice((215, 255), worlds)
    for step in range(150):
        if step % 10 == 0:
            arms, jaws = rng.choice((215, 255), worlds), rng.choice((0, 200), worlds)
            wheels = rng.integers(-12, 19, (worlds, 2))
        batch.advance(np.column_stack((wheels, arms, jaws)))
        poses, where, held = batch.poses(), batch.food_places(), batch.held()
        for world in range(0, worlds, 16):
            x, y, _ = poses[world]
            assert arena.clearance(Point(x, y)) > RADIUS - 1.0
            for k in range(foods):
                assert arena.clearance(Point(*where[world, k, :2])) > FOOD_RADIUS - 1.5
                if k != held[world]:
                    assert math.dist((x, y), where[world, k, :2]) > RADIUS + FOOD_RADIUS - 1.5
                for other in range(k):
                    lifted = where[world, k, 2] or where[world, other, 2]
                    assert (
                        lifted
                        or math.dist(where[world, k, :2], where[world, other, :2]) > 2 * FOOD_RADIUS - 1.5
                    )
    moved = np.abs(where[:, :, :2] - places).max(axis=(1, 2))
    assert (moved > 5).mean() > 0.5


def test_a_world_is_the_same_in_any_company_and_on_any_number_of_threads() -> None:
    rng = np.random.default_rng(2)
    motors = rng.integers(-10, 15, (40, 300, 2))

    def run(worlds: Any, threads: Any) -> Any:
        numba.set_num_threads(threads)
        batch = BatchWorld(CORRIDOR, worlds)
        batch.reset(9, CORRIDOR.start, CORRIDOR.foods)
        for row in motors:
            batch.advance(np.column_stack((row[:worlds], np.full((worlds, 2), (255, 200)))))
        scene = batch.scene()
        return batch.poses(), batch.senses().proximity, scene.robots, scene.foods

    most = numba.get_num_threads()
    few, many = run(3, 1), run(300, most)
    numba.set_num_threads(most)
    assert all(np.array_equal(a, b[:3]) for a, b in zip(few, many, strict=True))
    assert not np.array_equal(many[0][0], many[0][1])


def test_tracks_are_those_of_retracking_frame_by_frame() -> None:
    """The same detections into `Tracks`: the same tracks, label by label, under losses."""
    noise = Noise(loss_rate_food=0.03, cable_loss_factor=3.0, reversal_rate=0.0)
    rng = np.random.default_rng(4)
    worlds, foods = 60, 3
    batch = BatchWorld(RECTANGLE, worlds, foods, noise)
    batch.reset(1, (120, 300, 0), ((230, 270), (260, 340), (420, 320)))
    rules = [Tracks() for _ in range(worlds)]
    changes = 0
    for step in range(250):
        if step:
            if step % 12 == 1:
                wheels = rng.integers(-8, 16, (worlds, 2))
                rest = np.column_stack((rng.choice((215, 255), worlds), rng.choice((0, 200), worlds)))
            batch.advance(np.column_stack((wheels, rest)))
        poses, scene = batch.poses(), batch.scene()
        seen = np.stack([batch._food_rows(row) for row in (at.SEEN, at.SEEN_X, at.SEEN_Y)], axis=2)
        lost, where = batch._food_rows(at.LOST), batch.food_places()
        for world in range(worlds):
            x, y, heading = poses[world].tolist()
            plate = (Plate(x, y, math.cos(heading), math.sin(heading)),)
            covers = [where[world, k, :2] for k in range(foods) if lost[world, k]]
            clear = FOOD_RADIUS + 5.0 * noise.position_jitter * 5.0

            def visible(
                px: Any, py: Any, plate: Any = plate, covers: Any = covers, clear: Any = clear
            ) -> Any:
                px, py = px * 5.0, py * 5.0
                apart = all(math.hypot(px - cx, py - cy) > 2 * FOOD_RADIUS for cx, cy in covers)
                return not under_plate(px, py, clear, plate) and apart

            shown = [
                Detection(u, v, 0, 0, False, u, v, 1, 1, 1) for show, u, v in seen[world].tolist() if show
            ]
            expected = {r.label: (r.x, r.y, r.found) for r in rules[world].update(shown, visible).regions}
            got = {
                label: (*place, found)
                for label, place, found in zip(
                    scene.labels[world].tolist(),
                    scene.foods[world].tolist(),
                    scene.foods_found[world].tolist(),
                    strict=True,
                )
                if label >= 0
            }
            assert expected == got
            changes += max(got, default=0) > foods - 1
    assert changes > 100


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"num_worlds": 0}, "num_worlds is 0"),
        ({"num_worlds": 1, "foods": 17}, "foods is 17"),
        ({"num_worlds": 1, "holes": 3}, "holes is 3"),
    ],
)
def test_bad_arguments_are_quoted(arguments: Any, message: Any) -> None:
    with pytest.raises(ValueError, match=message):
        BatchWorld(CORRIDOR, **arguments)


def test_bad_arrays_are_quoted() -> None:
    batch = BatchWorld(CORRIDOR, 4)
    with pytest.raises(ValueError, match=r"starts has shape \(2, 3\)"):
        batch.reset(0, np.zeros((2, 3)), CORRIDOR.foods)
    batch.reset(0, CORRIDOR.start, CORRIDOR.foods)
    with pytest.raises(ValueError, match="motors has values that are not finite"):
        batch.advance((np.nan, 0, 215, 200))
    assert batch.bytes_per_world < 2000
