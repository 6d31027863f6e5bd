"""`khepera-forage lab`: find robots and camera and write `lab.toml`, and say what is wrong with a laboratory."""

import argparse
import os
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from khepera_forage.cli.main import main
from khepera_forage.cli.options import Group, command, option, out, refuse_ignored
from khepera_forage.envs.arguments import set_up_of
from khepera_forage.envs.laboratories import TAG_SIZE, check_room, load_settings
from khepera_forage.extras import require
from khepera_forage.lab.settings_file import LabSettings, RobotSettings
from khepera_forage.robots.drivers import DRIVERS
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.mat import MatRobot
from khepera_forage.sim.arena_file import toml
from khepera_forage.sim.arenas.named import ARENAS, named_arena
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT

_FLOOR, _MAT = (600, 600, 70), (30, 20, 6)
"""Offset of the first arena, and mm between two arenas: under a camera, and on a mat."""
_WARM_UP, _POLL = 2.0, 0.05
"""Seconds within which a camera must show all markers: its first frames may be dark; and from one to the next."""


@command(
    option("--robot", "kind of the robots", choices=tuple(DRIVERS)),
    option("--port", "port of each robot, the teacher first; of toio cubes their names", nargs="+"),
    option("--food-cube", "names of the toio cubes that are the food, one per robot", nargs="*"),
    option("--camera", "the camera: a number, a file or a URL; not for toio cubes"),
    option("--calibration", "file written by `khepera-forage camera calibrate`"),
    option("--arena", f"the arena ({CORRIDOR})", choices=tuple(ARENAS), default=CORRIDOR),
    out("lab.toml", "the file to write"),
)
def new_command(arguments: argparse.Namespace) -> int:
    """Find robots and camera, check each, and write lab.toml."""
    file: Path = arguments.out
    _refuse_existing(file)
    if not file.absolute().parent.is_dir():
        raise FileNotFoundError(f"--out is {file}; allowed: a file in a folder that exists")
    kind = arguments.robot or _answer(f"Kind of robots ({', '.join(DRIVERS)}): ")
    if kind not in DRIVERS:
        raise ValueError(f"robot {kind!r}; allowed: {', '.join(DRIVERS)}")
    driver = DRIVERS[kind]
    is_mat = issubclass(driver, MatRobot)
    if is_mat:
        refuse_ignored(arguments, ["--camera", "--calibration"], f"for robots under a camera, not for {kind}")
    else:
        kinds = [name for name, each in DRIVERS.items() if issubclass(each, MatRobot)]
        refuse_ignored(arguments, ["--food-cube"], f"with --robot {' or '.join(kinds)}")
        picture, measured = file.with_suffix(".png"), file.with_name(f"{file.stem}_calibration.toml")
        _refuse_existing(picture, *([] if arguments.calibration else [measured]))
    ports = arguments.port
    if not ports:
        print("Found at this computer:", *(driver.find() or ["none"]), sep="\n  ")
        ports = _answer(f"{'Names' if is_mat else 'Ports'}, the teacher first, separated by spaces: ").split()
    works = [_passes(f"robot {port}", _check_robot, RobotSettings(port, "", type=kind)) for port in ports]
    foods, camera, calibration = arguments.food_cube, arguments.camera, arguments.calibration
    if is_mat:
        if foods is None:
            foods = _answer("Names of the food cubes, one per robot: ").split()
        works += [_passes(f"food cube {port}", _check_robot, RobotSettings(port, "", type=kind)) for port in foods]
    elif camera is None:
        camera = _answer("Camera (a number, a file or a URL): ")
    about = partial(lab_text, kind, ports, foods or (), camera or "", arena=arguments.arena)
    settings = _written(file, about, calibration)
    if is_mat:
        works.append(_passes("food", _check_food, settings))
    else:
        if _passes("picture", _save_picture, settings, picture) and calibration is None:
            calibration = _calibrated(camera, settings, measured)
            settings = _written(file, about, calibration)
        works.append(_passes("camera", _check_camera, settings))
        if calibration is None:
            print("next: khepera-forage camera calibrate; name its file as calibration under [camera]")
    print(f"{file} is written")
    # For arms that take longer than a round, as a Khepera's does.
    decided = " --decision lowering_speed=0" if driver.model.has_gripper else ""
    print(f"then: khepera-forage lab check {file}; khepera-forage train --lab {file}{decided}")
    return 0 if all(works) else 1


