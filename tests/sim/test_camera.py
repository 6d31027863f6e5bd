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
Marker = tuple[float, float, float, int]


class Stage:
    """A world of which a test moves the pieces."""

    def __init__(self, markers: tuple[Marker, ...] = (), foods: tuple[tuple[float, float], ...] = ()) -> None:
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


PAIR = Stage(((400.0, 300.0, 0.5, 1), (900.0, 700.0, 2.0, 2)), ((400.0, 700.0), (900.0, 300.0)))


def test_exact_without_noise() -> None:
    scene = camera_over(Stage(((400, 300, math.radians(30), 1),), ((1001, 702),))).look()
    marker, food = only(scene, 1), only(scene, 0)
    assert (marker.x, marker.y, marker.orientation, marker.found, marker.edge) == (80, 60, 30, True, False)
    assert (marker.area, marker.perimeter, marker.compactness) == (368.0, 80.0, 80**2 / 368)
    assert (food.x, food.y, food.orientation, food.found, food.edge) == (200.2, 140.4, 0, True, False)
    assert (food.first_x, food.first_y) == (200.2, 140.4 + 3.5)
    assert food.area == pytest.approx(math.pi * 3.5**2)
    assert food.compactness == pytest.approx(4 * math.pi)
    assert only(camera_over(PAIR).look(), 2).area == 352.0


def test_edge_flag_and_the_end_of_the_picture() -> None:
    for x, y, heading, edge in (
        *((60.1, 1000, 0, False), (59.9, 1000, 0, True), (41, 1000, math.pi / 2, False)),
        *((1000, 41, 0, False), (1000, 41, math.pi / 2, True), (1000, 2361, 0, True), (3141, 1000, 0, True)),
    ):
        assert only(camera_over(Stage(((x, y, heading, 1),))).look(), 1).edge is edge
    places = ((18.0, 500.0), (17.0, 900.0), (-1.0, 700.0), (3201.0, 700.0), (700.0, 2401.0))
    regions = camera_over(Stage(((2000.0, 1500.0, 0.0, 1),), places)).look().regions
    assert {(r.x * 5, r.edge) for r in regions if r.holes == 0} == {(18.0, False), (17.0, True)}


@given(st.floats(-95, 95), st.floats(-95, 95), st.floats(-7, 7), st.sampled_from([1, 2]))
def test_food_is_hidden_exactly_when_its_disc_touches_a_marker(
    ahead: float, aside: float, heading: float, holes: int
) -> None:
    """A marker is a plate of 120 mm by 80 mm."""
    distance = math.hypot(max(abs(ahead) - 60, 0), max(abs(aside) - 40, 0))
    assume(abs(distance - 17.5) > 0.2)
    cosine, sine = math.cos(heading), math.sin(heading)
    food = 600 + ahead * cosine - aside * sine, 700 + ahead * sine + aside * cosine
    stage = Stage(((1500.0, 700.0, 0.0, 1), (600.0, 700.0, heading, holes)), (food,))
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
    stage = Stage(((500, 500, 0, 1),), ((600, 500),))
    camera = camera_over(stage, replace(NONE, loss_rate_one_hole=1.0, loss_rounds=1e9))
    stage.truth = Truth(((540, 500, 0, 1),), ((600, 500),))
    for scene in film(camera, 20):
        assert [(r.holes, r.found) for r in scene.regions] == [(1, False), (0, False)]


@pytest.mark.parametrize("speed", [1.0, 4.0, 16.0])
def test_food_going_under_the_rim_is_not_taken_for_vanished(speed: float) -> None:
    """Jitter alone must not uncover a place: the robot approaches, stands over the food and backs off."""
    for seed in range(20):
        stage = Stage(((500, 500, 0.3, 1),), ((600, 530),))
        camera = camera_over(stage, Noise.only("camera jitter"), seed=seed)
        label = only(camera.look(), 0).label
        for way in [*np.arange(0, 60, speed), *np.arange(60, 0, -speed)]:
            x, y = 500 + float(way) * math.cos(0.3), 500 + float(way) * math.sin(0.3)
            stage.truth = Truth(((x, y, 0.3, 1),), ((600, 530),))
            camera.expose()
            assert only(camera.look(), 0).label == label


def test_jitter_has_the_stated_size_and_no_bias() -> None:
    """Bounds are five standard errors, of a mean and of a standard deviation."""
    frames, sd, heading_sd = 2500, 0.06, 4.0
    stage = Stage(((400.0, 300.0, math.radians(90), 1),), ((400.0, 700.0),))
    scenes = list(film(camera_over(stage, replace(NONE, position_jitter=sd, heading_jitter=heading_sd)), frames))
    marker, food = ([(r.x - 80, r.y - y) for r in (only(s, h) for s in scenes)] for h, y in ((1, 60), (0, 140)))
    errors = np.hstack([marker, food])
    assert np.abs(errors.mean(axis=0)).max() < 5 * sd / math.sqrt(frames)
    assert np.abs(errors.std(axis=0) - sd).max() < 5 * sd / math.sqrt(2 * frames)
    assert np.abs(np.corrcoef(errors.T) - np.eye(4)).max() < 5 / math.sqrt(frames)
    headings = np.array([only(s, 1).orientation for s in scenes]) - 90
    rounded_sd = math.sqrt(heading_sd**2 + 1 / 12)
    assert abs(headings.mean()) < 5 * rounded_sd / math.sqrt(frames)
    assert abs(headings.std() - rounded_sd) < 5 * rounded_sd / math.sqrt(2 * frames)


