"""The page to print: sizes as in figure 3.9, and markers that the tracker recognises."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from khepera_forage.cli.main import main
from khepera_forage.vision.marker_sheets import DPI, PAGE_HEIGHT, PAGE_WIDTH, marker_pages, save_pages, tag_pages
from khepera_forage.vision.tracker import Tracker

INCH = 25.4  # mm


def test_markers_have_their_true_size(tmp_path: Path) -> None:
    """Lines of pixels across marker 1: black, white and black again, each as long in mm as in figure 3.9."""
    with Image.open(save_pages(tmp_path / "markers.png", marker_pages())) as image:
        black = np.asarray(image.convert("L")) < 128

    def edges(pixels: NDArray[np.bool_]) -> NDArray[np.float64]:
        return np.flatnonzero(np.diff(pixels)) * INCH / DPI

    down, across = black[:, round(105 * DPI / INCH)], black[round(68 * DPI / INCH)]
    assert edges(down[: round(118 * DPI / INCH)])[-4:] == pytest.approx([20, 28, 108, 116], abs=0.1)
    assert edges(across[: round(174 * DPI / INCH)]) == pytest.approx([37, 45, 120, 140, 165, 173], abs=0.1)


@pytest.mark.parametrize("kind", ["svg", "png", "pdf"])
def test_every_format_is_an_a4_page(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"markers.{kind}"
    assert main(["camera", "markers", "--out", str(path)]) == 0
    if kind == "png":
        with Image.open(path) as image:
            assert image.info["dpi"] == pytest.approx((DPI, DPI), rel=1e-4)
            size = [side / DPI * INCH for side in image.size]
    elif kind == "svg":
        root = ElementTree.parse(path).getroot()
        size = [float(root.attrib[side].removesuffix("pt")) / 72 * INCH for side in ("width", "height")]
    else:
        box = path.read_bytes().partition(b"/MediaBox [")[2].partition(b"]")[0].split()
        size = [float(side) / 72 * INCH for side in box[2:]]
    assert size == pytest.approx([PAGE_WIDTH, PAGE_HEIGHT], abs=0.1)


def test_tracker_recognises_the_printed_markers(tmp_path: Path) -> None:
    """The printed page, cut along the frames, on a grey floor, at 5 mm per pixel."""
    with Image.open(save_pages(tmp_path / "markers.png", marker_pages())) as image:
        page = np.asarray(image.convert("L"))
    scale = DPI / INCH
    floor = np.full((480 * 8, 640 * 8), 105, np.uint8)
    for row, (x, y) in enumerate(((1000, 1000), (2000, 1400))):
        top, left = 68 + row * 118 - 48, 105 - 68
        printed = page[int(top * scale) : int((top + 96) * scale), int(left * scale) : int((left + 136) * scale)]
        small = cv2.resize(printed, (round(136 * 8 / 5), round(96 * 8 / 5)), interpolation=cv2.INTER_AREA)
        height, width = small.shape
        up, across = round((2400 - y) * 8 / 5 - height / 2), round(x * 8 / 5 - width / 2)
        floor[up : up + height, across : across + width] = np.clip(small, 25, 225)
    frame = cv2.resize(floor, (640, 480), interpolation=cv2.INTER_AREA)
    detections = {d.holes: d for d in Tracker().detect(np.asarray(frame, np.uint8))}
    assert sorted(detections) == [1, 2]
    for holes, (x, y) in ((1, (1000, 1000)), (2, (2000, 1400))):
        assert (detections[holes].x, detections[holes].y) == pytest.approx((x / 5, y / 5), abs=0.3)
        assert (detections[holes].orientation + 180) % 360 - 180 == pytest.approx(0, abs=2)


def test_printed_tags_have_their_true_size(tmp_path: Path) -> None:
    """OpenCV finds them on the page, with corners where they should be."""
    (page,) = tag_pages((1, 7), (), (), 80.0, 24.0)
    with Image.open(save_pages(tmp_path / "tags.png", [page])) as image:
        picture = cv2.resize(np.asarray(image.convert("L")), None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    corners, ids, _ = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)).detectMarkers(
        picture
    )
    assert sorted(ids.ravel().tolist()) == [1, 7]
    for c in corners:
        sides = np.hypot(*(np.roll(c[0], 1, axis=0) - c[0]).T) * INCH / (DPI / 4)
        assert sides == pytest.approx(80.0, abs=0.5)


def test_greatest_tag_has_a_page_of_its_own() -> None:
    assert len(tag_pages((1, 2), (), (), 170.0, 24.0)) == 2
