"""`khepera-forage lab new`: find robots and camera, check each, and write `lab.toml`."""

import argparse
from collections.abc import Sequence
from contextlib import closing
from functools import partial
from pathlib import Path

from khepera_forage.cli.camera import calibrate
from khepera_forage.cli.lab.check import check_camera, check_robot, passes
from khepera_forage.envs.laboratories import load_settings
from khepera_forage.extras import require
from khepera_forage.lab.settings import LabSettings, RobotSettings
from khepera_forage.robots.model import MODELS, TOIO
from khepera_forage.robots.toio.driver import find_cubes
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.sim.arenas.thesis import CORRIDOR

_FLOOR, _MAT = (600, 600, 300), (30, 20, 236)
"""Offset of the first arena, and mm from one to the next: under a camera, and on a mat."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments; whatever is not given is asked."""
    parser.add_argument("--robot", choices=tuple(MODELS), help="kind of the robots")
    parser.add_argument(
        "--port", nargs="+", help="port of each robot, the teacher first; of toio cubes their names"
    )
    parser.add_argument(
        "--food-cube", nargs="*", help="names of the toio cubes that are the food, one per robot"
    )
    parser.add_argument("--camera", help="the camera: a number, a file or a URL; not for toio cubes")
    parser.add_argument("--calibration", help="file written by `khepera-forage camera calibrate`")
    parser.add_argument("--arena", choices=tuple(ARENAS), default=CORRIDOR, help=f"the arena ({CORRIDOR})")
    parser.add_argument("--out", type=Path, default=Path("lab.toml"), help="the file to write (lab.toml)")


def run(arguments: argparse.Namespace) -> int:
    """Ask for what is missing, check each device, calibrate, write the file, and say what to do next.

    Returns:
        0 if all devices work, otherwise 1; the file is written in any case.

    Raises:
        FileExistsError: The file is there already.
        ValueError: An answer that is not allowed.
    """
    out = arguments.out
    if out.exists():
        raise FileExistsError(f"{out} is there already; allowed: another --out")
    kind = arguments.robot or _answer(f"Kind of robots ({', '.join(MODELS)}): ")
    if kind not in MODELS:
        raise ValueError(f"robot {kind!r}; allowed: {', '.join(MODELS)}")
    is_mat = kind == TOIO.name
    ports = arguments.port or _answer(
        f"{_found(is_mat)}\n{'Names' if is_mat else 'Ports'}, the teacher first, separated by spaces: "
    )
    ports = ports.split() if isinstance(ports, str) else ports
    works = [
        passes(f"robot {port}", partial(check_robot, RobotSettings(port, "", type=kind))) for port in ports
    ]
    foods, camera, calibration = arguments.food_cube, arguments.camera, arguments.calibration
    if is_mat:
        if foods is None:
            question = "Names of the food cubes, one per robot (Enter if a person places the food): "
            foods = _answer(question, "").split()
        works += [
            passes(f"food cube {port}", partial(check_robot, RobotSettings(port, "", type=kind)))
            for port in foods
        ]
    elif camera is None:
        camera = _answer("Camera (a number, a file or a URL): ")
    text = partial(lab_text, kind, ports, foods or (), camera or "", arena=arguments.arena)
    out.write_text(text(calibration), encoding="utf-8")
    settings = load_settings(out)
    if not is_mat:
        picture = out.with_suffix(".png")
        if passes("picture", partial(save_picture, settings, picture)) and calibration is None:
            calibration = _calibrated(camera, settings)
            out.write_text(text(calibration), encoding="utf-8")
            settings = load_settings(out)
        works.append(passes("camera", partial(check_camera, settings)))
        if calibration is None:
            print("next: khepera-forage camera calibrate; name its file as calibration under [camera]")
    print(f"{out} is written")
    print(f"then: khepera-forage lab check {out}; khepera-forage train --lab {out}")
    return 0 if all(works) else 1


def save_picture(settings: LabSettings, file: Path) -> str:
    """Take a picture and save it.

    Raises:
        OSError: The camera cannot be opened, or the file not be written.
    """
    require("a camera", "camera")
    import cv2

    from khepera_forage.vision.video import VideoSource

    with closing(VideoSource(settings.camera.source)) as source:
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
    question = (
        f"Calibrate now, by clicks on the {len(corners)} inner corners of the arenas in a window? (y, n) "
    )
    if _answer(question, "n").lower() not in ("y", "yes"):
        return None
    parser = argparse.ArgumentParser()
    calibrate.add_arguments(parser)
    file = "calibration.toml"
    works = passes(
        "calibration",
        lambda: str(
            calibrate.run(parser.parse_args(["--source", camera, "--out", file, "--places", *corners]))
            or file
        ),
    )
    return file if works else None


def lab_text(
    kind: str, ports: Sequence[str], foods: Sequence[str], camera: str, calibration: str | None, arena: str
) -> str:
    """The text of a `lab.toml` with arenas side by side."""
    x, y, step = _MAT if kind == TOIO.name else _FLOOR
    lines = [f"food_cubes = [{', '.join(map(_quoted, foods))}]"] if foods else []
    # Only the slowest speeds at first: what a robot does then can be stopped by hand.
    lines += ["safe_speed = 6", "", "[arena]", f"name = {_quoted(arena)}"]
    for number, port in enumerate(ports):
        offset = f"offset = [{x}, {y + number * step}]"
        lines += ["", "[[robots]]", f"type = {_quoted(kind)}", f"port = {_quoted(port)}", offset]
    if camera:
        lines += ["", "[camera]", f"source = {camera if camera.isdigit() else _quoted(camera)}"]
        lines += [f"calibration = {_quoted(calibration)}"] if calibration else []
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
    """What the user types; the default for nothing.

    Raises:
        ValueError: No answer, and no default.
    """
    try:
        answer = input(question).strip()
    except EOFError:
        answer = ""
    if not answer and default is None:
        raise ValueError(
            f"{question.splitlines()[-1].rstrip(': ')}: no answer; allowed: an answer, or the option"
        )
    return answer or default or ""


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