def _refuse_existing(*files: Path) -> None:
    """Complain about files that are there already."""
    for file in files:
        if file.exists():
            raise FileExistsError(f"{file} is there already; allowed: another --out")


def _written(file: Path, about: Callable[[str | None], str], calibration: str | None) -> LabSettings:
    """The settings of a new file; none is left that is not allowed. The file names others as from its own folder."""
    if calibration and not Path(calibration).is_absolute():
        calibration = os.path.relpath(calibration, file.parent)
    file.write_text(about(calibration), encoding="utf-8")
    try:
        return load_settings(file)
    except ValueError:
        file.unlink()
        raise


def _save_picture(settings: LabSettings, file: Path) -> str:
    """Take a picture and save it."""
    require("a camera", "camera")
    import cv2

    from khepera_forage.lab.devices import calibration_of, open_video

    with closing(open_video(settings, calibration_of(settings))) as source:
        frame, _ = source.newest()
    file.write_bytes(cv2.imencode(".png", frame)[1].tobytes())
    return f"{file}: look whether it shows all arenas, without glare"


def _calibrated(camera: str, settings: LabSettings, file: Path) -> str | None:
    """Let the user click on the corners of all arenas; the file of the calibration, None if there is none now."""
    bounds = [arena.bounds for arena in settings.arenas]
    corners = [f"{b[i]:g},{b[j]:g}" for b in bounds for i, j in ((0, 1), (2, 1), (2, 3), (0, 3))]
    question = f"Calibrate now, by clicks on the {len(corners)} inner corners of the arenas in a window? (y, n) "
    if _answer(question, "n").lower() not in ("y", "yes"):
        return None
    words = ["camera", "calibrate", "--source", camera, "--out", str(file), "--places", *corners]
    question = "Place of the camera as X,Y,HEIGHT in mm, to correct the shift of raised markers (Enter: unknown): "
    if place := _answer(question, ""):
        words += [f"--camera={place}"]
    if settings.camera.size is not None:
        words += ["--size", "x".join(map(str, settings.camera.size))]
    return None if main(words) else str(file)


def lab_text(
    kind: str, ports: Sequence[str], foods: Sequence[str], camera: str, calibration: str | None, arena: str
) -> str:
    """The text of a `lab.toml` with arenas side by side."""
    driver = DRIVERS[kind]
    (x, y, gap), room = _FLOOR, PICTURE_HEIGHT * MM_PER_PIXEL
    if issubclass(driver, MatRobot):
        (x, y, gap), room = _MAT, driver.mat_size[1]
    one = named_arena(arena, set_up_of(DEFAULT_DECISIONS))
    _, low, _, high = one.bounds
    step = high - low + gap
    low = min(y, (room + gap - step * len(ports)) / 2)
    offsets = [(x, low + number * step) for number in range(len(ports))]
    if issubclass(driver, MatRobot):
        check_room([one.shifted(*offset) for offset in offsets], *driver.mat_size)
    lines = [f"food_cubes = {toml(tuple(foods))}"] if foods else []
    # Only the slowest speeds at first: what a robot does then can be stopped by hand.
    lines += ["safe_speed = 6", "", "[arena]", f"name = {toml(arena)}"]
    for port, offset in zip(ports, offsets, strict=True):
        lines += ["", "[[robots]]", f"type = {toml(kind)}", f"port = {toml(port)}", f"offset = {toml(offset)}"]
    if camera:
        lines += ["", "[camera]", f"source = {camera if camera.isdigit() else toml(camera)}"]
        lines += [f"calibration = {toml(calibration)}"] if calibration else []
        if not driver.model.has_gripper:  # its tag is small
            lines += [] if calibration else ["size = [1920, 1080]"]  # a calibration has a size of its own
            lines += ["", "[tracker]", 'markers = "tags"', f"tag_size = {TAG_SIZE:g}"]
            lines += [f"marker_height = {driver.model.marker_height:.0f}"]
    return "\n".join(lines) + "\n"


