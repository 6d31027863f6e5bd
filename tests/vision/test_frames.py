"""Rendered frames: everything is where it truly is, and every trouble does what it says."""

import itertools
import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.frames import FrameRenderer, RenderedFrameSource
from khepera_forage.vision.shapes import MARKER_FEATURES, MARKER_FRAME, MARKER_HOLES
from khepera_forage.vision.simulated_camera import Truth

Frame = NDArray[np.uint8]
NONE, LABORATORY = CameraAppearance.none(), CameraAppearance.laboratory()
PAIR = Truth(((400.0, 300.0, 0.5, 1), (900.0, 700.0, 2.0, 2)), ((400.0, 700.0), (900.0, 300.0)))
ROW, COLUMN = np.mgrid[:480, :640] + 0.5


def rendered(
    truth: Truth,
    look: CameraAppearance = NONE,
    frames: int = 1,
    seed: int = 0,
    anchor: tuple[float, float] | None = None,
) -> list[Frame]:
    renderer = FrameRenderer(lambda: truth, look, anchor)
    renderer.reset(np.random.default_rng(seed))
    return [renderer.frame() for _ in range(frames)]


def one(truth: Truth, look: CameraAppearance = NONE, anchor: tuple[float, float] | None = None) -> Frame:
    return rendered(truth, look, anchor=anchor)[0]


def middle(weight: NDArray[np.float64]) -> tuple[float, float]:
    """Centroid in pixels, x right and y up."""
    total = weight.sum()
    return float((weight * COLUMN).sum() / total), 480 - float((weight * ROW).sum() / total)


def seen_at(frame: Frame, x: float, y: float) -> int:
    """The grey level at a place in mm."""
    return int(frame[479 - int(y / 5), int(x / 5)])


def holes_in(frame: Frame, threshold: float = 155) -> list[int]:
    """The number of holes of each large bright region."""
    contours, hierarchy = cv2.findContours(
        (frame > threshold).astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE
    )
    parents = hierarchy[0, :, 3].tolist()
    outer = [i for i, c in enumerate(contours) if parents[i] < 0 and cv2.contourArea(c) > 200]
    return sorted(parents.count(i) for i in outer)


# ---------------------------------------------------------------- truth


@given(x=st.floats(200, 3000), y=st.floats(200, 2200), heading=st.floats(-math.pi, math.pi))
@settings(max_examples=40, deadline=None)
def test_marker_is_true_to_a_twentieth_of_a_pixel(x: float, y: float, heading: float) -> None:
    # On a floor as black as the frame and the robot only the white stands out, so that its coverage can be read off.
    look = replace(NONE, floor=0, black=0, body=0, gripper=0, white=250)
    for holes in (1, 2):
        white = one(Truth(((x, y, heading, holes),), ()), look).astype(float) / 250
        ahead = -400 * sum(place[0] for place in MARKER_HOLES[holes]) / (9600 - 400 * holes)
        cx, cy = middle(white)
        assert cx == pytest.approx(x / 5 + ahead / 5 * math.cos(heading), abs=0.05)
        assert cy == pytest.approx(y / 5 + ahead / 5 * math.sin(heading), abs=0.05)
        assert white.sum() == pytest.approx(MARKER_FEATURES[holes].area, rel=0.01)
        # The long side lies along the heading.
        dx, dy = COLUMN - cx, 480 - ROW - cy
        turn = math.atan2(2 * (white * dx * dy).sum(), (white * (dx * dx - dy * dy)).sum()) / 2
        assert math.sin(turn - heading) == pytest.approx(0, abs=math.radians(0.5))


@given(x=st.floats(100, 3100), y=st.floats(100, 2300))
@settings(max_examples=40, deadline=None)
def test_food_is_true_to_a_twentieth_of_a_pixel(x: float, y: float) -> None:
    white = one(Truth((), ((x, y),)), replace(NONE, floor=0, white=250)).astype(float) / 250
    assert middle(white) == pytest.approx((x / 5, y / 5), abs=0.05)
    assert white.sum() == pytest.approx(math.pi * 3.5**2, rel=0.01)


