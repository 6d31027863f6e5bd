"""`khepera-forage camera calibrate`: compute a calibration from points in the picture and on the floor."""

import argparse
import math
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.cli.camera_window import SOURCE, PictureWindow, described, open_source
from khepera_forage.cli.options import Command, flag, option, out
from khepera_forage.extras import require
from khepera_forage.vision.lens import DEFAULT_SIZE

if TYPE_CHECKING:
    from khepera_forage.vision.calibration_fit import CalibrationFit
    from khepera_forage.vision.video import FrameSource

Point = tuple[float, float]
_PAUSE = 0.02
"""Seconds between two pictures of the window."""
_CROSS_COLOUR = (255, 60, 60)
_ENOUGH_COVERAGE = 0.5
"""Share of the picture within the points from which the held-out error holds for most of the picture."""


def run(arguments: argparse.Namespace) -> int:
    """Calibrate, print how well the points fit, and write the file."""
    require("khepera-forage camera calibrate", "camera")
    from khepera_forage.vision.calibration_fit import fit_calibration, fit_to_tags
    from khepera_forage.vision.tags import FLOOR_SIZE, find_floor_tags
    from khepera_forage.vision.tracker import Tracker

    camera = None
    if arguments.camera:
        x, y, height = _numbers("--camera", arguments.camera, 3)
        camera = (x, y, height)
    by_camera = arguments.places or arguments.tags or arguments.check
    source = open_source(arguments, paced=False) if by_camera else None
    try:
        size = arguments.size or DEFAULT_SIZE
        if source is not None:
            rows, columns = source.newest()[0].shape
            size = (columns, rows)
        if arguments.tags and source is not None:
            places = _tags(arguments.tags)
            found = find_floor_tags(source.newest()[0], sorted(places))
            fit = fit_to_tags(found, places, FLOOR_SIZE, camera, size)
            seen = fit.calibration.tags
            picture, floor = list(seen.values()), [places[tag] for tag in seen]
        else:
            if arguments.places and source is not None:
                floor = [_point("--places", text) for text in arguments.places]
                _check_count("--places", len(floor))
                picture = _clicked_points(source, floor)
            else:
                picture, floor = _points(arguments.points)
            fit = fit_calibration(picture, floor, camera, size)
        _print_errors(fit, picture, floor)
        if arguments.check and source is not None:
            scene = Tracker(calibration=fit.calibration).update(source.newest()[0])
            print(f"seen now: {described(scene)}")
    finally:
        if source is not None:
            source.close()
    fit.calibration.save(arguments.out)
    print(f"written to {arguments.out}")
    return 0


def _print_errors(fit: "CalibrationFit", picture: Sequence[Point], floor: Sequence[Point]) -> None:
    """How far each point is off, in the fit and when it is held out; and what the errors mean."""
    from khepera_forage.vision.calibration_fit import LENS_POINTS, root_mean_square

    def summary(errors: Sequence[float]) -> str:
        return f"{root_mean_square(errors):.1f} mm (root mean square), {np.nanmax(errors):.1f} mm at most"

    calibration = fit.calibration
    for i, ((u, v), (x, y), error) in enumerate(zip(picture, floor, fit.residuals, strict=True)):
        known = fit.held_out and not math.isnan(fit.held_out[i])
        held_out = f", {fit.held_out[i]:.1f} mm when held out" if known else ""
        print(f"pixel ({u:.1f}, {v:.1f}) is ({x:.0f}, {y:.0f}) mm: {error:.1f} mm off{held_out}")
    print(f"residual {summary(fit.residuals)}")
    if not math.isnan(root_mean_square(fit.held_out)):
        print(f"held-out error {summary(fit.held_out)}: each point by the calibration from all others")
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


def _clicked_points(source: "FrameSource", floor: Sequence[Point]) -> list[Point]:
    """The pixel that the user clicks for each place on the floor; a cross marks each click."""
    frame = source.newest()[0]
    window = PictureWindow.open("khepera-forage camera calibrate", frame.shape[1], frame.shape[0])
    if window is None:
        raise ValueError("--places needs a display and pygame (extra render); allowed without: --points")
    points: list[Point] = []
    try:
        while len(points) < len(floor):
            picture = np.repeat(source.newest()[0][:, :, None], 3, axis=2)
            for u, v in points:
                row, column = int(v), int(u)
                picture[row, max(0, column - 6) : column + 7] = _CROSS_COLOUR
                picture[max(0, row - 6) : row + 7, column] = _CROSS_COLOUR
            x, y = floor[len(points)]
            window.title(f"click the place at ({x:g}, {y:g}) mm")
            points += window.show(picture)[: len(floor) - len(points)]
            if window.closed:
                raise ValueError(
                    f"window closed after {len(points)} clicks; allowed: one click for each of --places"
                )
            time.sleep(_PAUSE)
    finally:
        window.close()
    return points


def _tags(texts: Sequence[str]) -> dict[int, Point]:
    """The place of each tag of `--tags`."""
    places: dict[int, Point] = {}
    for text in texts:
        tag, equals, mm = text.partition("=")
        if not (equals and tag.isdecimal() and 1 <= int(tag) <= 49):
            raise ValueError(f"--tags has {text!r}; allowed: id=x,y with an id from 1 to 49, and x, y in mm")
        if int(tag) in places:
            raise ValueError(f"--tags has {tag} twice; allowed: each tag once")
        places[int(tag)] = _point("--tags", mm)
    _check_count("--tags", len(places))
    return places


def _points(texts: Sequence[str]) -> tuple[list[Point], list[Point]]:
    """The pixels and the places of `--points`."""
    picture, floor = [], []
    for text in texts:
        pixels, equals, mm = text.partition("=")
        if not equals:
            raise ValueError(
                f"--points has {text!r}; allowed: u,v=x,y with u, v in pixels from the upper left corner and x, y in mm"
            )
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


def _add_points(parser: argparse.ArgumentParser) -> None:
    given = parser.add_mutually_exclusive_group(required=True)
    for name, form, text in (
        (
            "--points",
            "U,V=X,Y",
            "four or more points: pixels from the picture's upper left corner = mm on the floor; twelve all over the "
            "picture calibrate the lens, too",
        ),
        (
            "--places",
            "X,Y",
            "four or more places on the floor in mm, which you then click in a window in this order; twelve all over "
            "the picture calibrate the lens, too",
        ),
        (
            "--tags",
            "ID=X,Y",
            "four or more tags on the floor, better twelve, and the place of the middle of each in mm: nothing "
            "to click, and the camera is watched from then on",
        ),
    ):
        given.add_argument(name, nargs="+", metavar=form, help=text)


COMMAND = Command(
    "calibrate",
    "measure which point of the floor each pixel shows, and save that as a calibration file",
    run,
    [
        *SOURCE,
        _add_points,
        option(
            "--camera",
            metavar="X,Y,HEIGHT",
            help="position of the camera in mm, to correct the shift of markers above the floor (no correction)",
        ),
        flag("--check", "take a picture and print the regions found in it, in mm"),
        out("calibration.toml", "file"),
    ],
)
