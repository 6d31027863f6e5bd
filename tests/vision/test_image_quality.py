"""The picture's quality, measured and compared with its limits."""

import re
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.vision.image_quality import measure_quality, why_unusable
from khepera_forage.vision.rendering import CameraAppearance
from khepera_forage.vision.scene import Truth
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.tracker_settings import TrackerSettings
from tests.vision.scene_renderer import LABORATORY, NONE, PAIR, Frame, SceneRenderer, render_frame

SETTINGS = TrackerSettings()
MARKERS = ((900.0, 700.0, 0.4, 1), (2200.0, 1500.0, 2.0, 2))
FOODS = ((500.0, 1800.0), (1500.0, 1100.0))


def picture(exposure: float = 1.0, **changes: float) -> Frame:
    frame = SceneRenderer(replace(LABORATORY, **changes)).frame(MARKERS, FOODS)
    return (frame * exposure).clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("changes", "name", "expected", "rel"),
    [
        *(({"blur": blur}, "blur", blur, 0.2) for blur in (0.7, 1.0, 1.4, 1.8, 2.2)),
        *(({"grain": noise}, "noise", noise, 0.25) for noise in (2.5, 8.0, 15.0)),
        *(
            ({"white": 215.0, "floor": floor, "wall": floor}, "contrast", 215 / floor, 0.07)
            for floor in (60.0, 105.0, 155.0)
        ),
        ({"floor": 60.0}, "floor", 60.0, 0.1),
    ],
)
def test_quality_is_measured(changes: dict[str, float], name: str, expected: float, rel: float) -> None:
    assert getattr(measure_quality(picture(**changes)), name) == pytest.approx(expected, rel=rel)


@pytest.mark.parametrize(
    ("changes", "name", "advice"),
    [
        ({"exposure": 1.9}, "exposure", "overexposed.*reduce the camera's exposure"),
        ({"exposure": 0.15}, "exposure", "underexposed.*increase the camera's exposure"),
        ({"white": 215.0, "floor": 150.0}, "contrast", r"tracker's contrast is 1\.4; set it to 1\.[12]"),
        ({"blur": 2.0}, "blur", "focus the lens"),
        ({"grain": 20.0}, "noise", "more light"),
        ({"black": 150.0}, "print", r"holes are 0\.[67]\d times as bright as white.*print the markers black"),
    ],
)
def test_warning_names_the_setting_to_change(changes: dict[str, float], name: str, advice: str) -> None:
    warnings = measure_quality(picture(**changes)).warnings(SETTINGS)
    assert list(warnings) == [name]
    assert re.search(advice, warnings[name])


@pytest.mark.parametrize("grey", [100, 255])
def test_empty_picture_has_unknown_contrast(grey: int) -> None:
    found = measure_quality(np.full((480, 640), grey, np.uint8))
    assert found.contrast is None
    assert found.blur is None
    assert "contrast unknown" in found.described(SETTINGS)


@pytest.mark.parametrize(
    "appearance", [LABORATORY, NONE, replace(LABORATORY, blur=2.5), replace(LABORATORY, grain=12.0)]
)
def test_scene_is_usable(appearance: CameraAppearance) -> None:
    assert why_unusable(render_frame(PAIR, appearance), Tracker(), strict=True) == ""


def test_overexposed_picture_without_markers_and_one_of_a_single_grey_level_are_unusable() -> None:
    frame = (2.0 * render_frame(Truth((), PAIR.foods), LABORATORY)).clip(0, 255).astype(np.uint8)
    assert why_unusable(frame, Tracker(), strict=False).startswith("is overexposed: ")
    noise = np.random.default_rng(0).integers(-5, 1, (480, 640))
    for grey in (5, 100, 250):
        frame = (grey + noise).astype(np.uint8)
        assert why_unusable(frame, Tracker(), strict=False).startswith("shows nothing: all grey levels are ")
