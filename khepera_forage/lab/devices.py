"""The devices of a laboratory: robots at their ports, and the camera."""

from collections.abc import Callable
from contextlib import ExitStack, closing
from typing import Protocol

from khepera_forage.lab.cubes import MatCamera
from khepera_forage.lab.fresh_frames import FreshFrames
from khepera_forage.lab.settings import LabSettings
from khepera_forage.robots.drivers import open_robot
from khepera_forage.robots.fleet import Fleet
from khepera_forage.robots.toio.driver import ToioRobot
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.scene import Scene
from khepera_forage.vision.tracked_camera import TrackedCamera
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.video import FrameSource, VideoSettings, VideoSource

OpenSource = FrameSource | Callable[[], FrameSource] | None
"""A source of frames, a function that opens one, or None for the camera of the settings."""


def open_robots(settings: LabSettings) -> Fleet:
    """Open all robots; if one fails, close the others.

    Raises:
        RobotLost: A robot does not reply.
        ConnectionError: A port cannot be opened.
    """
    with ExitStack() as opened:
        robots = []
        for entry in settings.robots:
            robot = open_robot(
                entry.type,
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


def open_source(
    settings: LabSettings, source: OpenSource, calibration: Calibration | None = None
) -> FrameSource:
    """The source of the frames: that of the settings, a given one, or what a given function opens.

    Raises:
        OSError: The camera cannot be opened.
        ValueError: Its frames have another aspect ratio than the calibration.
    """
    if source is None:
        camera = settings.camera
        size = camera.size or (None if calibration is None else calibration.size)
        return VideoSource(
            camera.source, settings=VideoSettings(size, camera.rate, camera.exposure, camera.focus)
        )
    return source() if callable(source) else source


class Frames(Protocol):
    """What gives a camera its frames, or stands for it."""

    def begin_round(self) -> None:
        """Accept only what was seen from now on."""
        ...

    def forget(self) -> None:
        """Forget what was seen: robots may have been carried, or exchanged."""
        ...


class LabCamera(Protocol):
    """A camera that a laboratory opens and closes."""

    def reset(self) -> None:
        """Forget all tracks, and take the first frame."""
        ...

    def expose(self) -> None:
        """Take the newest frame, once per round."""
        ...

    def look(self) -> Scene:
        """The scene of the last frame."""
        ...

    def close(self) -> None:
        """Release the device; a second call does nothing."""
        ...


class Devices:
    """The robots and the camera, open. Toio cubes on a mat need no camera.

    Args:
        settings: The laboratory's settings.
        source: As for `open_source`. A source itself is used again after a loss; others are opened again.
        calibration: Calibration of the frames; by default the one of the settings.

    Attributes:
        fleet: The robots.
        camera: The camera with its tracker.
        frames: The frames of the camera.
        foods: The toio cubes that are food.

    Raises:
        OSError: A port or the camera cannot be opened, or the calibration cannot be read; as `RobotLost`, that a robot
            does not reply.
        ValueError: The calibration is invalid.
    """

    def __init__(self, settings: LabSettings, source: OpenSource, calibration: Calibration | None) -> None:
        self._source = source
        file = settings.camera.calibration
        self._calibration = (
            Calibration.load(file) if calibration is None and file is not None else calibration
        )
        self.frames: Frames
        self.camera: LabCamera
        self.foods: list[ToioRobot] = []
        if settings.has_mat:
            self._open_cubes(settings)
            return
        self.frames, self.camera = self._open_camera(settings)
        try:
            self.fleet = open_robots(settings)
        except BaseException:
            self.camera.close()
            raise

    def reopen(self, settings: LabSettings) -> None:
        """Open all devices again after a loss, which the user has read about.

        Raises:
            OSError, ValueError: As for the class; call it again then.
        """
        self.fleet.close(report=False)
        if settings.has_mat:
            self.camera.close()
            self._open_cubes(settings)
            return
        if self._source is None or callable(self._source):
            self.camera.close()
            self.frames, self.camera = self._open_camera(settings)
        self.fleet = open_robots(settings)

    def close(self) -> None:
        """Stop the robots, and close all ports and the camera; a second call does nothing."""
        with closing(self.camera):
            self.fleet.close()

    def _open_cubes(self, settings: LabSettings) -> None:
        """Open the robots, then the food; if one fails, close the others."""
        with ExitStack() as opened:
            self.fleet = open_robots(settings)
            opened.callback(self.fleet.close)
            self.foods = []
            for port in settings.food_cubes:
                self.foods.append(ToioRobot(port))
                opened.callback(self.foods[-1].close)
            opened.pop_all()
        holes = [entry.holes for entry in settings.robots]
        self.frames = self.camera = MatCamera(self.cubes, holes, self.foods)

    @property
    def cubes(self) -> list[ToioRobot]:
        """The robots, if they are toio cubes."""
        return [robot for robot in self.fleet.robots if isinstance(robot, ToioRobot)]

    def _open_camera(self, settings: LabSettings) -> tuple[FreshFrames, TrackedCamera]:
        tracker = Tracker(settings.tracker, self._calibration)
        frames = FreshFrames(
            open_source(settings, self._source, self._calibration),
            tracker,
            str(settings.camera.source),
            settings.camera.oldest,
            settings.period,
            self._pulses,
            lambda: self.fleet.stop(),
        )
        return frames, TrackedCamera(frames, tracker)

    def _pulses(self) -> list[int]:
        """The encoder counters of all robots."""
        return [count for robot in self.fleet.robots for count in robot.sense()[1:3]]
