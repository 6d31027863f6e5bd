"""Calibration by four points, and parallax."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.vision.calibration import Calibration, Lens

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
    (xu, xv, yu, yv), step = calibration.jacobian(u, v, height), 1e-4
    for (du, dv), change in {(step, 0.0): (xu, yu), (0.0, step): (xv, yv)}.items():
        moved_x, moved_y = calibration.to_region(u + du, v + dv, height)
        assert ((moved_x - x) / step, (moved_y - y) / step) == pytest.approx(change, abs=1e-4)


def test_four_points_map_to_each_other() -> None:
    for point, place in zip(PICTURE, FLOOR, strict=True):
        assert TILTED.to_region(*point) == pytest.approx((place[0] / 5, place[1] / 5), abs=1e-6)
        assert TILTED.to_picture(place[0] / 5, place[1] / 5) == pytest.approx(point, abs=1e-6)


def test_parallax_follows_similar_triangles() -> None:
    """With a camera 2 m high, a point 200 mm high appears 10/9 as far from the point below the camera."""
    calibration = Calibration.identity((1600.0, 1200.0, 2000.0))
    assert calibration.to_region(320 + 100, 240, 200) == pytest.approx((320 + 90, 240))
    assert calibration.to_region(320, 240 - 100, 200) == pytest.approx((320, 240 + 90))
    assert calibration.to_region(320 + 100, 240) == pytest.approx((420, 240))
    assert Calibration.identity().to_region(320 + 100, 240, 200) == pytest.approx((420, 240))


@pytest.mark.parametrize("camera", [None, (1234.5, 678.25, 2600.0)])
def test_saved_calibration_is_loaded_unchanged(
    tmp_path: Path, camera: tuple[float, float, float] | None
) -> None:
    calibration = Calibration(PICTURE, FLOOR, camera)
    calibration.save(tmp_path / "calibration.toml")
    assert Calibration.load(tmp_path / "calibration.toml") == calibration
    assert Calibration.from_table(calibration.as_table()) == calibration


def test_whole_numbers_in_a_file_are_accepted() -> None:
    table = {
        "picture": [[0, 480], [640, 480], [640, 0], [0, 0]],
        "floor": [[0, 0], [3200, 0], [3200, 2400], [0, 2400]],
    }
    assert Calibration.from_table(table).to_region(10.5, 20.5) == pytest.approx((10.5, 459.5))


@pytest.mark.parametrize(
    ("picture", "floor", "camera", "message"),
    [
        (PICTURE[:3], FLOOR, None, "four points"),
        (PICTURE, (*FLOOR[:3], (0.0, math.nan)), None, r"floor point is \(0.0, nan\)"),
        (PICTURE, (*FLOOR[:3], (0.0, 0.0, 0.0)), None, "2 finite numbers"),
        (PICTURE, (*FLOOR[:3], FLOOR[1]), None, r"floor has the point \(2400.0, 0.0\) twice"),
        ((*PICTURE[:3], (331.0, 436.0)), FLOOR, None, r"picture points .*\(331.0, 436.0\) lie on a line"),
        (PICTURE, (FLOOR[1], FLOOR[0], FLOOR[3], FLOOR[2]), None, "mirrored"),
        (PICTURE, (FLOOR[0], FLOOR[2], FLOOR[1], FLOOR[3]), None, "crossed"),
        (PICTURE, FLOOR, (0.0, 0.0, 0.0), r"camera is \(0.0, 0.0, 0.0\).*above 0"),
        (PICTURE, FLOOR, (0.0, 0.0), "3 finite numbers"),
    ],
)
def test_impossible_points_are_refused(picture: object, floor: object, camera: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Calibration.from_table({"picture": picture, "floor": floor, "camera": camera})


def test_error_in_a_table_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'hight' is unknown"):
        Calibration.from_table({"picture": PICTURE, "floor": FLOOR, "hight": 2.0})
    with pytest.raises(ValueError, match="no 'floor'"):
        Calibration.from_table({"picture": PICTURE})
    path = tmp_path / "bad.toml"
    path.write_text("picture = [[")
    with pytest.raises(ValueError, match=r"bad\.toml"):
        Calibration.load(path)