def test_row_0_is_the_largest_y() -> None:
    frame = one(Truth((), ((100.0, 2300.0),)))
    assert frame.shape == (480, 640)
    assert frame.dtype == np.uint8
    assert frame[20, 20] == NONE.white
    assert (frame[300:] == NONE.floor).all()


def test_what_lies_where_on_a_robot() -> None:
    frame = one(Truth(((1000.0, 1000.0, 0.0, 1),), ()))
    hole = MARKER_HOLES[1][0]
    assert seen_at(frame, 1000 + hole[0], 1000 + hole[1]) == NONE.black
    assert seen_at(frame, 950, 1000) == NONE.white
    assert seen_at(frame, 1000, 1000 + 40 + MARKER_FRAME / 2) < 60, "the frame"
    finger = [seen_at(frame, 1071, 1000 + side * 29.5) for side in (-1, 1)]
    assert all(level < 95 for level in finger), "the fingers stick out"
    assert seen_at(frame, 1071, 1000) == NONE.floor, "between the fingers is floor"
    assert seen_at(frame, 1100, 1000) == NONE.floor


def test_food_under_a_marker_is_covered() -> None:
    bare = one(Truth(((1000.0, 1000.0, 0.7, 2),), ()))
    assert np.array_equal(bare, one(Truth(((1000.0, 1000.0, 0.7, 2),), ((1010.0, 995.0),))))
    # Food in the gripper sticks out ahead of the marker.
    assert (bare != one(Truth(((1000.0, 1000.0, 0.7, 2),), ((1000 + 56 * 0.77, 1000 + 56 * 0.64),)))).any()


def test_things_at_and_beyond_the_border_are_cut() -> None:
    frame = one(Truth(((0.0, 0.0, 0.4, 2), (-500.0, 1000.0, 0.0, 1)), ((3200.0, 2400.0), (9000.0, 0.0))))
    assert frame[0, 639] > 200
    assert frame[479 - 6, 2] > 200 or frame[479, 0] > 200
    quarter = one(Truth((), ((3200.0, 1200.0),)), replace(NONE, floor=0, white=250)).astype(float) / 250
    assert quarter.sum() == pytest.approx(math.pi * 3.5**2 / 2, rel=0.02)


# ---------------------------------------------------------------- markers


@pytest.mark.parametrize("holes", [1, 2])
def test_holes_tell_front_from_back_and_are_apart(holes: int) -> None:
    places = MARKER_HOLES[holes]
    assert len(places) == holes
    assert sum(x for x, _ in places) / holes >= 10, "2 pixels ahead of the middle"
    for i, (x, y) in enumerate(places):
        assert 60 - abs(x) - 10 >= 20, "4 pixels of white to the rim"
        assert 40 - abs(y) - 10 >= 20
        for x2, y2 in places[:i]:
            assert max(abs(x - x2), abs(y - y2)) - 20 >= 20, "4 pixels of white between two holes"


@pytest.mark.parametrize("holes", [1, 2])
@pytest.mark.parametrize("blur", [0.7, 1.2])
def test_holes_are_resolved_in_the_laboratory(holes: int, blur: float) -> None:
    rng = np.random.default_rng(3)
    renderer_truth = [Truth((), ())]
    renderer = FrameRenderer(lambda: renderer_truth[0], replace(LABORATORY, blur=blur))
    renderer.reset(rng)
    right = 0
    for _ in range(60):
        x, y, heading = rng.uniform((600, 400, -3.1), (2600, 2000, 3.1)).tolist()
        renderer_truth[0] = Truth(((x, y, heading, holes),), ())
        right += holes_in(renderer.frame()) == [holes]
    assert right >= 59


# ---------------------------------------------------------------- troubles, one by one


def test_same_seed_same_frames() -> None:
    anchor = (650.0, 500.0)
    first, again, other = (rendered(PAIR, LABORATORY, 4, seed, anchor) for seed in (1, 1, 2))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not any(np.array_equal(a, b) for a, b in zip(first, other, strict=True))
    assert not np.array_equal(first[0], first[1])


def test_without_troubles_frames_of_one_scene_are_equal() -> None:
    frames = rendered(PAIR, NONE, 3, anchor=(650.0, 500.0))
    assert all(np.array_equal(frames[0], frame) for frame in frames)
    assert np.bincount(frames[0].ravel()).argmax() == NONE.floor


