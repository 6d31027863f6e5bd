"""Disturbances of rendered frames: noise, light, blur, parallax and cables."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.vision.rendering import CameraAppearance, FrameRenderer
from khepera_forage.vision.scene import Truth
from tests.vision.scene_renderer import (
    NONE,
    PAIR,
    Frame,
    grey_at,
    render_frame,
    render_frames,
)

LABORATORY = CameraAppearance.laboratory()


def test_same_seed_gives_the_same_frames() -> None:
    anchor = (650.0, 500.0)
    first, again, other = (render_frames(PAIR, LABORATORY, 4, seed, anchor) for seed in (1, 1, 2))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not any(np.array_equal(a, b) for a, b in zip(first, other, strict=True))
    assert not np.array_equal(first[0], first[1])


def test_noise_is_independent_and_has_its_size() -> None:
    frames = np.array(render_frames(Truth((), ()), replace(NONE, grain=4.0), 60), float)
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


# ---------------------------------------------------------------- cables


def change_by_cables(
    truth: Truth, appearance: CameraAppearance, anchor: tuple[float, float], frames: int = 1
) -> list[Frame]:
    """Absolute change of every pixel by the cables, frame by frame."""
    bare = render_frame(truth, NONE).astype(int)
    return [np.abs(frame - bare) for frame in render_frames(truth, appearance, frames, anchor=anchor)]


def test_cable_runs_from_anchor_to_robot_but_not_over_its_marker() -> None:
    truth, anchor = Truth(((1000.0, 1000.0, 0.3, 2),), ()), (2000.0, 1500.0)
    (change,) = change_by_cables(truth, replace(NONE, cable_width=4.0), anchor)
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


def test_cable_covers_other_markers_and_food() -> None:
    appearance = replace(NONE, cable_width=5.0, cable_sag=0.0, cable_sway=0.0)
    truth = Truth(((500.0, 1000.0, 0.0, 1), (1200.0, 1000.0, math.pi / 2, 2)), ((900.0, 1000.0),))
    frame = render_frame(truth, appearance, anchor=(2000.0, 1000.0))
    # The cable covers about half of a pixel.
    assert frame[280:282, 180].min() < 200, "over the food"
    assert frame[278:282, 235].min() < 200, "over the other robot's marker"
    across = [grey_at(frame, 1200, y) for y in range(970, 1035, 5)]
    assert min(across) < 200 < max(across)


def test_cables_property_matches_the_frame() -> None:
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
    changes = change_by_cables(truth, replace(NONE, cable_width=4.0), anchor, 100)
    heights = []
    for change in changes:
        column = change[:, 250].astype(float)
        heights.append(float((column * (np.arange(480) + 0.5)).sum() / column.sum()))
    assert max(heights) - min(heights) > 3
    assert max(abs(b - a) for a, b in itertools.pairwise(heights)) < 1.5
    assert abs(np.mean(heights) - 280) > 5, "sag to one side"
