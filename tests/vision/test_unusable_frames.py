"""Frames that show no scene are recognised; difficult frames are still used."""

from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.scene import Truth
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.unusable_frames import is_well_exposed, why_unusable
from tests.vision.scene_renderer import PAIR, Frame, render_frame

LABORATORY = CameraAppearance.laboratory()


def scene(appearance: CameraAppearance = LABORATORY) -> Frame:
    return render_frame(PAIR, appearance)


def brighter(factor: float, truth: Truth = PAIR) -> Frame:
    return np.asarray(np.clip(render_frame(truth, LABORATORY) * factor, 0, 255), np.uint8)


@pytest.mark.parametrize(
    "appearance",
    [LABORATORY, CameraAppearance.none(), replace(LABORATORY, blur=2.5), replace(LABORATORY, grain=12.0)],
    ids=["laboratory", "no noise", "blurred", "noisy"],
)
def test_scene_is_usable(appearance: CameraAppearance) -> None:
    assert why_unusable(scene(appearance), Tracker(), strict=True) == ""


@pytest.mark.parametrize("grey", [0, 100, 255])
def test_picture_of_one_grey_level_shows_nothing(grey: int) -> None:
    noise = np.random.default_rng(0).integers(0, 6, (480, 640)).astype(np.uint8)
    frame = np.clip(np.full((480, 640), grey, np.uint8), 5, 250) + noise - 5
    assert why_unusable(frame, Tracker(), strict=False).startswith("shows nothing: all grey levels are ")


def test_exposure_beyond_its_limits_is_unusable_after_a_good_frame() -> None:
    """At twice the exposure the tracker finds the markers, but no food."""
    bright = brighter(2.0)
    assert not is_well_exposed(bright)
    assert is_well_exposed(scene())
    assert any(found.holes for found in Tracker().detect(bright))
    assert why_unusable(bright, Tracker(), strict=True).startswith("is overexposed: ")
    assert why_unusable(bright, Tracker(), strict=False) == "", "as the user has set up the camera"


def test_overexposed_picture_without_markers_is_unusable() -> None:
    frame = brighter(2.0, Truth((), PAIR.foods))
    assert why_unusable(frame, Tracker(), strict=False).startswith("is overexposed: ")
