"""`khepera-forage camera calibrate`: compute a calibration from points in the picture and on the floor."""

import argparse
import math
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.arguments import add_out_argument
from khepera_forage.cli.camera.preview import described
from khepera_forage.cli.camera.source import add_source_arguments, open_source
from khepera_forage.cli.camera.window import PictureWindow
from khepera_forage.extras import require
from khepera_forage.vision.lens import DEFAULT_SIZE

if TYPE_CHECKING:
    from khepera_forage.vision.calibration import Calibration
    from khepera_forage.vision.calibration_fit import CalibrationFit
    from khepera_forage.vision.video import FrameSource

Point = tuple[float, float]
_POINT_FORMAT = "u,v=x,y with u, v in pixels from the upper left corner and x, y in mm"
_PAUSE = 0.02
"""Seconds between two pictures of the window."""
_CROSS_COLOUR = (255, 60, 60)
"""Red, of the cross at each clicked point."""
_ENOUGH_COVERAGE = 0.5
"""Share of the picture within the points from which the held-out error holds for most of the picture."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_source_arguments(parser)
    given = parser.add_mutually_exclusive_group(required=True)
    given.add_argument(
        "--points",
        nargs="+",
        metavar="U,V=X,Y",
        help="four or more points: pixels from the picture's upper left corner = mm on the floor; twelve all over the "
        "picture calibrate the lens, too",
    )
    given.add_argument(
        "--places",
        nargs="+",
        metavar="X,Y",
        help="four or more places on the floor in mm, which you then click in a window in this order; twelve all over "
        "the picture calibrate the lens, too",
    )
    given.add_argument(
        "--tags",
        nargs="+",
        metavar="ID=X,Y",
        help="four or more tags on the floor, better twelve, and the place of the middle of each in mm: nothing "
        "to click, and the camera is watched from then on",
    )
    parser.add_argument(
        "--camera",
        metavar="X,Y,HEIGHT",
        help="position of the camera in mm, to correct the shift of markers above the floor (no correction)",
    )
    parser.add_argument(
        "--check", action="store_true", help="take a picture and print the regions found in it, in mm"
    )
    add_out_argument(parser, "calibration.toml", "file")


def run(arguments: argparse.Namespace) -> int:
    """Calibrate, print how well the points fit, and write the file.

    Raises:
        ValueError: Points cannot be read or fit no camera, or the window was closed before the last click.
        OSError: The camera cannot be opened, or the file cannot be written.
        ImportError: OpenCV is not installed.
    """
    require("khepera-forage camera calibrate", "camera")
    from khepera_forage.vision.calibration_fit import fit_calibration

    camera = None
    if arguments.camera:
        x, y, height = _numbers("--camera", arguments.camera, 3)
        camera = (x, y, height)
    by_camera = arguments.places or arguments.tags or arguments.check
    source = open_source(arguments, paced=False) if by_camera else None
    try:
        size = arguments.size or DEFAULT_SIZE
        if source is not None:
            height, width = source.newest()[0].shape
            size = (width, height)
        if arguments.tags:
            assert source is not None
            fit, picture, floor = _fit_to_tags(source, arguments.tags, camera, size)
        elif arguments.places:
            floor = [_point("--places", text) for text in arguments.places]
            _check_count("--places", len(floor))
            assert source is not None
            picture = _clicked_points(source, floor)
        else:
            picture, floor = _points(arguments.points)
        if not arguments.tags:
            fit = fit_calibration(picture, floor, camera, size)
        calibration = fit.calibration
        _print_errors(fit, picture, floor)
        if arguments.check:
            assert source is not None
            _print_regions(source, calibration)
    finally:
        if source is not None:
            source.close()
    calibration.save(arguments.out)
    print(f"written to {arguments.out}")
    return 0


def _fit_to_tags(
    source: "FrameSource",
    texts: Sequence[str],
    camera: tuple[float, float, float] | None,
    size: tuple[int, int],
) -> tuple["CalibrationFit", list[Point], list[Point]]:
    """The fit to the tags in one frame, with the pixel of each tag's middle and its place."""
    from khepera_forage.vision.calibration_fit import fit_to_tags
    from khepera_forage.vision.tags import FLOOR_SIZE, find_floor_tags

    places: dict[int, Point] = {}
    for text in texts:
        tag, equals, mm = text.partition("=")
        if not (equals and tag.isdecimal() and 1 <= int(tag) <= 49):
            raise ValueError(f"--tags has {text!r}; allowed: id=x,y with an id from 1 to 49, and x, y in mm")
        if int(tag) in places:
            raise ValueError(f"--tags has {tag} twice; allowed: each tag once")
        places[int(tag)] = _point("--tags", mm)
    _check_count("--tags", len(places))
    fit = fit_to_tags(find_floor_tags(source.newest()[0], sorted(places)), places, FLOOR_SIZE, camera, size)
    seen = fit.calibration.tags
    return fit, list(seen.values()), [places[tag] for tag in seen]


