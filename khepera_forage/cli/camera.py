"""`khepera-forage camera`: calibrate the overhead camera, show its picture, print the markers (3.4, 3.5)."""

import argparse
import re
import time
from collections import deque
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli import calibrate
from khepera_forage.cli.camera_window import SOURCE, VIRTUAL, PictureWindow, described, open_source
from khepera_forage.cli.options import Command, Option, check_ending, option, out
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.vision.rendering.marker_sheets import marker_pages, save_pages, tag_pages
from khepera_forage.vision.tracker_settings import TrackerSettings

if TYPE_CHECKING:
    from khepera_forage.vision.tracker import Tracker
    from khepera_forage.vision.video import FrameSource

_FILM_FRAMES = 50
"""Frames of a film without `--frames`."""
_POLL_INTERVAL = 0.002
"""Seconds to wait for a new frame of the camera."""
_IN_USE = {"holes": (1, 2), "grid": tuple(range(1, 13)), "tags": (1, 2, 3, 4)}
"""Markers without `--numbers`."""


def ids(text: str) -> tuple[int, ...]:
    """Numbers and ranges: "1-4,7"; none for an empty text."""
    numbers: list[int] = []
    for part in text.replace(" ", "").split(",") if text.strip() else ():
        found = re.fullmatch(r"(\d{1,2})(?:-(\d{1,2}))?", part)
        if not found:
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: numbers and ranges, such as 1-4,7")
        numbers += range(int(found[1]), int(found[2] or found[1]) + 1)
    return tuple(numbers)


def _preview(arguments: argparse.Namespace) -> int:
    """Show the pictures in a window, or save them."""
    path: Path | None = arguments.out
    if path is not None:
        check_ending(path, (".png", ".gif", ".mp4", ".avi"))
    frames = _FILM_FRAMES if arguments.frames is None and path is not None else arguments.frames
    from khepera_forage.vision.calibration import Calibration
    from khepera_forage.vision.tracker import Tracker

    calibration = Calibration.load(arguments.calibration) if arguments.calibration else None
    numbers = arguments.numbers or _IN_USE[arguments.markers]
    settings = TrackerSettings(markers=arguments.markers, numbers=numbers, food_tags=arguments.food_tags)
    size = None if calibration is None else calibration.size
    with closing(open_source(arguments, path is None, size)) as source:
        pictures = _pictures(source, Tracker(settings, calibration), frames)
        if path is None:
            _show(pictures)
        else:
            _save(pictures, path, arguments.source == VIRTUAL)
    return 0


def _pictures(source: "FrameSource", tracker: "Tracker", frames: int | None) -> Iterator[NDArray[np.uint8]]:
    """Frames with the tracker's regions; prints the regions and the picture's quality once a second."""
    from khepera_forage.vision.image_quality import measure_quality
    from khepera_forage.vision.overlay import draw_scene

    last, seen, since_print, printed = None, 0, 0, time.monotonic()
    while frames is None or seen < frames:
        frame, age = source.newest()
        if frame is last:
            time.sleep(_POLL_INTERVAL)
            continue
        last, seen, since_print = frame, seen + 1, since_print + 1
        scene = tracker.update(frame)
        yield draw_scene(frame, scene, tracker.calibration, tracker.settings)
        now = time.monotonic()
        if now - printed >= 1 or seen == frames:
            rate = since_print / max(now - printed, 1e-9)
            print(
                f"{described(scene, tracker.settings.markers)}; {rate:.0f} frames/s, {1000 * age:.0f} ms old"
            )
            quality = measure_quality(tracker.reduced(frame))
            print(f"picture: {quality.described(tracker.settings)}")
            for text in (quality.warnings(tracker.settings) | tracker.warnings).values():
                print(f"warning: {text}")
            printed, since_print = now, 0


def _show(pictures: Iterator[NDArray[np.uint8]]) -> None:
    """In a window, where there is a display; until the user closes it."""
    first = next(pictures)
    window = PictureWindow.open("khepera-forage camera", first.shape[1], first.shape[0])
    if window is None:
        for _ in pictures:
            pass
        return
    with closing(window):
        window.show(first)
        while not window.closed and (picture := next(pictures, None)) is not None:
            window.show(picture)


