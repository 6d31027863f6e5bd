"""`khepera-forage camera`: calibrate the overhead camera, show its picture, print the markers (3.4, 3.5)."""

import argparse
import math
import re
import sys
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import closing, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.options import Group, check_file, command, option, out, refuse_ignored
from khepera_forage.envs.rendering.output import FILM_EXTRAS, save_film
from khepera_forage.extras import require
from khepera_forage.files import replacing
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.vision.calibration import DEFAULT_SIZE
from khepera_forage.vision.marker_sheets import marker_pages, save_pages, tag_pages
from khepera_forage.vision.scene import Scene, kind_text, place_text
from khepera_forage.vision.tracker_settings import TrackerSettings

if TYPE_CHECKING:
    import pygame

    from khepera_forage.cli.window import Window
    from khepera_forage.vision.calibration import CalibrationFit
    from khepera_forage.vision.tracker import Tracker
    from khepera_forage.vision.video import FrameSource

VIRTUAL = "virtual"
Point = tuple[float, float]
_ENOUGH_COVERAGE = 0.5
"""Share of the picture within the points from which the held-out error holds for most of the picture."""
_GOOD = 10.0
"""Greatest held-out error in mm (root mean square) without a warning: places measured with care give 1 to 3."""
_SUSPECTS = 8
"""Points, those with the largest errors, of which one may be wrong: to leave one out takes half a second."""
_CROSS_COLOUR = (255, 60, 60)
_PAUSE = 0.02
"""Seconds between two pictures of the window."""
_FILM_FRAMES = 50
"""Frames of a film without `--frames`."""
_POLL_INTERVAL = 0.002  # s
_IN_USE = {"holes": (1, 2), "grid": tuple(range(1, 13)), "tags": (1, 2, 3, 4)}
"""Markers without `--numbers`."""


