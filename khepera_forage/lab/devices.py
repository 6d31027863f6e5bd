"""Taking hold of what a `lab.toml` names: the robots at their ports, the camera at its source."""

from contextlib import ExitStack

from khepera_forage.lab.settings import LabSettings
from khepera_forage.robots.serial.fleet import Fleet
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.tracked_camera import TrackedCamera
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.video import FrameSource, VideoSource


def open_robots(settings: LabSettings) -> Fleet:
    """All robots, or none of them.

    Raises:
        RobotLost: A robot does not answer.
        ConnectionError: A port cannot be opened.
    """
    with ExitStack() as opened:
        robots = []
        for entry in settings.robots:
            robot = SerialKhepera(entry.port, baud=entry.baud, max_speed=settings.safe_speed)
            opened.callback(robot.close)
            robots.append(robot)
        opened.pop_all()
    return Fleet(robots)


def open_camera(
    settings: LabSettings, source: FrameSource | None = None, calibration: Calibration | None = None
) -> TrackedCamera:
    """The camera with its tracker.

    Args:
        settings: What they are.
        source: Of frames, instead of the settings'.
        calibration: Of these frames, instead of the settings'.

    Raises:
        OSError: The camera or the calibration's file cannot be opened.
        ValueError: The calibration cannot be used.
    """
    file = settings.camera.calibration
    if calibration is None and file is not None:
        calibration = Calibration.load(file)
    tracker = Tracker(settings.tracker, calibration)
    return TrackedCamera(VideoSource(settings.camera.source) if source is None else source, tracker)
