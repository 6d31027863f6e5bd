"""Rendered frames: every object is at its true place, under noise, uneven light and cables."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.vision.rendering import CameraAppearance, FrameRenderer
from khepera_forage.vision.scene import Truth
from khepera_forage.vision.shapes import MARKER_FRAME, MARKER_HOLES
from tests.vision.scene_renderer import COLUMN, LABORATORY, NONE, PAIR, ROW, Frame, render_frame, render_frames

Floats = NDArray[np.float64]


def grey_at(frame: Frame, x: float, y: float) -> int:
    """The grey level at a place in mm."""
    return int(frame[479 - int(y / 5), int(x / 5)])


def test_parts_of_a_robot_are_at_their_places() -> None:
    frame = render_frame(Truth(((1000.0, 1000.0, 0.0, 1),), ()))
    hole = MARKER_HOLES[1][0]
    assert grey_at(frame, 1000 + hole[0], 1000 + hole[1]) == NONE.black
    assert grey_at(frame, 950, 1000) == NONE.white
    assert grey_at(frame, 1000, 1000 + 40 + MARKER_FRAME / 2) < 60, "the frame"
    finger = [grey_at(frame, 1071, 1000 + side * 29.5) for side in (-1, 1)]
    assert all(level < 95 for level in finger), "the fingers stick out"
    assert grey_at(frame, 1071, 1000) == NONE.floor, "between the fingers is floor"
    assert grey_at(frame, 1100, 1000) == NONE.floor


def test_food_under_a_marker_is_hidden() -> None:
    marker = ((1000.0, 1000.0, 0.7, 2),)
    bare = render_frame(Truth(marker, ()))
    assert np.array_equal(bare, render_frame(Truth(marker, ((1010.0, 995.0),))))
    # Food in the gripper is partly ahead of the marker.
    assert (bare != render_frame(Truth(marker, ((1000 + 56 * 0.77, 1000 + 56 * 0.64),)))).any()


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


def test_same_seed_gives_the_same_frames() -> None:
    anchor = (650.0, 500.0)
    first, again, other = (render_frames(PAIR, LABORATORY, 4, seed, anchor) for seed in (1, 1, 2))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not any(np.array_equal(a, b) for a, b in zip(first, other, strict=True))
    assert not np.array_equal(first[0], first[1])


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


TO_THE_LEFT = Truth(((500.0, 1000.0, 0.3, 2),), ())
ANCHOR = (2000.0, 1000.0)


def with_cables(appearance: CameraAppearance, frames: int = 1) -> Iterator[tuple[Frame, list[Floats]]]:
    """Frames, and the cables in each, in pixels."""
    renderer = FrameRenderer(lambda: TO_THE_LEFT, appearance, ANCHOR)
    assert renderer.cables == []
    renderer.reset(np.random.default_rng(0))
    for _ in range(frames):
        yield renderer.frame(), renderer.cables


def test_cable_runs_from_anchor_to_robot_but_not_over_its_marker() -> None:
    ((frame, (curve,)),) = with_cables(replace(NONE, cable_width=4.0))
    assert curve[0] == pytest.approx((400, 200)), "at the anchor"
    assert curve[-1] == pytest.approx((100, 200)), "under the marker"
    for x, y in curve[:-3]:
        assert frame[479 - int(y), int(x)] < NONE.floor - 5
    bare = render_frame(TO_THE_LEFT, NONE)
    x, y = COLUMN - 100, 480 - ROW - 200
    ahead, aside = x * math.cos(0.3) + y * math.sin(0.3), y * math.cos(0.3) - x * math.sin(0.3)
    own = (np.abs(ahead) < 12) & (np.abs(aside) < 8)
    assert np.array_equal(frame[own], bare[own]), "its own marker is clear"
    changed = np.argwhere(frame != bare)
    assert np.hypot(*(changed - (280, 100)).T).min() < 16, "up to the marker's rim"
    ((frame, cables),) = with_cables(NONE)
    assert cables == []
    assert np.array_equal(frame, bare)


def test_cables_sway_slowly() -> None:
    frames = with_cables(replace(NONE, cable_width=4.0), 100)
    heights = [float(curve[len(curve) // 2, 1]) for _, (curve,) in frames]
    assert max(heights) - min(heights) > 3
    assert max(abs(b - a) for a, b in itertools.pairwise(heights)) < 1.5
    assert abs(np.mean(heights) - 200) > 5, "sag to one side"


def test_cable_covers_other_markers_and_food() -> None:
    appearance = replace(NONE, cable_width=5.0, cable_sag=0.0, cable_sway=0.0)
    truth = Truth(((500.0, 1000.0, 0.0, 1), (1200.0, 1000.0, math.pi / 2, 2)), ((900.0, 1000.0),))
    frame = render_frame(truth, appearance, anchor=(2000.0, 1000.0))
    # The cable covers about half of a pixel.
    assert frame[280:282, 180].min() < 200, "over the food"
    assert frame[278:282, 235].min() < 200, "over the other robot's marker"
    across = [grey_at(frame, 1200, y) for y in range(970, 1035, 5)]
    assert min(across) < 200 < max(across)