def _size(text: str) -> tuple[int, int]:
    width, times, height = text.lower().partition("x")
    if not (times and width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: width x height in pixels, such as 1280x720")
    return int(width), int(height)


def open_source(arguments: argparse.Namespace, paced: bool, size: tuple[int, int] | None = None) -> "FrameSource":
    """The picture source of `--source`, which keeps real time if it is `paced`; `size` is that without `--size`."""
    require("khepera-forage camera", "camera")
    if arguments.source is None:
        arguments.source = "0"
    if arguments.source == VIRTUAL:
        refuse_ignored(arguments, ["--size", "--rate", "--exposure", "--focus"], "with a camera")
        from khepera_forage.rollouts.rendered_training import RenderedTraining

        return RenderedTraining(arguments.seed or 0, paced=paced)
    refuse_ignored(arguments, ["--seed"], f"with --source {VIRTUAL}")
    if Path(arguments.source).is_file():
        refuse_ignored(arguments, ["--rate", "--exposure", "--focus"], "with a device")
    from khepera_forage.vision.video import VideoSettings, VideoSource

    settings = VideoSettings(arguments.size or size, arguments.rate, arguments.exposure, arguments.focus)
    return VideoSource(arguments.source, settings=settings, paced=paced)


_SOURCE = f"number of a device, film file, URL, or `{VIRTUAL}` for rendered pictures of a simulated training (0)"
SOURCE = (
    option("--source", _SOURCE, None, "S"),
    option("--size", "pixels of the camera's frames (640x480)", _size, "WxH"),
    option("--rate", "frames a second, of a device (its own setting)", float, "N"),
    option("--exposure", "exposure, off automatic, of a device (its own setting)", float, "N"),
    option("--focus", "focus, off automatic, of a device (its own setting)", float, "N"),
    option("--seed", "seed of the virtual camera (0)", whole_number(0)),
)


def _open_window() -> "Window | None":
    """A window; None if there is no display or no pygame."""
    try:
        from khepera_forage.cli.window import Window

        return Window()
    except (ImportError, OSError):
        return None


def _is_closed(window: "Window", pause: float) -> bool:
    """Whether the user closes the window or presses Escape, until there is no event for `pause` seconds."""
    while event := window.wait(pause):
        if event == ("escape", True):
            return True
    return False


def _surface(picture: NDArray[np.uint8]) -> "pygame.Surface":
    """A picture of height x width x 3, red, green and blue, as windows show it."""
    import pygame

    return pygame.surfarray.make_surface(picture.swapaxes(0, 1))


def described(scene: Scene) -> str:
    """One line of text: the kind, position in mm and orientation of each region."""
    if not scene.regions:
        return "nothing seen"
    words = []
    for region in scene.regions:
        facing = f" {region.orientation} deg" if region.holes else ""
        lost = "" if region.found else " lost"
        words.append(f"{kind_text(region)} {place_text(region.x, region.y)}{facing}{lost}")
    return ", ".join(words)


def _coordinates(text: str, count: int = 2) -> tuple[float, ...]:
    try:
        values = tuple(map(float, text.split(",")))
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: {count} numbers with commas between")
    return values


def _pair(text: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    pixels, equals, mm = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: u,v=x,y in pixels from the upper left corner, and in mm")
    return _coordinates(pixels), _coordinates(mm)


def _tag(text: str) -> tuple[int, tuple[float, ...]]:
    tag, equals, mm = text.partition("=")
    if not (equals and tag.isdecimal() and 1 <= int(tag) <= 49):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: id=x,y with an id from 1 to 49, and x, y in mm")
    return int(tag), _coordinates(mm)


def _add_points(parser: argparse.ArgumentParser) -> None:
    add = parser.add_mutually_exclusive_group(required=True).add_argument
    text = "four or more points: pixels from the picture's upper left corner = mm on the floor"
    add("--points", type=_pair, nargs="+", metavar="U,V=X,Y", help=f"{text}; {_LENS}")
    text = "four or more places on the floor in mm, which you then click in a window in this order"
    add("--places", type=_coordinates, nargs="+", metavar="X,Y", help=f"{text}; {_LENS}")
    text = "four or more tags on the floor, better twelve, and the place of the middle of each in mm: nothing to click"
    add("--tags", type=_tag, nargs="+", metavar="ID=X,Y", help=f"{text}, and the camera is watched from then on")


_LENS = "twelve all over the picture calibrate the lens, too"
_CAMERA = "position of the camera in mm, to correct the shift of markers above the floor (no correction)"


@command(
    *SOURCE,
    _add_points,
    option("--camera", _CAMERA, lambda text: _coordinates(text, 3), "X,Y,HEIGHT"),
    out("calibration.toml", "file"),
)
def calibrate_command(arguments: argparse.Namespace) -> None:
    """Measure which point of the floor each pixel shows, and save that as a calibration file."""
    require("khepera-forage camera calibrate", "camera")
    from khepera_forage.vision.calibration import fit_calibration
    from khepera_forage.vision.detection import check_view
    from khepera_forage.vision.tags import find_floor_tags, fit_to_tags

    name, given = next((name, each) for name in ("points", "places", "tags") if (each := getattr(arguments, name)))
    tags = dict(given) if name == "tags" else {}
    if tags and len(tags) < len(given):
        twice = Counter(tag for tag, _ in given).most_common(1)[0][0]
        raise ValueError(f"--tags has {twice} twice; allowed: each tag once")
    if len(given) < 4:
        raise ValueError(f"--{name} has {len(given)} points; allowed: four or more")
    picture: Sequence[Point] = ()
    floor: Sequence[Point] = given
    size = arguments.size or DEFAULT_SIZE
    if name == "points":
        refuse_ignored(arguments, ["--source", "--rate", "--exposure", "--focus", "--seed"], "with --places or --tags")
        picture, floor = zip(*given, strict=True)
        for u, v in picture:
            if not (0 <= u <= size[0] and 0 <= v <= size[1]):
                raise ValueError(f"--points has the pixel {u:g},{v:g}; allowed: within --size, {size[0]}x{size[1]}")
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with closing(open_source(arguments, paced=False)) if name != "points" else nullcontext() as source:
        if source is not None:
            size = source.newest()[0].shape[::-1]
            if name == "places":
                picture = _clicked_points(source, floor)
        if source is not None and tags:
            fit = fit_to_tags(find_floor_tags(source.newest()[0], sorted(tags)), tags, arguments.camera, size)
            seen = fit.calibration.tags
            picture, floor = list(seen.values()), [tags[tag] for tag in seen]
        else:
            fit = fit_calibration(picture, floor, arguments.camera, size)
        check_view(fit.calibration, TrackerSettings())
        _print_errors(fit, picture, floor)
    fit.calibration.save(arguments.out)
    print(f"written to {arguments.out}")


def _print_errors(fit: "CalibrationFit", picture: Sequence[Point], floor: Sequence[Point]) -> None:
    """How far each point is off, in the fit and when it is held out; and what the errors mean."""
    from khepera_forage.vision.calibration import LENS_POINTS, root_mean_square

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
        print("held-out error unknown, because four points always fit: give at least five to measure the error")
    if lens := calibration.lens:
        without = root_mean_square(fit.held_out_without_lens)
        print(f"lens: k1 {lens.k1:.4f}, k2 {lens.k2:.4f} (held-out error without it {without:.1f} mm)")
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
    if (error := root_mean_square(fit.held_out)) > _GOOD:  # nan is not
        hint = _suspect(fit, picture, floor)
        print(f"warning: the held-out error is {error:.1f} mm, above {_GOOD:g} mm; {hint}", file=sys.stderr)


def _suspect(fit: "CalibrationFit", picture: Sequence[Point], floor: Sequence[Point]) -> str:
    """The point without which the held-out error is smallest."""
    from khepera_forage.vision.calibration import fit_calibration, root_mean_square

    errors = []
    for i in np.argsort(fit.residuals)[-_SUSPECTS:].tolist():
        others, places = ([*group[:i], *group[i + 1 :]] for group in (picture, floor))
        with suppress(ValueError):  # these may fit no camera
            without = root_mean_square(fit_calibration(others, places, size=fit.calibration.size).held_out)
            if without >= 0:  # nan for four points
                errors.append((without, *picture[i], *floor[i]))
    if not errors:
        return "from six points on, this line names the worst"
    return "without the point {1:g},{2:g}={3:g},{4:g} it is {0:.1f} mm".format(*min(errors))


def _clicked_points(source: "FrameSource", floor: Sequence[Point]) -> list[Point]:
    """The pixel that the user clicks for each place on the floor; a cross marks each click."""
    window = _open_window()
    if window is None:
        raise ValueError("--places needs a display and pygame (extra render); allowed without: --points")
    from pygame.draw import line

    with closing(window):
        while (done := len(window.clicks)) < len(floor):
            picture = _surface(np.repeat(source.newest()[0][:, :, None], 3, axis=2))
            for u, v in window.clicks:
                line(picture, _CROSS_COLOUR, (u - 6, v), (u + 6, v))
                line(picture, _CROSS_COLOUR, (u, v - 6), (u, v + 6))
            window.show_picture(picture, "click the place at ({:g}, {:g}) mm".format(*floor[done]))
            if _is_closed(window, _PAUSE):
                raise ValueError(f"window closed after {done} clicks; allowed: one click for each of --places")
    return window.clicks[: len(floor)]


def ids(text: str) -> tuple[int, ...]:
    """Numbers and ranges: "1-4,7"; none for an empty text."""
    numbers: list[int] = []
    for part in text.replace(" ", "").split(",") if text.strip() else ():
        found = re.fullmatch(r"(\d{1,2})(?:-(\d{1,2}))?", part)
        some = range(int(found[1]), int(found[2] or found[1]) + 1) if found else ()
        if not some:
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: numbers and ranges, such as 1-4,7")
        numbers += some
    return tuple(numbers)


_FILM = "save the last picture (.png), or all pictures as a film (.gif, .mp4, .avi), instead of opening a window"


@command(
    *SOURCE,
    option("--calibration", "calibration file, from `calibrate`", given_path, "FILE"),
    option("--markers", "what robots carry (holes)", choices=tuple(_IN_USE), default="holes"),
    option("--numbers", "markers or tags in use, such as 1-4 (all of the kind; tags: 1-4)", ids, "NUMBERS"),
    option("--tag-size", "side of a robot's tag (80)", float, "MM"),
    option("--food-tags", "tags on food (none)", ids, "IDS", default=()),
    option("--food-tag-size", "side of food's tags (24)", float, "MM"),
    option("--frames", f"stop after N frames (no limit; {_FILM_FRAMES} with --out)", whole_number(1), "N"),
    option("--out", _FILM, given_path, "FILE"),
)
def preview_command(arguments: argparse.Namespace) -> None:
    """Show the camera's picture with the regions that the tracker finds."""
    path: Path | None = arguments.out
    if arguments.markers != "tags":
        refuse_ignored(arguments, ["--tag-size"], "with --markers tags")
    if not arguments.food_tags:
        refuse_ignored(arguments, ["--food-tag-size"], "with --food-tags")
    if path is not None:
        check_file(path, (".png", *FILM_EXTRAS))
        needed = "camera", FILM_EXTRAS.get(path.suffix.lower(), "camera")
        require("khepera-forage camera", *dict.fromkeys(needed))
    frames = _FILM_FRAMES if arguments.frames is None and path is not None else arguments.frames
    from khepera_forage.vision.calibration import Calibration
    from khepera_forage.vision.tracker import Tracker

    calibration = Calibration.load(arguments.calibration) if arguments.calibration else None
    numbers = _IN_USE[arguments.markers] if arguments.numbers is None else arguments.numbers
    sizes = {key: side for key in ("tag_size", "food_tag_size") if (side := getattr(arguments, key)) is not None}
    settings = TrackerSettings(markers=arguments.markers, numbers=numbers, food_tags=arguments.food_tags, **sizes)
    size = None if calibration is None else calibration.size
    with closing(open_source(arguments, path is None, size)) as source:
        pictures = _pictures(source, Tracker(settings, calibration), frames, Path(arguments.source).is_file())
        if path is None:
            _show(pictures)
        else:
            _save(pictures, path, arguments.source)


def _pictures(
    source: "FrameSource", tracker: "Tracker", frames: int | None, is_film: bool
) -> Iterator[NDArray[np.uint8]]:
    """Frames with the tracker's regions, until a film ends; prints regions and the picture's quality once a second."""
    from khepera_forage.vision.image_quality import measure_quality
    from khepera_forage.vision.overlay import draw_scene
    from khepera_forage.vision.video import CameraLost

    last, seen, since_print, printed = None, 0, 0, time.monotonic()
    while frames is None or seen < frames:
        try:
            frame, age = source.newest()
        except CameraLost as end:
            if not (is_film and seen):
                raise
            print(end)
            return
        if frame is last:
            time.sleep(_POLL_INTERVAL)
            continue
        last, seen, since_print = frame, seen + 1, since_print + 1
        scene = tracker.update(frame)
        yield draw_scene(frame, scene, tracker.calibration, tracker.settings)
        now = time.monotonic()
        if now - printed >= 1 or seen == frames:
            rate = since_print / max(now - printed, 1e-9)
            print(f"{described(scene)}; {rate:.0f} frames/s, {1000 * age:.0f} ms old")
            quality = measure_quality(tracker.reduced(frame))
            print(f"picture: {quality.described(tracker.settings)}")
            for text in (quality.warnings(tracker.settings) | tracker.warnings).values():
                print(f"warning: {text}")
            printed, since_print = now, 0


def _show(pictures: Iterator[NDArray[np.uint8]]) -> None:
    """In a window, where there is a display; until the user closes it."""
    window = _open_window()
    if window is None:
        deque(pictures, 0)
        return
    with closing(window):
        for picture in pictures:
            window.show_picture(_surface(picture), "khepera-forage camera")
            if _is_closed(window, 0):
                return


def _save(pictures: Iterator[NDArray[np.uint8]], path: Path, source: str) -> None:
    """Write the last picture as PNG, or all of them as a film at the speed of its source."""
    import cv2

    began = time.monotonic()
    if path.suffix.lower() == ".png":
        (last,) = deque(pictures, 1)
        with replacing(path) as partial:
            partial.write_bytes(cv2.imencode(".png", cv2.cvtColor(last, cv2.COLOR_RGB2BGR))[1].tobytes())
        print(f"{path}: 1 picture")
        return
    taken = list(pictures)
    fps = len(taken) / max(time.monotonic() - began, 1e-9)
    if source == VIRTUAL:  # one frame for each round
        fps = 1 / DEFAULT_DECISIONS.round_duration
    elif Path(source).is_file():
        fps = cv2.VideoCapture(source).get(cv2.CAP_PROP_FPS)
    save_film(taken, path, min(50.0, max(1.0, fps)))
    print(f"{path}: {len(taken)} {'picture' if len(taken) == 1 else 'pictures'}")


@command(
    option("--grid", "markers of the table of twelve instead, such as 1-12", ids, "NUMBERS"),
    out("markers.svg", "file, whose name ends in .svg, .png or .pdf"),
)
def markers_command(arguments: argparse.Namespace) -> None:
    """Write a page with the robots' markers at true size, to print."""
    is_grid = arguments.grid is not None
    numbers = TrackerSettings(markers="grid", numbers=arguments.grid).numbers if is_grid else (1, 2)
    path = save_pages(arguments.out, marker_pages(numbers, is_grid))
    print(f"{path}: {len(numbers)} markers on A4; print it at 100 %")


@command(
    option("--robots", "ids of the tags for robots (1-4)", ids, "IDS", default=ids("1-4")),
    option("--food", "ids of the tags for food (none)", ids, "IDS", default=()),
    option("--floor", "ids of the tags for floor (38-49)", ids, "IDS", default=ids("38-49")),
    option("--size", "side of a robot's tag (80)", float, "MM", default=TrackerSettings().tag_size),
    option("--food-size", "side of food's tags (24)", float, "MM", default=TrackerSettings().food_tag_size),
    out("tags.pdf", "file, whose name ends in .pdf; for a single page also .svg or .png"),
)
def tags_command(arguments: argparse.Namespace) -> None:
    """Write pages with tags for robots, food and the floor at true size, to print."""
    pages = tag_pages(arguments.robots, arguments.food, arguments.floor, arguments.size, arguments.food_size)
    if not pages:
        raise ValueError("no tags to print; allowed: ids for --robots, --food or --floor")
    path = save_pages(arguments.out, pages)
    print(f"{path}: {len(pages)} page{'s' * (len(pages) > 1)} of A4; print at 100 %, and measure the line of 100 mm")


camera_command = Group(
    "Calibrate the overhead camera, show its picture, or print the markers.",
    (calibrate_command, preview_command, markers_command, tags_command),
)
