"""Rendered frames: every object is at its true place, under noise, uneven light and cables."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.vision.rendering import FrameRenderer
from khepera_forage.vision.scene import Truth
from khepera_forage.vision.shapes import MARKER_FRAME, MARKER_HOLES
from tests.vision.scene_renderer import LABORATORY, NONE, PAIR, Frame, render_frame, render_frames


def grey_at(frame: Frame, x: float, y: float) -> int:
    """The grey level at a place in mm."""
    return int(frame[479 - int(y / 5), int(x / 5)])


def test_parts_of_a_robot_are_at_their_places() -> None:
    frame = render_frame(Truth(((1000.0, 1000.0, 0.0, 1),), ()))
    hole = (1000 + MARKER_HOLES[1][0][0], 1000 + MARKER_HOLES[1][0][1])
    assert grey_at(frame, *hole) == NONE.black
    assert np.array_equal(frame, render_frame(Truth(((1000.0, 1000.0, 0.0, 1),), (hole,)))), "food below it is hidden"
    assert grey_at(frame, 950, 1000) == NONE.white
    assert grey_at(frame, 1000, 1000 + 40 + MARKER_FRAME / 2) < 60, "the frame"
    finger = [grey_at(frame, 1071, 1000 + side * 29.5) for side in (-1, 1)]
    assert all(level < 95 for level in finger), "the fingers stick out"
    assert grey_at(frame, 1071, 1000) == NONE.floor, "between the fingers is floor"
    assert grey_at(frame, 1100, 1000) == NONE.floor


def test_objects_at_the_border_are_cut_off() -> None:
    frame = render_frame(Truth(((0.0, 0.0, 0.4, 2), (-500.0, 1000.0, 0.0, 1)), ((3200.0, 2400.0), (9000.0, 0.0))))
    assert frame[0, 639] > 200
    assert frame[479 - 6, 2] > 200 or frame[479, 0] > 200
    quarter = render_frame(Truth((), ((3200.0, 1200.0),)), replace(NONE, floor=0, white=250)).astype(float) / 250
    assert quarter.sum() == pytest.approx(math.pi * 3.5**2 / 2, rel=0.02)


def test_frame_before_reset_and_invalid_period_are_refused() -> None:
    with pytest.raises(RuntimeError, match="before any reset"):
        FrameRenderer(lambda: PAIR).frame()
    with pytest.raises(ValueError, match=r"period of frames is -1 s; allowed"):
        FrameRenderer(lambda: PAIR, period=-1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"white": 256.0}, "white is 256.0; allowed: a grey level 0..255"),
        ({"blur": -1.0}, "blur is -1.0; allowed: a finite number >= 0"),
        ({"grain": math.nan}, "grain is nan"),
        ({"cable_width": 50.0}, "cable_width is 50.0 mm; allowed: up to 40 mm"),
        ({"height": 50.0}, "height is 50.0 mm; allowed: above the markers at 70.0 mm"),
    ],
)
def test_invalid_appearance_is_refused(change: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(LABORATORY, **change)


def test_noise_is_independent_and_has_its_size() -> None:
    frames = np.array(render_frames(Truth((), ()), replace(NONE, grain=4.0), 30), float)
    assert frames.std() == pytest.approx(4.0, rel=0.03)
    assert frames.mean() == pytest.approx(NONE.floor, abs=0.05)
    # From pixel to pixel, and from frame to frame.
    errors = frames - NONE.floor
    for a, b in ((errors[:, 1:], errors[:, :-1]), (errors[:, :, 1:], errors[:, :, :-1]), (errors[1:], errors[:-1])):
        assert abs((a * b).mean()) < 0.02 * 16


def test_light_falls_off_to_the_corners_and_drifts() -> None:
    appearance = replace(NONE, vignette=0.2)
    corner, centre = render_frame(Truth((), ()), appearance)[[0, 240], [0, 320]].tolist()
    assert corner == pytest.approx(0.8 * centre, abs=1)
    appearance = replace(NONE, gradient=0.1)
    frame = render_frame(Truth((), ()), appearance).astype(float)
    assert frame.max() - frame.min() > 0.1 * NONE.floor
    appearance = replace(NONE, drift=0.1)
    levels = [float(frame.mean()) for frame in render_frames(Truth((), ()), appearance, 600)]
    assert max(levels) - min(levels) > 0.05 * NONE.floor
    assert max(abs(b - a) for a, b in itertools.pairwise(levels)) < 1.0, "slowly"


def test_cable_runs_from_anchor_to_robot_over_all_but_its_own_marker() -> None:
    truth = Truth(((500.0, 1000.0, 0.0, 1), (1200.0, 1000.0, math.pi / 2, 2)), ((900.0, 1000.0),))
    straight = replace(NONE, cable_width=5.0, cable_sag=0.0, cable_sway=0.0)
    frame, bare = (render_frame(truth, appearance, anchor=(2000.0, 1000.0)) for appearance in (straight, NONE))
    assert np.array_equal(bare, render_frame(truth, NONE))
    # It covers about half of each pixel, from the anchor over the other robot and the food to the marker's frame.
    assert (frame[279, 114:399] != bare[279, 114:399]).all()
    assert min(frame[279, 180], frame[279, 235]) < 200 < bare[279, [180, 235]].min(), "white"
    assert np.array_equal(frame[:, :112], bare[:, :112]), "its own marker is clear"
    assert np.array_equal(frame[:, 402:], bare[:, 402:]), "beyond the anchor"


def test_cables_sag_and_sway_slowly() -> None:
    renderer = FrameRenderer(lambda: PAIR, replace(NONE, cable_width=4.0), (2000.0, 1000.0))
    renderer.reset(np.random.default_rng(0))
    heights = []
    for _ in range(100):
        renderer.frame()
        curve = renderer.cables[0]
        heights.append(float(curve[len(curve) // 2, 1]))
    assert (curve[0].tolist(), curve[-1].tolist()) == ([400, 200], [80, 60])
    assert max(heights) - min(heights) > 3
    assert max(abs(b - a) for a, b in itertools.pairwise(heights)) < 1.5
    assert abs(np.mean(heights) - 130) > 5
