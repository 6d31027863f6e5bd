"""Opening the devices of a laboratory: robots at their ports, and the camera."""

from contextlib import ExitStack

from khepera_forage.lab.settings import LabSettings
from khepera_forage.robots.serial.fleet import Fleet
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.tracked_camera import TrackedCamera
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.video import FrameSource, VideoSource


def open_robots(settings: LabSettings) -> Fleet:
    """Open all robots; if one fails, close the others.

    Raises:
        RobotLost: A robot does not reply.
        ConnectionError: A port cannot be opened.
    """
    with ExitStack() as opened:
        robots = []
        for entry in settings.robots:
            robot = SerialKhepera(
                entry.port,
                baud=entry.baud,
                max_speed=settings.safe_speed,
                timeout=entry.timeout,
                watchdog=entry.watchdog,
                period=settings.period,
            )
            opened.callback(robot.close)
            robots.append(robot)
        opened.pop_all()
    return Fleet(robots)


def open_camera(
    settings: LabSettings, source: FrameSource | None = None, calibration: Calibration | None = None
) -> TrackedCamera:
    """Open the camera with its tracker.

    Args:
        settings: The laboratory's settings.
        source: Source of the frames; by default the one of the settings.
        calibration: Calibration of the frames; by default the one of the settings.

    Raises:
        OSError: The camera or the calibration file cannot be opened.
        ValueError: The calibration is invalid.
    """
    file = settings.camera.calibration
    if calibration is None and file is not None:
        calibration = Calibration.load(file)
    tracker = Tracker(settings.tracker, calibration)
    return TrackedCamera(VideoSource(settings.camera.source) if source is None else source, tracker)
