"""`khepera-forage lab`: find robots and camera and write `lab.toml`, and say what is wrong with a laboratory."""

import argparse
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from khepera_forage.cli.main import main
from khepera_forage.cli.options import Group, command, option, refuse_ignored
from khepera_forage.envs.laboratories import TAG_SIZE, load_settings
from khepera_forage.extras import require
from khepera_forage.lab.settings_file import LabSettings, RobotSettings
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.model import MODELS, TOIO
from khepera_forage.robots.toio.driver import ToioRobot, find_cubes
from khepera_forage.sim.arena_file import toml
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.sim.arenas.thesis import CORRIDOR

_FLOOR, _MAT = (600, 600, 300), (30, 20, 236)
"""Offset of the first arena, and mm from one to the next: under a camera, and on a mat."""
_WARM_UP, _POLL = 2.0, 0.05
"""Seconds within which a camera must show all markers, because its first frames may be dark; and from one to the next.
"""


@command(
    option("--robot", "kind of the robots", choices=tuple(MODELS)),
    option("--port", "port of each robot, the teacher first; of toio cubes their names", nargs="+"),
    option("--food-cube", "names of the toio cubes that are the food, one per robot", nargs="*"),
    option("--camera", "the camera: a number, a file or a URL; not for toio cubes"),
    option("--calibration", "file written by `khepera-forage camera calibrate`"),
    option("--arena", f"the arena ({CORRIDOR})", choices=tuple(ARENAS), default=CORRIDOR),
    option("--out", "the file to write (lab.toml)", Path, default=Path("lab.toml")),
)
def new_command(arguments: argparse.Namespace) -> int:
    """Find robots and camera, check each, and write lab.toml."""
    out = arguments.out
    if out.exists():
        raise FileExistsError(f"{out} is there already; allowed: another --out")
    if not out.absolute().parent.is_dir():
        raise FileNotFoundError(f"--out is {out}; allowed: a file in a folder that exists")
    kind = arguments.robot or _answer(f"Kind of robots ({', '.join(MODELS)}): ")
    if kind not in MODELS:
        raise ValueError(f"robot {kind!r}; allowed: {', '.join(MODELS)}")
    is_mat = kind == TOIO.name
    if is_mat:
        refuse_ignored(arguments, ["--camera", "--calibration"], "for robots under a camera, not for toio cubes")
    else:
        refuse_ignored(arguments, ["--food-cube"], "with --robot toio")
    ports = arguments.port or _answer(
        f"{_found(is_mat)}\n{'Names' if is_mat else 'Ports'}, the teacher first, separated by spaces: "
    )
    ports = ports.split() if isinstance(ports, str) else ports
    works = [_passes(f"robot {port}", _check_robot, RobotSettings(port, "", type=kind)) for port in ports]
    foods, camera, calibration = arguments.food_cube, arguments.camera, arguments.calibration
    if is_mat:
        if foods is None:
            foods = _answer("Names of the food cubes, one per robot: ").split()
        works += [_passes(f"food cube {port}", _check_robot, RobotSettings(port, "", type=kind)) for port in foods]
    elif camera is None:
        camera = _answer("Camera (a number, a file or a URL): ")
    text = partial(lab_text, kind, ports, foods or (), camera or "", arena=arguments.arena)
    settings = _written(out, text(calibration))
    if not is_mat:
        picture = out.with_suffix(".png")
        if _passes("picture", _save_picture, settings, picture) and calibration is None:
            calibration = _calibrated(camera, settings)
            settings = _written(out, text(calibration))
        works.append(_passes("camera", _check_camera, settings))
        if calibration is None:
            print("next: khepera-forage camera calibrate; name its file as calibration under [camera]")
    print(f"{out} is written")
    print(f"then: khepera-forage lab check {out}; khepera-forage train --lab {out}")
    return 0 if all(works) else 1


def _written(out: Path, text: str) -> LabSettings:
    """The settings of a new file; none is left that is not allowed."""
    out.write_text(text, encoding="utf-8")
    try:
        return load_settings(out)
    except ValueError:
        out.unlink()
        raise


def _save_picture(settings: LabSettings, file: Path) -> str:
    """Take a picture and save it."""
    require("a camera", "camera")
    import cv2

    from khepera_forage.lab.devices import calibration_of, open_video

    with closing(open_video(settings, calibration_of(settings))) as source:
        frame, _ = source.newest()
    if not cv2.imwrite(str(file), frame):
        raise OSError(f"{file} cannot be written")
    return f"{file}: look whether it shows all arenas, without glare"


def _calibrated(camera: str, settings: LabSettings) -> str | None:
    """The file of a calibration by clicks on the corners of all arenas; None if the user wants none now."""
    corners = [
        f"{x:g},{y:g}" for arena in settings.arenas for x1, y1, x2, y2 in [arena.bounds]
        for x, y in ((x1, y1), (x2, y1), (x2, y2), (x1, y2))
    ]  # fmt: skip
    question = f"Calibrate now, by clicks on the {len(corners)} inner corners of the arenas in a window? (y, n) "
    if _answer(question, "n").lower() not in ("y", "yes"):
        return None
    file = "calibration.toml"
    words = ["camera", "calibrate", "--source", camera, "--out", file, "--places", *corners]
    if settings.camera.size is not None:
        words += ["--size", "x".join(map(str, settings.camera.size))]
    return None if main(words) else file


def lab_text(
    kind: str, ports: Sequence[str], foods: Sequence[str], camera: str, calibration: str | None, arena: str
) -> str:
    """The text of a `lab.toml` with arenas side by side."""
    x, y, step = _MAT if kind == TOIO.name else _FLOOR
    lines = [f"food_cubes = {toml(tuple(foods))}"] if foods else []
    # Only the slowest speeds at first: what a robot does then can be stopped by hand.
    lines += ["safe_speed = 6", "", "[arena]", f"name = {toml(arena)}"]
    for number, port in enumerate(ports):
        offset = toml((x, y + number * step))
        lines += ["", "[[robots]]", f"type = {toml(kind)}", f"port = {toml(port)}", f"offset = {offset}"]
    if camera:
        lines += ["", "[camera]", f"source = {camera if camera.isdigit() else toml(camera)}"]
        lines += [f"calibration = {toml(calibration)}"] if calibration else []
        if not MODELS[kind].has_gripper:  # its tag is small
            lines += [] if calibration else ["size = [1920, 1080]"]  # a calibration has a size of its own
            lines += ["", "[tracker]", 'markers = "tags"', f"tag_size = {TAG_SIZE:g}"]
    return "\n".join(lines) + "\n"


def _found(is_mat: bool) -> str:
    """The serial ports of this computer, or the cubes near it, for a question."""
    if is_mat:
        found = find_cubes()
        return f"Cubes near this computer: {', '.join(found) or 'none was found'}"
    require("a serial port", "robots")
    from serial.tools.list_ports import comports

    found = [f"  {port.device}   {port.description}" for port in comports()]
    return "\n".join(["Serial ports of this computer:", *(found or ["  none"])])


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
    results = [_passes(f"robot {r.name}", _check_robot, r, settings.period) for r in settings.robots]
    for port in settings.food_cubes:
        food = RobotSettings(port, "food", type=settings.robots[0].type)
        results.append(_passes(f"food cube {port}", _check_robot, food, settings.period))
    if settings.has_mat:
        results.append(_passes("food", _check_food, settings))
    else:
        results.append(_passes("camera", _check_camera, settings))
    failed = results.count(False)
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
        if isinstance(robot, ToioRobot):
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


lab_command = Group("Set up a laboratory with real robots, and check it.", {"new": new_command, "check": check_command})