def test_reversals_are_as_frequent_as_stated_and_last_one_frame() -> None:
    frames, rate = 2_500, 0.2
    straight = {holes: only(camera_over(PAIR).look(), holes).orientation for holes in (1, 2)}
    scenes = film(camera_over(PAIR, replace(NONE, reversal_rate=rate)), frames)
    turns = np.array([[(only(s, h).orientation - straight[h]) % 360 for h in (1, 2)] for s in scenes])
    assert set(turns.ravel().tolist()) == {0, 180}
    reversed_ = turns == 180
    assert np.abs(reversed_.mean(axis=0) - rate).max() < 5 * math.sqrt(rate * (1 - rate) / frames)
    assert abs((reversed_[1:] & reversed_[:-1]).mean() - rate**2) < 5 * math.sqrt(rate**2 / frames)


@pytest.mark.parametrize(("anchor", "factor"), [(None, 1), ((100.0, 500.0), 4)])
def test_losses_are_as_frequent_and_as_long_as_stated(anchor: tuple[float, float] | None, factor: int) -> None:
    """A loss begins in a share `rate` of the frames without one, and the mean loss lasts `loss_rounds`.

    The cable of the one-hole robot at the right passes over the two-hole robot and the food between, not over its own.
    """
    rates = {"loss_rate_food": 0.01, "loss_rate_one_hole": 0.02, "loss_rate_two_holes": 0.04}
    noise = replace(NONE, **rates, loss_rounds=2.0, cable_loss_factor=4.0)
    stage = Stage(((1500.0, 500.0, 0.0, 1), (800.0, 510.0, 0.0, 2)), ((1100.0, 490.0),))
    scenes = list(film(camera_over(stage, noise, anchor), 4_000))
    for holes, rate in zip((0, 1, 2), rates.values(), strict=True):
        rate *= 1 if holes == 1 else factor
        lost = np.array([not only(s, holes).found for s in scenes])
        begins, free = int((lost[1:] & ~lost[:-1]).sum()), int((~lost).sum())
        assert abs(begins / free - rate) < 5 * math.sqrt(rate / free)
        assert abs(lost.sum() / begins - 2.0) < 5 * 2.0 / math.sqrt(begins)


HARDLY = dict.fromkeys(("loss_rate_one_hole", "loss_rate_two_holes", "loss_rate_food"), 1e-9)
ONLY_CABLES = replace(NONE, **HARDLY, cable_loss_factor=1e9, loss_rounds=1e9)
"""All is lost at once and for good under a cable, and nothing ever without one."""


@pytest.mark.parametrize(
    ("holes", "x", "y", "under"),
    [
        *((0, 500, 317.4, True), (0, 500, 282.6, True), (0, 500, 317.6, False)),
        *((0, 183, 300, True), (0, 182, 300, False)),
        *((2, 500, 339, True), (2, 500, 341, False)),
    ],
)
def test_a_cable_lies_over_food_and_markers_between_anchor_and_robot(
    holes: int, x: float, y: float, under: bool
) -> None:
    robot: Marker = (800.0, 300.0, 1.0, 1)
    stage = Stage((robot, (x, y, 1.0, 2)) if holes else (robot,), () if holes else ((x, y),))
    for anchor in ((200.0, 300.0), None):
        for scene in film(camera_over(stage, ONLY_CABLES, anchor), 20):
            assert only(scene, holes).found != (under and anchor is not None)
            assert only(scene, 1).found


def test_lost_food_keeps_its_track_through_the_loss() -> None:
    stage = Stage(((1500.0, 500.0, 0.0, 1),), ((800.0, 510.0), (1100.0, 900.0)))
    camera = camera_over(stage, replace(LABORATORY, loss_rate_food=0.05))
    before, losses = camera.look(), 0
    labels = [r.label for r in before.regions]
    for scene in film(camera, 2500):
        assert [r.label for r in scene.regions] == labels
        for old, new in zip(before.regions, scene.regions, strict=True):
            if not new.found:
                losses += 1
                assert new == old._replace(found=False)
        before = scene
    assert losses > 250


def test_nothing_is_lost_in_the_first_frame() -> None:
    camera = camera_over(PAIR, replace(NONE, **dict.fromkeys(HARDLY, 1.0)))
    for _ in range(2):
        assert all(r.found for r in camera.look().regions)
        camera.expose()
        assert not any(r.found for r in camera.look().regions)
        camera.reset(np.random.default_rng(1))