def test_noise_is_normal_independent_and_of_its_size() -> None:
    frames = np.array(rendered(Truth((), ()), replace(NONE, grain=4.0), 60), float)
    assert frames.std() == pytest.approx(4.0, rel=0.03)
    assert frames.mean() == pytest.approx(NONE.floor, abs=0.05)
    # From pixel to pixel, and from frame to frame.
    errors = frames - NONE.floor
    for a, b in (
        (errors[:, 1:], errors[:, :-1]),
        (errors[:, :, 1:], errors[:, :, :-1]),
        (errors[1:], errors[:-1]),
    ):
        assert abs((a * b).mean()) < 0.02 * 16


def test_light_falls_off_and_drifts() -> None:
    look = replace(NONE, vignette=0.2)
    corner, centre = one(Truth((), ()), look)[[0, 240], [0, 320]].tolist()
    assert corner == pytest.approx(0.8 * centre, abs=1)
    look = replace(NONE, gradient=0.1)
    frame = one(Truth((), ()), look).astype(float)
    assert frame.max() - frame.min() > 0.1 * NONE.floor
    look = replace(NONE, drift=0.1)
    levels = [float(frame.mean()) for frame in rendered(Truth((), ()), look, 600)]
    assert max(levels) - min(levels) > 0.05 * NONE.floor
    assert max(abs(b - a) for a, b in itertools.pairwise(levels)) < 1.0, "slowly"


def test_blur_softens_and_moves_nothing() -> None:
    truth = Truth((), ((1001.0, 1002.0),))
    sharp, soft = (
        one(truth, replace(NONE, floor=0, white=250, blur=blur)).astype(float) for blur in (0.0, 1.0)
    )
    assert np.abs(np.diff(soft)).max() < 0.7 * np.abs(np.diff(sharp)).max()
    assert soft.sum() == pytest.approx(sharp.sum(), rel=0.01)
    assert middle(soft) == pytest.approx(middle(sharp), abs=0.02)


def test_parallax_moves_what_is_high_outwards_and_leaves_the_floor() -> None:
    look = replace(NONE, height=2700.0, floor=0, black=0, body=0, gripper=0, white=250)
    white = one(Truth(((2600.0, 1200.0, 0.0, 1),), ()), look).astype(float)
    near = 2700 / (2700 - look.marker_height)
    ahead = -400 * MARKER_HOLES[1][0][0] / 9200 * near
    assert middle(white) == pytest.approx((320 + 1000 * near / 5 + ahead / 5, 240), abs=0.05)
    below = one(Truth(((1600.0, 1200.0, 0.0, 1),), ()), look).astype(float)
    assert middle(below) == pytest.approx((320 + ahead / 5, 240), abs=0.05)


# ---------------------------------------------------------------- cables


def difference(
    truth: Truth, look: CameraAppearance, anchor: tuple[float, float], frames: int = 1
) -> list[Frame]:
    """What the cables change, frame by frame."""
    bare = one(truth, NONE).astype(int)
    return [np.abs(frame - bare) for frame in rendered(truth, look, frames, anchor=anchor)]


def test_cable_hangs_from_the_anchor_to_the_robot_and_not_over_its_marker() -> None:
    truth, anchor = Truth(((1000.0, 1000.0, 0.3, 2),), ()), (2000.0, 1500.0)
    (change,) = difference(truth, replace(NONE, cable_width=4.0), anchor)
    rows, columns = np.nonzero(change > 10)
    x, y = columns + 0.5, 480 - (rows + 0.5)
    assert np.hypot(x - 400, y - 300).min() < 2, "at the anchor"
    from_robot = np.hypot(x - 200, y - 200)
    assert from_robot.min() < 16, "at the marker's rim"
    along, aside = (
        (x - 200) * math.cos(0.3) + (y - 200) * math.sin(0.3),
        (y - 200) * math.cos(0.3) - (x - 200) * math.sin(0.3),
    )
    assert not ((np.abs(along) < 12) & (np.abs(aside) < 8)).any(), "its own marker is clear"


