"""`khepera-forage lab check`: what is wrong with a laboratory, in the order in which it must be repaired."""

import argparse
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path

from khepera_forage.envs.laboratories import load_settings
from khepera_forage.extras import require
from khepera_forage.lab.settings import LabSettings, RobotSettings
from khepera_forage.robots.drivers import open_robot
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.toio.driver import ToioRobot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "file", type=Path, nargs="?", default=Path("lab.toml"), help="the laboratory (lab.toml)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Check the file, then every robot, then the camera, and print a line for each; nothing moves.

    Returns:
        0 if all is well, otherwise 1.

    Raises:
        ValueError: The file has a mistake.
        OSError: The file cannot be read.
    """
    settings = load_settings(arguments.file)
    print(f"{arguments.file}: {len(settings.robots)} robots, arena {settings.arena.name}", flush=True)
    results = [passes(f"robot {r.name}", partial(check_robot, r, settings.period)) for r in settings.robots]
    for port in settings.food_cubes:
        food = RobotSettings(port, "food", type=settings.robots[0].type)
        results.append(passes(f"food cube {port}", partial(check_robot, food, settings.period)))
    if not settings.has_mat:
        results.append(passes("camera", partial(check_camera, settings)))
    failed = results.count(False)
    print("all is well" if not failed else f"{failed} to repair; begin with the first", flush=True)
    return 1 if failed else 0


def passes(name: str, check: Callable[[], str]) -> bool:
    """Check a part, and print the result.

    Args:
        name: Of the part.
        check: Returns what it found, or raises `OSError`, `ValueError` or `ImportError`.
    """
    try:
        verdict, found = "pass", check()
    except (OSError, ValueError, ImportError) as error:
        verdict, found = "FAIL", str(error)
    print(f"{name:24s} {verdict}   {found}", flush=True)
    return verdict == "pass"


def check_robot(entry: RobotSettings, period: float = CONTROL_PERIOD) -> str:
    """Open a robot and flash its lamps.

    Raises:
        OSError: It cannot be opened, does not reply, is of another kind, or its line is too slow; or it is off its mat.
    """
    with open_robot(
        entry.type, entry.port, timeout=entry.timeout, watchdog=entry.watchdog, period=period, baud=entry.baud
    ) as robot:
        robot.receive()
        robot.flash()
        if isinstance(robot, ToioRobot):
            if not robot.on_mat:
                raise OSError(f"{entry.port} does not see the mat: put it on the mat")
            return f"{entry.type} at {entry.port}, on the mat at x {robot.pose.x:.0f} mm, y {robot.pose.y:.0f} mm"
        return f"{entry.type} at {entry.port}; a round takes at most {1000 * robot.longest_exchange:.0f} ms"


def check_camera(settings: LabSettings) -> str:
    """Take a picture, and look for the markers of all robots.

    Raises:
        OSError: The camera or its calibration cannot be opened, or a marker is not seen.
        ValueError: The calibration is invalid, or the frames have another form.
    """
    require("a camera", "camera")
    from khepera_forage.lab.localisation import find_marker
    from khepera_forage.vision.calibration import Calibration
    from khepera_forage.vision.tracked_camera import TrackedCamera
    from khepera_forage.vision.tracker import Tracker
    from khepera_forage.vision.video import VideoSource

    file = settings.camera.calibration
    calibration = None if file is None else Calibration.load(file)
    with closing(
        TrackedCamera(VideoSource(settings.camera.source), Tracker(settings.tracker, calibration))
    ) as camera:
        camera.reset()
        scene = camera.look()
    missing = [
        robot.name
        for robot, arena in zip(settings.robots, settings.arenas, strict=True)
        if find_marker(scene, arena, robot.holes) is None
    ]
    if missing:
        raise OSError(
            f"no marker of {', '.join(missing)} is seen in its arena: put each robot into its own arena"
        )
    calibrated = "calibrated" if calibration else "without a calibration"
    return f"source {settings.camera.source}, {calibrated}; all markers seen"
