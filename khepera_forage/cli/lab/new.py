"""`khepera-forage lab new`: find robots and camera, check each, and write `lab.toml`."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from khepera_forage.cli.lab.check import check_camera, check_robot, passes
from khepera_forage.envs.laboratories import load_settings
from khepera_forage.lab.settings import RobotSettings
from khepera_forage.robots.model import MODELS, TOIO
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
    """Ask for what is missing, check each device, write the file, and say what to do next.

    Returns:
        0 if all devices work, otherwise 1; the file is written in any case.

    Raises:
        FileExistsError: The file is there already.
        ValueError: An answer that is not allowed.
    """
    ask = input
    if arguments.out.exists():
        raise FileExistsError(f"{arguments.out} is there already; allowed: another --out")
    kind = arguments.robot or _answer(ask, f"Kind of robots ({', '.join(MODELS)}): ")
    if kind not in MODELS:
        raise ValueError(f"robot {kind!r}; allowed: {', '.join(MODELS)}")
    is_mat = kind == TOIO.name
    ports: Sequence[str] = (
        arguments.port
        or _answer(ask, f"{_found_ports(is_mat)}Ports, the teacher first, separated by spaces: ").split()
    )
    names = [
        "teacher" if i == 0 and len(ports) > 1 else f"learner_{max(0, i - 1)}" for i in range(len(ports))
    ]
    robots = [RobotSettings(port, name, type=kind) for port, name in zip(ports, names, strict=True)]
    works = [passes((f"robot {r.name}", lambda r=r: check_robot(r))) for r in robots]  # type: ignore[misc]
    foods: Sequence[str] = ()
    if is_mat:
        foods = arguments.food_cube
        if foods is None:
            foods = ask(
                "Names of the food cubes, one per robot (Enter if a person places the food): "
            ).split()
        food_robots = [RobotSettings(port, "food", type=kind) for port in foods]
        works += [passes((f"food cube {f.port}", lambda f=f: check_robot(f))) for f in food_robots]  # type: ignore[misc]
    camera = "" if is_mat else arguments.camera or _answer(ask, "Camera (a number, a file or a URL): ")
    arguments.out.write_text(
        lab_text(kind, ports, foods, camera, arguments.calibration, arguments.arena), encoding="utf-8"
    )
    print(f"{arguments.out} is written")
    settings = load_settings(arguments.out)
    if not is_mat:
        works.append(passes(("camera", lambda: check_camera(settings))))
        if arguments.calibration is None:
            print(
                "next: calibrate the camera with `khepera-forage camera calibrate`, and name the file under [camera]"
            )
    print(f"then: khepera-forage lab check {arguments.out}; khepera-forage train --lab {arguments.out}")
    return 0 if all(works) else 1


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


def _found_ports(is_mat: bool) -> str:
    """The serial ports of this computer, for a question."""
    if is_mat:
        return (
            "The name of a cube is on its packing and in the list of Bluetooth devices, such as toio-A1b.\n"
        )
    from khepera_forage.extras import require

    require("a serial port", "robots")
    from serial.tools.list_ports import comports

    found = [f"  {port.device}   {port.description}" for port in comports()]
    return "\n".join(["Serial ports of this computer:", *(found or ["  none"]), ""])


def _answer(ask: Callable[[str], str], question: str) -> str:
    answer = ask(question).strip()
    if not answer:
        raise ValueError(f"{question.splitlines()[-1].rstrip(': ')}: no answer; allowed: an answer")
    return answer


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