def _answer(question: str, default: str | None = None) -> str:
    """What the user types; the default for nothing."""
    try:
        answer = input(question).strip()
    except (EOFError, RuntimeError):  # no input, or none any more
        answer = ""
    if not answer and default is None:
        raise ValueError(f"{question.splitlines()[-1].rstrip(': ')}: no answer; allowed: an answer, or the option")
    return answer or default or ""


@command(option("file", "the laboratory (lab.toml)", Path, nargs="?", default=Path("lab.toml")))
def check_command(arguments: argparse.Namespace) -> int:
    """Check a laboratory in order: file, robots, camera."""
    settings = load_settings(arguments.file)
    print(f"{arguments.file}: {len(settings.robots)} robots, arena {settings.arena.name}", flush=True)
    results = [_passes(f"robot {robot.name}", _check_robot, robot, settings.period) for robot in settings.robots]
    results += [_passes(food.name, _check_robot, food, settings.period) for food in settings.food_robots]
    name, check = ("food", _check_food) if settings.has_mat else ("camera", _check_camera)
    failed = [*results, _passes(name, check, settings)].count(False)
    print("all is well" if not failed else f"{failed} to repair; begin with the first", flush=True)
    return 1 if failed else 0


def _passes(name: str, check: Callable[..., str], *about: Any) -> bool:
    """Check a part, and print what `check` found or the error that it raised."""
    try:
        verdict, found = "pass", check(*about)
    except (OSError, ValueError, ImportError) as error:
        verdict, found = "FAIL", str(error)
    print(f"{name:24s} {verdict}   {found}", flush=True)
    return verdict == "pass"


def _check_robot(entry: RobotSettings, period: float = CONTROL_PERIOD) -> str:
    """Open a robot and flash its lamps."""
    with entry.open(period) as robot:
        robot.receive()
        robot.flash()
        if isinstance(robot, MatRobot):
            if not robot.on_mat:
                raise OSError(f"{entry.port} does not see the mat: put it on the mat")
            return f"{entry.type} at {entry.port}, on the mat at x {robot.pose.x:.0f} mm, y {robot.pose.y:.0f} mm"
        return f"{entry.type} at {entry.port}, in time for rounds of {1000 * period:.0f} ms"


def _check_food(settings: LabSettings) -> str:
    """Count the food cubes of a mat."""
    cubes, alone = len(settings.food_cubes), len(settings.arena.foods)
    places = alone * len(settings.robots)
    if cubes < places:
        raise ValueError(f"{cubes} food cubes for {places} places; allowed: one each, or for recalls alone {alone}")
    return f"{cubes} food cubes for {places} places"


def _check_camera(settings: LabSettings) -> str:
    """Take a picture, and look for the markers of all robots."""
    require("a camera", "camera")
    from khepera_forage.lab.devices import calibration_of, open_video
    from khepera_forage.lab.localisation import find_marker
    from khepera_forage.vision.tracker import TrackedCamera, Tracker

    calibration = calibration_of(settings)
    tracker = Tracker(settings.tracker, calibration)
    robots = list(zip(settings.robots, settings.arenas, strict=True))
    with closing(TrackedCamera(open_video(settings, calibration), tracker)) as camera:
        missing, end = [robot.name for robot, _ in robots], time.monotonic() + _WARM_UP
        while missing and time.monotonic() < end:
            camera.expose()
            scene = camera.look()
            missing = [robot.name for robot, arena in robots if find_marker(scene, arena, robot.holes) is None]
            time.sleep(_POLL)
    if missing:
        raise OSError(f"no marker of {', '.join(missing)} is seen in its arena: put each robot into its own arena")
    calibrated = "calibrated" if calibration else "without a calibration"
    return f"source {settings.camera.source}, {calibrated}; all markers seen"


lab_command = Group("Set up a laboratory with real robots, and check it.", (new_command, check_command))
