"""`khepera-forage camera preview`: live pictures with the tracker's regions drawn on them, or a film."""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.camera.markers import ids
from khepera_forage.cli.camera.source import VIRTUAL, add_source_arguments, open_source
from khepera_forage.cli.camera.window import PictureWindow
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene

if TYPE_CHECKING:
    from khepera_forage.vision.tracker import Tracker
    from khepera_forage.vision.video import FrameSource

FORMATS = (".png", ".gif", ".mp4", ".avi")
_FILM_FRAMES = 50
"""Frames of a film without `--frames`."""
_POLL_INTERVAL = 0.002
"""Seconds to wait for a new frame of the camera."""

Picture = NDArray[np.uint8]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_source_arguments(parser)
    parser.add_argument(
        "--calibration", type=given_path, metavar="FILE", help="calibration file, from `calibrate`"
    )
    parser.add_argument(
        "--markers", choices=("holes", "grid", "tags"), default="holes", help="what robots carry (holes)"
    )
    parser.add_argument(
        "--numbers",
        type=ids,
        metavar="NUMBERS",
        help="markers or tags in use, such as 1-4 (all of the kind; tags: 1-4)",
    )
    parser.add_argument("--food-tags", type=ids, default=(), metavar="IDS", help="tags on food (none)")
    parser.add_argument(
        "--frames",
        type=whole_number(1),
        metavar="N",
        help=f"stop after N frames (no limit; {_FILM_FRAMES} with --out)",
    )
    parser.add_argument(
        "--out",
        type=given_path,
        metavar="FILE",
        help="save the last picture (.png), or all pictures as a film (.gif, .mp4, .avi), instead of opening a window",
    )


def run(arguments: argparse.Namespace) -> int:
    """Show the pictures in a window, or save them.

    Raises:
        ValueError: A number is out of range, `--out` has another ending, or the calibration cannot be read.
        OSError: The camera cannot be opened, or is lost.
        ImportError: OpenCV, or the library that writes films, is not installed.
    """
    out: Path | None = arguments.out
    if out is not None and out.suffix.lower() not in FORMATS:
        raise ValueError(f"--out is {str(out)!r}; allowed: a name that ends in {', '.join(FORMATS)}")
    frames = _FILM_FRAMES if arguments.frames is None and out is not None else arguments.frames
    from khepera_forage.vision.calibration import Calibration
    from khepera_forage.vision.tracker import Tracker
    from khepera_forage.vision.tracker_settings import TrackerSettings

    calibration = Calibration.load(arguments.calibration) if arguments.calibration else None
    settings = TrackerSettings(
        markers=arguments.markers,
        numbers=arguments.numbers or _numbers(arguments.markers),
        food_tags=arguments.food_tags,
    )
    source = open_source(arguments, out is None, None if calibration is None else calibration.size)
    try:
        preview = _Preview(source, Tracker(settings, calibration), frames)
        if out is not None:
            _save(preview, out, arguments.source == VIRTUAL)
        else:
            _show(preview)
    finally:
        source.close()
    return 0


class _Preview:
    """The frames of a source with the tracker's regions; prints the regions and the picture's quality once a second.

    Attributes:
        rate: Mean number of frames a second; 0 before the end.
    """

    def __init__(self, source: "FrameSource", tracker: "Tracker", frames: int | None) -> None:
        self.rate = 0.0
        self._source, self._tracker, self._frames = source, tracker, frames

    def __iter__(self) -> Iterator[Picture]:
        """Frames with the regions drawn on them, up to the given number."""
        from khepera_forage.vision.image_quality import measure_quality
        from khepera_forage.vision.overlay import draw_scene

        tracker, last, seen, since_print = self._tracker, None, 0, 0
        began = printed = time.monotonic()
        while self._frames is None or seen < self._frames:
            frame, age = self._source.newest()
            if frame is last:
                time.sleep(_POLL_INTERVAL)
                continue
            last, seen, since_print = frame, seen + 1, since_print + 1
            scene = tracker.update(frame)
            yield draw_scene(frame, scene, tracker.calibration, tracker.settings)
            now = time.monotonic()
            if now - printed >= 1 or seen == self._frames:
                rate = since_print / max(now - printed, 1e-9)
                print(
                    f"{described(scene, tracker.settings.markers)}; {rate:.0f} frames/s, {1000 * age:.0f} ms old"
                )
                quality = measure_quality(tracker.reduced(frame))
                print(f"picture: {quality.described(tracker.settings)}")
                for text in (quality.warnings(tracker.settings) | tracker.warnings).values():
                    print(f"warning: {text}")
                printed, since_print = now, 0
        self.rate = seen / max(time.monotonic() - began, 1e-9)


def _numbers(markers: str) -> tuple[int, ...]:
    """The numbers in use, if none are given."""
    return {"holes": (1, 2), "grid": tuple(range(1, 13)), "tags": (1, 2, 3, 4)}[markers]


def _show(preview: _Preview) -> None:
    window: PictureWindow | None = None
    opened = False
    try:
        for picture in preview:
            if not opened:
                window, opened = (
                    PictureWindow.open("khepera-forage camera", picture.shape[1], picture.shape[0]),
                    True,
                )
            if window is not None:
                window.show(picture)
                if window.closed:
                    return
    finally:
        if window is not None:
            window.close()


def _save(preview: _Preview, out: Path, simulated: bool) -> None:
    pictures: list[Picture] = []
    for picture in preview:
        if out.suffix.lower() == ".png":
            pictures.clear()
        pictures.append(picture)
    # A virtual camera without a window is not paced; its film shows one frame for each round.
    fps = 1 / DEFAULT_DECISIONS.round_duration if simulated else min(50.0, max(1.0, preview.rate))
    save_pictures(pictures, out, fps)
    print(f"{out}: {len(pictures)} {'picture' if len(pictures) == 1 else 'pictures'}")


def described(scene: Scene, markers: str = "holes") -> str:
    """One line of text: the kind, position in mm and orientation of each region."""
    if not scene.regions:
        return "nothing seen"
    words = []
    for region in scene.regions:
        marker = f"{region.holes}-hole marker" if markers == "holes" else f"marker {region.holes}"
        what = marker if region.holes else "food"
        where = f"({region.x * MM_PER_PIXEL:.0f}, {region.y * MM_PER_PIXEL:.0f}) mm"
        facing = f" {region.orientation} deg" if region.holes else ""
        words.append(f"{what} {where}{facing}{'' if region.found else ' lost'}")
    return ", ".join(words)


def save_pictures(pictures: list[Picture], out: Path, fps: float) -> None:
    """Write the last picture as PNG, or all of them as a film.

    Args:
        pictures: Height x width x 3, red, green, blue.
        out: The file; its ending determines the format.
        fps: Frames a second of a film.

    Raises:
        OSError: The file cannot be written.
    """
    if out.suffix.lower() != ".png":
        from khepera_forage.envs.rendering import save_film

        save_film(pictures, out, fps)
        return
    import cv2

    good, data = cv2.imencode(".png", cv2.cvtColor(pictures[-1], cv2.COLOR_RGB2BGR))
    if not good:
        raise OSError(f"{out}: OpenCV cannot write a PNG")
    out.write_bytes(data.tobytes())