def _print_errors(fit: "CalibrationFit", picture: Sequence[Point], floor: Sequence[Point]) -> None:
    """How far each point is off, in the fit and when it is held out; and what the errors mean."""
    from khepera_forage.vision.calibration_fit import LENS_POINTS, root_mean_square

    calibration = fit.calibration
    for i, ((u, v), (x, y), error) in enumerate(zip(picture, floor, fit.residuals, strict=True)):
        known = fit.held_out and not math.isnan(fit.held_out[i])
        held_out = f", {fit.held_out[i]:.1f} mm when held out" if known else ""
        print(f"pixel ({u:.1f}, {v:.1f}) is ({x:.0f}, {y:.0f}) mm: {error:.1f} mm off{held_out}")
    print(f"residual {_summary(fit.residuals)}")
    if not math.isnan(root_mean_square(fit.held_out)):
        print(f"held-out error {_summary(fit.held_out)}: each point by the calibration from all others")
    else:
        print(
            "held-out error unknown, because four points always fit: give at least five to measure the error"
        )
    if calibration.lens is not None:
        without = root_mean_square(fit.held_out_without_lens)
        print(
            f"lens: k1 {calibration.lens.k1:.4f}, k2 {calibration.lens.k2:.4f} "
            f"(held-out error without it {without:.1f} mm)"
        )
    elif len(picture) < LENS_POINTS[0]:
        print(f"lens not calibrated: that takes at least {LENS_POINTS[0]} points, better 12 or more")
    else:
        print("lens without measurable distortion")
    if fit.coverage < _ENOUGH_COVERAGE:
        print(
            f"the points enclose {100 * fit.coverage:.0f} % of the picture: outside of them the error is unknown and "
            "can be much larger; add points near the corners"
        )
    print(f"a pixel in the middle is {calibration.mm_per_pixel():.2f} mm wide")


def _summary(errors: Sequence[float]) -> str:
    from khepera_forage.vision.calibration_fit import root_mean_square

    return f"{root_mean_square(errors):.1f} mm (root mean square), {np.nanmax(errors):.1f} mm at most"


def _print_regions(source: "FrameSource", calibration: "Calibration") -> None:
    from khepera_forage.vision.tracker import Tracker

    scene = Tracker(calibration=calibration).update(source.newest()[0])
    print(f"seen now: {described(scene)}")


def _clicked_points(source: "FrameSource", floor: Sequence[Point]) -> list[Point]:
    """The pixel that the user clicks for each place on the floor."""
    title = "khepera-forage camera calibrate"
    height, width = source.newest()[0].shape
    window = PictureWindow.open(title, width, height)
    if window is None:
        raise ValueError("--places needs a display and pygame (extra render); allowed without: --points")
    points: list[Point] = []
    try:
        frame = source.newest()[0]
        while len(points) < len(floor):
            x, y = floor[len(points)]
            window.title(f"click the place at ({x:g}, {y:g}) mm")
            points += window.show(_with_crosses(frame, points))[: len(floor) - len(points)]
            if window.closed:
                raise ValueError(
                    f"window closed after {len(points)} clicks; allowed: one click for each of --places"
                )
            time.sleep(_PAUSE)
            frame = source.newest()[0]
    finally:
        window.close()
    return points


def _with_crosses(frame: NDArray[np.uint8], points: Sequence[Point]) -> NDArray[np.uint8]:
    """A frame in colour with a cross at each clicked point."""
    picture = np.repeat(frame[:, :, None], 3, axis=2)
    for u, v in points:
        row, column = int(v), int(u)
        picture[row, max(0, column - 6) : column + 7] = _CROSS_COLOUR
        picture[max(0, row - 6) : row + 7, column] = _CROSS_COLOUR
    return picture


def _points(texts: Sequence[str]) -> tuple[list[Point], list[Point]]:
    picture, floor = [], []
    for text in texts:
        pixels, equals, mm = text.partition("=")
        if not equals:
            raise ValueError(f"--points has {text!r}; allowed: {_POINT_FORMAT}")
        picture.append(_point("--points", pixels))
        floor.append(_point("--points", mm))
    _check_count("--points", len(picture))
    return picture, floor


def _check_count(name: str, count: int) -> None:
    if count < 4:
        raise ValueError(f"{name} has {count} points; allowed: four or more")


def _point(name: str, text: str) -> Point:
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
