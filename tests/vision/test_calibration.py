"""Calibration by four and more points, parallax, and lenses."""

import json
import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.vision.calibration import Calibration, CalibrationFit, Lens, fit_calibration, root_mean_square

PICTURE = ((52.0, 431.0), (611.0, 440.0), (560.0, 31.0), (95.0, 40.0))
FLOOR = ((0.0, 0.0), (2400.0, 0.0), (2400.0, 2400.0), (0.0, 2400.0))
TILTED = Calibration(PICTURE, FLOOR)

CALIBRATIONS = [
    TILTED,
    Calibration(PICTURE, FLOOR, (1100.0, 1300.0, 2500.0)),
    Calibration(PICTURE, FLOOR, (1100.0, 1300.0, 2500.0), Lens(-0.1, 0.02)),
]


@pytest.mark.parametrize("calibration", CALIBRATIONS)
@given(u=st.floats(10, 630), v=st.floats(10, 470), height=st.sampled_from([0.0, 70.0, 300.0]))
def test_to_picture_is_the_inverse_of_to_region_and_jacobian_its_derivative(
    calibration: Calibration, u: float, v: float, height: float
) -> None:
    x, y = calibration.to_region(u, v, height)
    assert calibration.to_picture(x, y, height) == pytest.approx((u, v), abs=1e-5)
    step = 1e-4
    for moved, change in zip(((step, 0.0), (0.0, step)), calibration.jacobian(u, v, height).T, strict=True):
        moved_x, moved_y = calibration.to_region(u + moved[0], v + moved[1], height)
        assert ((moved_x - x) / step, (moved_y - y) / step) == pytest.approx(change, abs=1e-4)


PLAIN = Calibration.identity()


@pytest.mark.parametrize("calibration", [*CALIBRATIONS, PLAIN, replace(TILTED, tags={7: (10.25, 20.5)})])
def test_saved_calibration_is_loaded_unchanged(tmp_path: Path, calibration: Calibration) -> None:
    path = tmp_path / "calibration.toml"
    calibration.save(path)
    assert Calibration.load(path) == calibration
    assert ("lens =" in path.read_text(encoding="utf-8")) == (calibration.lens is not None)


def load(path: Path, table: dict[str, object]) -> Calibration:
    path.write_text("\n".join(f"{key} = {json.dumps(value)}" for key, value in table.items()))
    return Calibration.load(path)


def test_whole_numbers_in_a_file_are_accepted(tmp_path: Path) -> None:
    table: dict[str, object] = {
        "picture": [[0, 480], [640, 480], [640, 0], [0, 0]],
        "floor": [[0, 0], [3200, 0], [3200, 2400], [0, 2400]],
    }
    assert load(tmp_path / "whole.toml", table).to_region(10.5, 20.5) == pytest.approx((10.5, 459.5))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"picture": PICTURE[:3]}, "four points"),
        ({"picture": (*PICTURE[:3], (331.0, 436.0))}, r"picture points .*\(331.0, 436.0\) lie on a line"),
        ({"floor": (*FLOOR[:3], (0.0, 0.0, 0.0))}, "2 finite numbers"),
        ({"floor": (*FLOOR[:3], FLOOR[1])}, "floor has the point .* twice"),
        ({"floor": (FLOOR[1], FLOOR[0], FLOOR[3], FLOOR[2])}, "mirrored"),
        ({"floor": (FLOOR[0], FLOOR[2], FLOOR[1], FLOOR[3])}, "crossed"),
        ({"camera": (0.0, 0.0, 0.0)}, r"camera is \(0.0, 0.0, 0.0\).*above 0"),
        ({"camera": (0.0, 0.0)}, "3 finite numbers"),
        ({"hight": 2.0}, r"bad\.toml: calibration\.hight is unknown"),
        ({"floor": None}, r"calibration\.floor is missing"),
        ({"size": [640.5, 480]}, r"size is \(640.5, 480\); allowed: width and height in pixels"),
        ({"size": [8, 8]}, r"size is \(8, 8\); allowed: width and height in pixels, at least 16"),
        ({"tags": 3}, r"calibration\.tags is 3; allowed: a list"),
        ({"lens": [1]}, r"calibration\.lens is \[1\]; allowed: \[k1, k2\]"),
    ],
)
def test_error_in_a_file_is_named(tmp_path: Path, table: dict[str, object], message: str) -> None:
    given = {"picture": PICTURE, "floor": FLOOR} | table
    with pytest.raises(ValueError, match=message):
        load(tmp_path / "bad.toml", {key: value for key, value in given.items() if value is not None})
    (tmp_path / "bad.toml").write_text("picture = [[")
    with pytest.raises(ValueError, match=r"bad\.toml"):
        Calibration.load(tmp_path / "bad.toml")


LENSES = [Lens(-0.0125), Lens(-0.1, 0.02), Lens(0.08)]