def test_cable_crosses_other_markers_and_food() -> None:
    look = replace(NONE, cable_width=5.0, cable_sag=0.0, cable_sway=0.0)
    truth = Truth(((500.0, 1000.0, 0.0, 1), (1200.0, 1000.0, math.pi / 2, 2)), ((900.0, 1000.0),))
    frame = one(truth, look, anchor=(2000.0, 1000.0))
    # The line between white and a cable that covers about half of a pixel.
    assert frame[280:282, 180].min() < 200, "over the food"
    assert frame[278:282, 235].min() < 200, "over the other's marker"
    across = [seen_at(frame, 1200, y) for y in range(970, 1035, 5)]
    assert min(across) < 200 < max(across)


def test_cables_are_told_where_they_are_drawn() -> None:
    truth, anchor = Truth(((500.0, 1000.0, 0.0, 1),), ()), (2000.0, 1000.0)
    renderer = FrameRenderer(lambda: truth, replace(NONE, cable_width=4.0), anchor)
    assert renderer.cables == []
    renderer.reset(np.random.default_rng(0))
    frame = renderer.frame().astype(int)
    (curve,) = renderer.cables
    assert curve[0] == pytest.approx((400, 200))
    assert curve[-1] == pytest.approx((100, 200))
    for x, y in curve[:-3]:
        assert frame[479 - int(y), int(x)] < NONE.floor - 5
    still = FrameRenderer(lambda: truth, NONE, anchor)
    still.reset(np.random.default_rng(0))
    still.frame()
    assert still.cables == []


def test_cables_sway_slowly() -> None:
    truth, anchor = Truth(((500.0, 1000.0, 0.0, 1),), ()), (2000.0, 1000.0)
    changes = difference(truth, replace(NONE, cable_width=4.0), anchor, 100)
    bellies = []
    for change in changes:
        column = change[:, 250].astype(float)
        bellies.append(float((column * (np.arange(480) + 0.5)).sum() / column.sum()))
    assert max(bellies) - min(bellies) > 3
    assert max(abs(b - a) for a, b in itertools.pairwise(bellies)) < 1.5
    assert abs(np.mean(bellies) - 280) > 5, "and hang to a side"


def test_broad_cables_are_darker_over_all() -> None:
    truth, anchor = Truth(((500.0, 1000.0, 0.0, 1),), ()), (2000.0, 1010.0)
    look = replace(NONE, cable_sag=0.0, cable_sway=0.0)
    dark = [difference(truth, replace(look, cable_width=w), anchor)[0].sum() for w in (2.0, 4.0, 10.0)]
    assert dark[1] == pytest.approx(2 * dark[0], rel=0.1)
    assert dark[2] == pytest.approx(5 * dark[0], rel=0.15)


# ---------------------------------------------------------------- source, and bad input


def test_source_hands_out_frames_of_this_moment() -> None:
    truth = [PAIR]
    renderer = FrameRenderer(lambda: truth[0], NONE)
    renderer.reset(np.random.default_rng(0))
    source = RenderedFrameSource(renderer)
    first, age = source.newest()
    assert age == 0.0
    truth[0] = Truth((), ())
    second, _ = source.newest()
    assert (second == NONE.floor).all()
    assert (first > 200).any(), "an older frame stays as it was"
    source.close()


def test_frame_before_reset() -> None:
    with pytest.raises(RuntimeError, match="before any reset"):
        FrameRenderer(lambda: PAIR).frame()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"white": 256.0}, "white is 256.0; allowed: a grey level 0..255"),
        ({"blur": -1.0}, "blur is -1.0; allowed: a finite number >= 0"),
        ({"grain": math.nan}, "grain is nan"),
        ({"cable_width": 20.0}, "cable_width is 20.0 mm; allowed: up to 17 mm"),
        ({"height": 50.0}, "height is 50.0 mm; allowed: above the markers at 70.0 mm"),
    ],
)
def test_bad_looks(change: dict[str, float], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        replace(LABORATORY, **change)


def test_bad_period() -> None:
    with pytest.raises(ValueError, match=r"period of frames is -1 s; allowed"):
        FrameRenderer(lambda: PAIR, period=-1)
