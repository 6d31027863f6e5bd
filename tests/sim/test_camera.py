"""The simulated camera: what it hides, loses and gets wrong, and how often."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from khepera_forage.noise import Noise
from khepera_forage.sim.sensing import OverheadCamera
from khepera_forage.vision.scene import Region, Scene, Truth

NONE, LABORATORY = Noise.none(), Noise.laboratory()


class Stage:
    """A world of which a test moves the pieces."""

    def __init__(
        self,
        markers: tuple[tuple[float, float, float, int], ...] = (),
        foods: tuple[tuple[float, float], ...] = (),
    ) -> None:
        self.truth = Truth(markers, foods)

    def __call__(self) -> Truth:
        return self.truth


def camera_over(
    stage: Stage, noise: Noise = NONE, anchor: tuple[float, float] | None = None, seed: int = 0
) -> OverheadCamera:
    camera = OverheadCamera(stage, noise, anchor)
    camera.reset(np.random.default_rng(seed))
    return camera


def film(camera: OverheadCamera, frames: int) -> Iterator[Scene]:
    for _ in range(frames):
        camera.expose()
        yield camera.look()


def only(scene: Scene, holes: int) -> Region:
    (region,) = [r for r in scene.regions if r.holes == holes]
    return region


def lost_shares(camera: OverheadCamera, frames: int) -> dict[int, float]:
    """By number of holes."""
    scenes = list(film(camera, frames))
    return {holes: sum(not only(scene, holes).found for scene in scenes) / frames for holes in (0, 1, 2)}


PAIR = Stage(((400.0, 300.0, 0.5, 1), (900.0, 700.0, 2.0, 2)), ((400.0, 700.0), (900.0, 300.0)))


# ---------------------------------------------------------------- without noise


def test_exact_without_noise() -> None:
    scene = camera_over(Stage(((400, 300, math.radians(30), 1),), ((1001, 702),))).look()
    marker, food = only(scene, 1), only(scene, 0)
    assert (marker.x, marker.y, marker.orientation, marker.found, marker.edge) == (
        80.0,
        60.0,
        30,
        True,
        False,
    )
    assert (marker.area, marker.perimeter, marker.compactness) == (368.0, 80.0, 80**2 / 368)
    assert (food.x, food.y, food.orientation, food.found, food.edge) == (200.2, 140.4, 0, True, False)
    assert (food.first_x, food.first_y) == (200.2, 140.4 + 3.5)
    assert food.area == pytest.approx(math.pi * 3.5**2)
    assert food.compactness == pytest.approx(4 * math.pi)
    assert only(camera_over(PAIR).look(), 2).area == 352.0


@pytest.mark.parametrize(
    ("x", "y", "heading", "edge"),
    [
        (60.1, 1000, 0, False),
        (59.9, 1000, 0, True),
        (41, 1000, math.pi / 2, False),
        (1000, 41, 0, False),
        (1000, 41, math.pi / 2, True),
        (3139, 1000, 0, False),
        (3141, 1000, 0, True),
        (1000, 2361, 0, True),
    ],
)
def test_edge_flag_of_markers(x: float, y: float, heading: float, edge: bool) -> None:
    assert only(camera_over(Stage(((x, y, heading, 1),))).look(), 1).edge is edge


def test_edge_flag_of_food_and_the_end_of_the_picture() -> None:
    places = ((18.0, 500.0), (17.0, 900.0), (-1.0, 700.0), (3201.0, 700.0), (700.0, 2401.0))
    regions = camera_over(Stage(((2000.0, 1500.0, 0.0, 1),), places)).look().regions
    assert {(r.x * 5, r.edge) for r in regions if r.holes == 0} == {(18.0, False), (17.0, True)}


# ---------------------------------------------------------------- hiding


def distance_to_plate(x: float, y: float, marker: tuple[float, float, float, int]) -> float:
    """Distance from a rectangle, by looking at a great many points all over it."""
    mx, my, heading, _ = marker
    a, b = np.meshgrid(np.linspace(-60, 60, 481), np.linspace(-40, 40, 321))
    px = mx + a * math.cos(heading) - b * math.sin(heading)
    py = my + a * math.sin(heading) + b * math.cos(heading)
    return float(np.sqrt(((px - x) ** 2 + (py - y) ** 2).min()))


@given(st.floats(-95, 95), st.floats(-95, 95), st.floats(-7, 7), st.sampled_from([1, 2]))
def test_food_is_hidden_exactly_when_its_disc_touches_a_marker(
    dx: float, dy: float, heading: float, holes: int
) -> None:
    marker = (600.0, 700.0, heading, holes)
    distance = distance_to_plate(600 + dx, 700 + dy, marker)
    assume(abs(distance - 17.5) > 0.2)
    stage = Stage(((1500.0, 700.0, 0.0, 1), marker), ((600 + dx, 700 + dy),))
    shown = any(r.holes == 0 for r in camera_over(stage).look().regions)
    assert shown == (distance > 17.5)


def test_hidden_food_keeps_its_place_and_is_dropped_when_uncovered_and_gone() -> None:
    stage = Stage(((500, 500, 0, 1),), ((600, 500),))
    camera = camera_over(stage)
    food = only(camera.look(), 0)
    for x in (523.0, 540.0, 560.0):
        stage.truth = Truth(((x, 500, 0, 1),), ((x + 53, 500),))  # gripped and taken along
        camera.expose()
        assert only(camera.look(), 0) == food._replace(found=False)
    stage.truth = Truth(((500, 677, 0, 1),), ((500, 720),))
    camera.expose()
    assert [r.holes for r in camera.look().regions] == [1]


def test_a_lost_marker_still_hides() -> None:
    noise = replace(NONE, loss_rate_one_hole=1.0, loss_rounds=1e9)
    stage = Stage(((500, 500, 0, 1),), ((600, 500),))
    camera = camera_over(stage, noise)
    stage.truth = Truth(((540, 500, 0, 1),), ((600, 500),))
    for scene in film(camera, 20):
        assert [(r.holes, r.found) for r in scene.regions] == [(1, False), (0, False)]


@pytest.mark.parametrize("speed", [1.0, 4.0, 16.0])
def test_food_going_under_the_rim_is_not_taken_for_vanished(speed: float) -> None:
    """Jitter alone must not uncover a place: the robot approaches, stands over the food and backs off."""
    noise = Noise.only("camera jitter")
    for seed in range(20):
        stage = Stage(((500, 500, 0.3, 1),), ((600, 530),))
        camera = camera_over(stage, noise, seed=seed)
        label = only(camera.look(), 0).label
        for way in [*np.arange(0, 60, speed), *np.arange(60, 0, -speed)]:
            stage.truth = Truth(
                ((500 + float(way) * math.cos(0.3), 500 + float(way) * math.sin(0.3), 0.3, 1),), ((600, 530),)
            )
            camera.expose()
            assert only(camera.look(), 0).label == label


# ---------------------------------------------------------------- jitter and reversal


def normal_share(low: float, high: float) -> float:
    """How much of the heading jitter falls between two errors in degrees."""
    wide = LABORATORY.heading_jitter * math.sqrt(2)
    return (math.erf(high / wide) - math.erf(low / wide)) / 2


def test_jitter_has_the_stated_size_and_no_bias() -> None:
    frames = 5000
    stage = Stage(((400.0, 300.0, math.radians(90), 1),), ((400.0, 700.0),))
    scenes = list(film(camera_over(stage, Noise.only("camera jitter")), frames))
    marker = np.array([(r.x - 80, r.y - 60) for r in (only(s, 1) for s in scenes)])
    food = np.array([(r.x - 80, r.y - 140) for r in (only(s, 0) for s in scenes)])
    errors = np.hstack([marker, food])
    sd = LABORATORY.position_jitter
    # Five standard errors of a mean and of a standard deviation.
    assert np.abs(errors.mean(axis=0)).max() < 5 * sd / math.sqrt(frames)
    assert np.abs(errors.std(axis=0) - sd).max() < 5 * sd / math.sqrt(2 * frames)
    assert np.abs(np.corrcoef(errors.T) - np.eye(4)).max() < 5 / math.sqrt(frames)
    headings = np.array([only(s, 1).orientation for s in scenes]) - 90
    rounded_sd = math.sqrt(sum(2 * k * k * normal_share(k - 0.5, k + 0.5) for k in range(1, 9)))
    assert abs(headings.mean()) < 5 * rounded_sd / math.sqrt(frames)
    assert abs(headings.std() - rounded_sd) < 5 * rounded_sd / math.sqrt(2 * frames)


def test_reversals_are_as_frequent_as_stated_and_last_one_frame() -> None:
    frames = 20_000
    camera = camera_over(PAIR, replace(NONE, reversal_rate=0.05))
    straight = {holes: only(camera_over(PAIR).look(), holes).orientation for holes in (1, 2)}
    turned = []
    for scene in film(camera, frames):
        turns = {holes: (only(scene, holes).orientation - straight[holes]) % 360 for holes in (1, 2)}
        assert set(turns.values()) <= {0, 180}
        turned.append([turns[1] == 180, turns[2] == 180])
    share = np.array(turned)
    bound = 5 * math.sqrt(0.05 * 0.95 / frames)
    assert np.abs(share.mean(axis=0) - 0.05).max() < bound
    assert abs((share[1:] & share[:-1]).mean() - 0.05**2) < 5 * math.sqrt(0.0025 / frames)


# ---------------------------------------------------------------- losses and cables


def test_losses_are_as_frequent_and_as_long_as_stated() -> None:
    """A loss begins in a share `rate` of the frames without one, and the mean loss lasts `loss_rounds`."""
    frames, noise = 40_000, Noise.only("tracking losses")
    noise = replace(noise, loss_rate_one_hole=0.01, loss_rate_two_holes=0.02, loss_rate_food=0.005)
    stage = Stage(PAIR.truth.markers, PAIR.truth.foods[:1])
    scenes = list(film(camera_over(stage, noise), frames))
    for holes, rate in ((0, 0.005), (1, 0.01), (2, 0.02)):
        lost = np.array([not only(s, holes).found for s in scenes])
        begins = int((lost[1:] & ~lost[:-1]).sum())
        free = int((~lost).sum())
        assert abs(begins / free - rate) < 5 * math.sqrt(rate / free)
        length = lost.sum() / begins
        assert abs(length - noise.loss_rounds) < 5 * noise.loss_rounds / math.sqrt(begins)


def test_two_holes_are_lost_more_often_and_everything_more_often_under_a_cable() -> None:
    noise = Noise.only("tracking losses", "cables")
    # The cable of the one-hole robot at the right passes over the two-hole robot and the food between.
    stage = Stage(((1500.0, 500.0, 0.0, 1), (800.0, 510.0, 0.0, 2)), ((1100.0, 490.0),))
    free = lost_shares(camera_over(stage, noise), 40_000)
    under = lost_shares(camera_over(stage, noise, anchor=(100.0, 500.0)), 40_000)
    assert free[1] < free[2]
    for holes, rate in ((0, 0.001), (1, 0.001), (2, 0.002)):
        share = rate * LABORATORY.loss_rounds
        assert 0.5 * share < free[holes] < 1.6 * share
    assert under[0] > 5 * free[0]
    assert under[2] > 4 * free[2]
    assert under[1] == free[1], "its own cable hangs from its own marker"


ONLY_CABLES = replace(
    NONE,
    loss_rate_one_hole=1e-9,
    loss_rate_two_holes=1e-9,
    loss_rate_food=1e-9,
    cable_loss_factor=1e9,
    loss_rounds=1e9,
)
"""All is lost at once and for good under a cable, and nothing ever without one."""


@pytest.mark.parametrize(
    ("x", "y", "under"),
    [(500, 317.4, True), (500, 282.6, True), (500, 317.6, False), (183, 300, True), (182, 300, False)],
)
def test_a_cable_lies_over_food_between_anchor_and_robot(x: float, y: float, under: bool) -> None:
    stage = Stage(((800.0, 300.0, 1.0, 1),), ((x, y),))
    for scene in film(camera_over(stage, ONLY_CABLES, anchor=(200.0, 300.0)), 20):
        assert only(scene, 0).found != under
        assert only(scene, 1).found


@pytest.mark.parametrize(("y", "under"), [(339, True), (341, False)])
def test_a_cable_lies_over_the_marker_of_another_robot(y: float, under: bool) -> None:
    stage = Stage(((800.0, 300.0, 1.0, 1), (500.0, y, 1.0, 2)))
    for scene in film(camera_over(stage, ONLY_CABLES, anchor=(200.0, 300.0)), 20):
        assert only(scene, 2).found != under
        assert only(scene, 1).found
    for scene in film(camera_over(stage, ONLY_CABLES), 20):
        assert only(scene, 2).found, "no anchor, no cables"


def test_lost_food_keeps_its_track_through_the_loss() -> None:
    noise = replace(LABORATORY, loss_rate_food=0.05)
    stage = Stage(((1500.0, 500.0, 0.0, 1),), ((800.0, 510.0), (1100.0, 900.0)))
    camera = camera_over(stage, noise)
    labels = [r.label for r in camera.look().regions]
    before, losses = camera.look(), 0
    for scene in film(camera, 5000):
        assert [r.label for r in scene.regions] == labels
        for old, new in zip(before.regions, scene.regions, strict=True):
            if not new.found:
                losses += 1
                assert new == old._replace(found=False)
        before = scene
    assert losses > 500


def test_nothing_is_lost_in_the_first_frame() -> None:
    noise = replace(NONE, loss_rate_one_hole=1.0, loss_rate_two_holes=1.0, loss_rate_food=1.0)
    camera = camera_over(PAIR, noise)
    assert all(r.found for r in camera.look().regions)
    camera.expose()
    assert not any(r.found for r in camera.look().regions)
    camera.reset(np.random.default_rng(1))
    assert all(r.found for r in camera.look().regions)


# ---------------------------------------------------------------- the contract and reproducibility