@pytest.mark.parametrize("lens", LENSES)
def test_lens_is_opencvs_with_a_focal_length_of_400_pixels_and_is_corrected(lens: Lens) -> None:
    matrix = np.array([[400.0, 0, 320], [0, 400, 240], [0, 0, 1]])
    coefficients = np.array([lens.k1, lens.k2, 0, 0])
    # The corners of the distorted picture show what a lens without distortion shows elsewhere.
    corners = [PLAIN.to_region(*lens.straightened(*corner)) for corner in PLAIN.picture]
    calibration = Calibration(PLAIN.picture, tuple((5 * x, 5 * y) for x, y in corners), lens=lens)
    for u, v in ((0.0, 0.0), (320.0, 240.0), (600.0, 100.0), (50.0, 430.0)):
        ray = np.array([[(u - 320) / 400, (v - 240) / 400, 1.0]])
        shown, _ = cv2.projectPoints(ray, np.zeros(3), np.zeros(3), matrix, coefficients)
        assert lens.distorted(u, v) == pytest.approx(shown.ravel().tolist(), abs=1e-9)
        assert calibration.to_region(*lens.distorted(u, v)) == pytest.approx(PLAIN.to_region(u, v), abs=1e-6)


@pytest.mark.parametrize("k", [(-0.3, 0.0), (math.nan, 0.0), (0.0, math.inf)])
def test_impossible_lens_is_refused(k: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match=r"calibration lens is \(.*\); allowed"):
        Lens(*k)


# ---------------------------------------------------------------- fitting


def fit_through(
    lens: Lens | None, shares: list[tuple[float, float]], noise: float = 0.0, seed: int = 3
) -> tuple[CalibrationFit, float]:
    """A fit to points of the picture, and its greatest error in mm anywhere in the picture."""
    rng = np.random.default_rng(seed)
    # What a camera with a focal length of 700 pixels, 3.5 m above the floor, shows at the corners of the picture.
    turn, _ = cv2.Rodrigues(np.array((0.03, -0.02, 0.04)))
    rays = np.column_stack((np.array(PLAIN.picture) - (320, 240), np.full(4, 700.0))) @ turn
    corners = (3500 * rays[:, :2] / rays[:, 2:] * (1, -1) + (1600, 1200)).tolist()
    true = Calibration(PLAIN.picture, tuple(map(tuple, corners)), lens=lens)
    picture = [(640 * across, 480 * down) for across, down in shares]
    floor = [(5 * x, 5 * y) for x, y in (true.to_region(u, v) for u, v in picture)]
    clicks = [(u + e, v + f) for (u, v), (e, f) in zip(picture, rng.normal(0, noise, (99, 2)), strict=False)]
    fit = fit_calibration(clicks, floor)
    errors = [
        5 * math.dist(fit.calibration.to_region(u, v), true.to_region(u, v))
        for u in range(0, 641, 40)
        for v in range(0, 481, 40)
    ]
    return fit, max(errors)


CORNERS = [(0.05, 0.05), (0.95, 0.05), (0.95, 0.95), (0.05, 0.95)]
GRID = [(0.05 + 0.3 * i, 0.05 + 0.3 * j) for i in range(4) for j in range(4)]


def test_points_on_a_line_are_refused() -> None:
    line = [(0.1 * i, 0.5) for i in range(1, 9)]
    with pytest.raises(ValueError, match=r"calibration points .* fit no camera; allowed: points all over"):
        fit_through(None, [*line, (0.5, 0.9)])


def test_points_that_are_needed_have_no_held_out_error() -> None:
    """Without one of the corners, the other two lie on a line with the middle."""
    fit, _ = fit_through(Lens(-0.05), [*CORNERS, (0.5, 0.5)])
    assert [math.isnan(error) for error in fit.held_out] == [True, True, True, True, False]


@pytest.mark.parametrize("lens", LENSES)
def test_lens_is_found_from_points_all_over_the_picture(lens: Lens) -> None:
    fit, worst = fit_through(lens, GRID)
    assert fit.calibration.lens is not None
    assert fit.calibration.lens.k1 == pytest.approx(lens.k1, abs=0.002)
    assert worst < 0.5
    assert root_mean_square(fit.held_out_without_lens) > 5 > 0.5 > root_mean_square(fit.held_out)


def test_held_out_error_is_as_large_as_the_error_of_clicks() -> None:
    fit, worst = fit_through(Lens(-0.0125), GRID, noise=0.5)
    assert fit.calibration.lens is not None
    assert 2 < root_mean_square(fit.held_out) < 6
    assert worst < 12
    fit, worst = fit_through(None, GRID, noise=0.5)
    assert fit.calibration.lens is None, "nothing is distorted"
    assert worst < 8


def test_distortion_that_no_lens_has_is_not_fitted() -> None:
    """These clicks in the middle of the picture are best explained by a lens that folds the picture's border."""
    middle = [(0.25 + 0.125 * i, 0.25 + 0.5 / 3 * j) for i in range(5) for j in range(4)]
    fit, worst = fit_through(Lens(-0.0125), middle, noise=0.5, seed=11)
    assert fit.calibration.lens is None or fit.calibration.lens.k2 == 0
    assert worst < 40
    assert 2 < root_mean_square(fit.held_out) < 6
    scattered = [(across, down) for across, down in np.random.default_rng(5).uniform(0.05, 0.95, (14, 2)).tolist()]
    fit, _ = fit_through(None, scattered, noise=3.0, seed=5)
    assert fit.calibration.lens is None, "without one of these bad clicks, the best lens is impossible"
