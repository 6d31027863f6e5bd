"""Rendered frames: every object is at its true place."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.vision.rendering import CameraAppearance, FrameRenderer
from khepera_forage.vision.scene import Truth
from khepera_forage.vision.shapes import MARKER_FEATURES, MARKER_FRAME, MARKER_HOLES
from tests.vision.scene_renderer import COLUMN, NONE, PAIR, ROW, centroid, grey_at, render_frame

LABORATORY = CameraAppearance.laboratory()


# ---------------------------------------------------------------- truth


@given(x=st.floats(200, 3000), y=st.floats(200, 2200), heading=st.floats(-math.pi, math.pi))
@settings(max_examples=40, deadline=None)
def test_marker_is_exact_to_a_twentieth_of_a_pixel(x: float, y: float, heading: float) -> None:
    # With everything else black, grey levels are the coverage by the marker's white.
    appearance = replace(NONE, floor=0, black=0, body=0, gripper=0, white=250)
    for holes in (1, 2):
        white = render_frame(Truth(((x, y, heading, holes),), ()), appearance).astype(float) / 250
        ahead = -400 * sum(place[0] for place in MARKER_HOLES[holes]) / (9600 - 400 * holes)
        cx, cy = centroid(white)
        assert cx == pytest.approx(x / 5 + ahead / 5 * math.cos(heading), abs=0.05)
        assert cy == pytest.approx(y / 5 + ahead / 5 * math.sin(heading), abs=0.05)
        assert white.sum() == pytest.approx(MARKER_FEATURES[holes].area, rel=0.01)
        # The long side lies along the heading.
        dx, dy = COLUMN - cx, 480 - ROW - cy
        turn = math.atan2(2 * (white * dx * dy).sum(), (white * (dx * dx - dy * dy)).sum()) / 2
        assert math.sin(turn - heading) == pytest.approx(0, abs=math.radians(0.5))


@given(x=st.floats(100, 3100), y=st.floats(100, 2300))
@settings(max_examples=40, deadline=None)
def test_food_is_exact_to_a_twentieth_of_a_pixel(x: float, y: float) -> None:
    white = render_frame(Truth((), ((x, y),)), replace(NONE, floor=0, white=250)).astype(float) / 250
    assert centroid(white) == pytest.approx((x / 5, y / 5), abs=0.05)
    assert white.sum() == pytest.approx(math.pi * 3.5**2, rel=0.01)


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
    bare = render_frame(Truth(((1000.0, 1000.0, 0.7, 2),), ()))
    assert np.array_equal(bare, render_frame(Truth(((1000.0, 1000.0, 0.7, 2),), ((1010.0, 995.0),))))
    # Food in the gripper is partly ahead of the marker.
    assert (
        bare != render_frame(Truth(((1000.0, 1000.0, 0.7, 2),), ((1000 + 56 * 0.77, 1000 + 56 * 0.64),)))
    ).any()


def test_objects_at_the_border_are_cut_off() -> None:
    frame = render_frame(
        Truth(((0.0, 0.0, 0.4, 2), (-500.0, 1000.0, 0.0, 1)), ((3200.0, 2400.0), (9000.0, 0.0)))
    )
    assert frame[0, 639] > 200
    assert frame[479 - 6, 2] > 200 or frame[479, 0] > 200
    quarter = (
        render_frame(Truth((), ((3200.0, 1200.0),)), replace(NONE, floor=0, white=250)).astype(float) / 250
    )
    assert quarter.sum() == pytest.approx(math.pi * 3.5**2 / 2, rel=0.02)


# ---------------------------------------------------------------- markers


# ---------------------------------------------------------------- source, and bad input


def test_frame_before_reset_is_refused() -> None:
    with pytest.raises(RuntimeError, match="before any reset"):
        FrameRenderer(lambda: PAIR).frame()


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


def test_invalid_period_is_refused() -> None:
    with pytest.raises(ValueError, match=r"period of frames is -1 s; allowed"):
        FrameRenderer(lambda: PAIR, period=-1)