def _save(pictures: Iterator[NDArray[np.uint8]], path: Path, simulated: bool) -> None:
    """Write the last picture as PNG, or all of them as a film."""
    began = time.monotonic()
    is_film = path.suffix.lower() != ".png"
    taken = deque(pictures, None if is_film else 1)
    if not is_film:
        import cv2

        good, data = cv2.imencode(".png", cv2.cvtColor(taken[-1], cv2.COLOR_RGB2BGR))
        if not good:
            raise OSError(f"{path}: OpenCV cannot write a PNG")
        path.write_bytes(data.tobytes())
        print(f"{path}: 1 picture")
        return
    from khepera_forage.envs.rendering import save_film

    # A virtual camera without a window is not paced; its film shows one frame for each round.
    rate = len(taken) / max(time.monotonic() - began, 1e-9)
    fps = 1 / DEFAULT_DECISIONS.round_duration if simulated else min(50.0, max(1.0, rate))
    save_film(list(taken), path, fps)
    print(f"{path}: {len(taken)} {'picture' if len(taken) == 1 else 'pictures'}")


def _markers(arguments: argparse.Namespace) -> int:
    grid = arguments.grid
    numbers = TrackerSettings(markers="grid", numbers=grid).numbers if grid else (1, 2)
    path = save_pages(arguments.out, marker_pages(numbers, bool(grid)))
    print(f"{path}: {len(numbers)} markers on A4; print it at 100 %")
    return 0


def _tags(arguments: argparse.Namespace) -> int:
    pages = tag_pages(arguments.robots, arguments.food, arguments.floor, arguments.size, arguments.food_size)
    if not pages:
        raise ValueError("no tags to print; allowed: ids for --robots, --food or --floor")
    path = save_pages(arguments.out, pages)
    print(f"{path}: {len(pages)} pages of A4; print at 100 %, and measure the line of 100 mm")
    return 0


def _size(name: str, default: float, what: str) -> Option:
    return option(name, type=float, default=default, metavar="MM", help=f"side of {what} ({default:g})")


def _ids(kind: str, default: str) -> Option:
    text = f"ids of the tags for {kind} ({default or 'none'})"
    return option(f"--{kind}", type=ids, default=ids(default), metavar="IDS", help=text)


COMMAND = Command(
    "camera",
    "calibrate the overhead camera, show its picture, or print the markers",
    commands=(
        calibrate.COMMAND,
        Command(
            "preview",
            "show the camera's picture with the regions that the tracker finds",
            _preview,
            [
                *SOURCE,
                option(
                    "--calibration",
                    type=given_path,
                    metavar="FILE",
                    help="calibration file, from `calibrate`",
                ),
                option(
                    "--markers", choices=tuple(_IN_USE), default="holes", help="what robots carry (holes)"
                ),
                option(
                    "--numbers",
                    type=ids,
                    metavar="NUMBERS",
                    help="markers or tags in use, such as 1-4 (all of the kind; tags: 1-4)",
                ),
                option("--food-tags", type=ids, default=(), metavar="IDS", help="tags on food (none)"),
                option(
                    "--frames",
                    type=whole_number(1),
                    metavar="N",
                    help=f"stop after N frames (no limit; {_FILM_FRAMES} with --out)",
                ),
                option(
                    "--out",
                    type=given_path,
                    metavar="FILE",
                    help="save the last picture (.png), or all pictures as a film (.gif, .mp4, .avi), instead of "
                    "opening a window",
                ),
            ],
        ),
        Command(
            "markers",
            "write a page with the robots' markers at true size, to print",
            _markers,
            [
                option(
                    "--grid",
                    type=ids,
                    default=(),
                    metavar="NUMBERS",
                    help="markers of the table of twelve instead, such as 1-12",
                ),
                out("markers.svg", "file, whose name ends in .svg, .png or .pdf"),
            ],
        ),
        Command(
            "tags",
            "write pages with tags for robots, food and the floor at true size, to print",
            _tags,
            [
                _ids("robots", "1-4"),
                _ids("food", ""),
                _ids("floor", "38-49"),
                _size("--size", TrackerSettings().tag_size, "a robot's tag"),
                _size("--food-size", TrackerSettings().food_tag_size, "food's tags"),
                out("tags.pdf", "file, whose name ends in .pdf; for a single page also .svg or .png"),
            ],
        ),
    ),
)
