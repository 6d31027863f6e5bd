"""`khepera-forage camera calibrate`: four points of the picture and their places on the floor."""

import argparse
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.camera_preview import described
from khepera_forage.cli.camera_source import add_source_arguments, open_source
from khepera_forage.cli.camera_window import PictureWindow
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

if TYPE_CHECKING:
    from khepera_forage.vision.calibration import Calibration
    from khepera_forage.vision.video import FrameSource

Spot = tuple[float, float]
_FORM = "u,v=x,y with u, v in pixels from the upper left corner and x, y in mm"
_PAUSE = 0.02
"""Seconds between two pictures of the window."""
_MARK = (255, 60, 60)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The task's arguments."""
    add_source_arguments(parser)
    given = parser.add_mutually_exclusive_group(required=True)
    given.add_argument(
        "--points",
        nargs="+",
        metavar="U,V=X,Y",
        help="four points or more: pixels from the picture's upper left corner = mm on the floor",
    )
    given.add_argument(
        "--places",
        nargs="+",
        metavar="X,Y",
        help="four places or more on the floor in mm, to be clicked in a window in this order",
    )
    parser.add_argument(
        "--camera",
        metavar="X,Y,HEIGHT",
        help="where the camera hangs, in mm: corrects that high things lean outwards (not corrected)",
    )
    parser.add_argument(
        "--check", action="store_true", help="look through the camera, and tell what it sees where"
    )
    parser.add_argument("--out", type=Path, default=Path("calibration.toml"), help="file (calibration.toml)")


def run(arguments: argparse.Namespace) -> int:
    """Calibrate, print how well the points fit, and write the file.

    Raises:
        ValueError: Points that cannot be read or that no camera can have, or a window that was closed early.
        OSError: The camera cannot be opened, or the file not written.
        ImportError: OpenCV is not installed.
    """
    camera = _numbers("--camera", arguments.camera, 3) if arguments.camera else None
    source = open_source(arguments, paced=False) if arguments.places or arguments.check else None
    try:
        if arguments.places:
            floor = [_spot("--places", text) for text in arguments.places]
            _check_count("--places", len(floor))
            assert source is not None
            picture = _clicked(source, floor)
        else:
            picture, floor = _points(arguments.points)
        calibration = fitted(picture, floor, camera)
        _tell(calibration, picture, floor)
        if arguments.check:
            assert source is not None
            _look(source, calibration)
    finally:
        if source is not None:
            source.close()
    calibration.save(arguments.out)
    print(f"written to {arguments.out}")
    return 0


def fitted(picture: Sequence[Spot], floor: Sequence[Spot], camera: Sequence[float] | None) -> "Calibration":
    """The calibration that fits the points best: exactly for four, in the least squares for more.

    Args:
        picture: Pixels (u, v).
        floor: The same points in mm.
        camera: Its place x, y and height in mm, or None.

    Raises:
        ValueError: Points that no camera can have.
        ImportError: OpenCV is not installed.
    """
    from khepera_forage.vision.calibration import Calibration

    place = None if camera is None else (camera[0], camera[1], camera[2])
    if len(picture) == 4:
        return Calibration(tuple(picture), tuple(floor), place)
    import cv2

    matrix, _ = cv2.findHomography(np.array(picture, float), np.array(floor, float))
    if matrix is None:
        raise ValueError(
            f"calibration points {list(picture)} fit no camera; allowed: points all over the picture"
        )
    # What a file keeps are four points: the corners of the picture, and where the fit has them.
    corners = ((0.0, 0.0), (PICTURE_WIDTH, 0.0), (PICTURE_WIDTH, PICTURE_HEIGHT), (0.0, PICTURE_HEIGHT))
    places = cv2.perspectiveTransform(np.array([corners]), matrix)[0].tolist()
    return Calibration(corners, tuple((x, y) for x, y in places), place)


def residuals(calibration: "Calibration", picture: Sequence[Spot], floor: Sequence[Spot]) -> list[float]:
    """How far in mm each point's place is from where the calibration has it."""
    found = [calibration.to_region(u, v) for u, v in picture]
    return [
        math.hypot(x * MM_PER_PIXEL - place[0], y * MM_PER_PIXEL - place[1])
        for (x, y), place in zip(found, floor, strict=True)
    ]


def _tell(calibration: "Calibration", picture: Sequence[Spot], floor: Sequence[Spot]) -> None:
    errors = residuals(calibration, picture, floor)
    for (u, v), (x, y), error in zip(picture, floor, errors, strict=True):
        print(f"pixel ({u:.1f}, {v:.1f}) is ({x:.0f}, {y:.0f}) mm: {error:.1f} mm off")
    note = "; four points always fit: give more to see how well" if len(errors) == 4 else ""
    mean = math.sqrt(sum(error * error for error in errors) / len(errors))
    print(f"residual {mean:.1f} mm (root mean square), {max(errors):.1f} mm at most{note}")
    middle = calibration.stretch(PICTURE_WIDTH / 2, PICTURE_HEIGHT / 2)
    print(f"a pixel in the middle is {MM_PER_PIXEL * math.sqrt(middle.area):.2f} mm wide")


def _look(source: "FrameSource", calibration: "Calibration") -> None:
    from khepera_forage.vision.tracker import Tracker

    scene = Tracker(calibration=calibration).update(source.newest()[0])
    print(f"seen now: {described(scene)}")


def _clicked(source: "FrameSource", floor: Sequence[Spot]) -> list[Spot]:
    """Where in the window each place was clicked."""
    title = "khepera-forage camera calibrate"
    window = PictureWindow.open(title, int(PICTURE_WIDTH), int(PICTURE_HEIGHT))
    if window is None:
        raise ValueError("--places needs a display and pygame (extra render); allowed without: --points")
    spots: list[Spot] = []
    try:
        frame = source.newest()[0]
        while len(spots) < len(floor):
            x, y = floor[len(spots)]
            window.title(f"click the place at ({x:g}, {y:g}) mm")
            spots += window.show(_marked(frame, spots))[: len(floor) - len(spots)]
            if window.closed:
                raise ValueError(
                    f"window closed after {len(spots)} clicks; allowed: one for each of --places"
                )
            time.sleep(_PAUSE)
            frame = source.newest()[0]
    finally:
        window.close()
    return spots


def _marked(frame: NDArray[np.uint8], spots: Sequence[Spot]) -> NDArray[np.uint8]:
    """A frame in colour with a cross where each click was."""
    picture = np.repeat(frame[:, :, None], 3, axis=2)
    for u, v in spots:
        row, column = int(v), int(u)
        picture[row, max(0, column - 6) : column + 7] = _MARK
        picture[max(0, row - 6) : row + 7, column] = _MARK
    return picture


def _points(texts: Sequence[str]) -> tuple[list[Spot], list[Spot]]:
    picture, floor = [], []
    for text in texts:
        pixels, equals, mm = text.partition("=")
        if not equals:
            raise ValueError(f"--points has {text!r}; allowed: {_FORM}")
        picture.append(_spot("--points", pixels))
        floor.append(_spot("--points", mm))
    _check_count("--points", len(picture))
    return picture, floor


def _check_count(name: str, count: int) -> None:
    if count < 4:
        raise ValueError(f"{name} has {count} points; allowed: four or more")


def _spot(name: str, text: str) -> Spot:
    x, y = _numbers(name, text, 2)
    return x, y


def _numbers(name: str, text: str, count: int) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ValueError(f"{name} has {text!r}; allowed: {count} numbers with commas between")
    return values
