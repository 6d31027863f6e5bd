"""The settings of a laboratory: robots, camera and arena, as in a `lab.toml`."""

from dataclasses import dataclass, field, replace
from pathlib import Path

from khepera_forage.robots.khepera import MAX_SPEED
from khepera_forage.robots.model import KHEPERA, MODELS, TOIO, RobotModel
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.vision.tracker_settings import TrackerSettings

ORIGIN = Point(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """One robot of the laboratory.

    Attributes:
        port: Any argument of `serial.serial_for_url`: a device, `socket://host:port`, `rfc2217://host:port`; name or
            address of a toio cube.
        name: Name of the robot in requests to the operator.
        type: Kind of robot, a name in `MODELS`.
        baud: Of a serial line; None for the usual one of the robot.
        holes: Number of its marker: how many holes it has, 1 or 2; of other kinds of markers the number or id.
        offset: From the arena in the file to this robot's copy of it, in mm.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes.
        watchdog: Whether a process stops the robot if this one is killed or frozen.
    """

    port: str
    name: str
    baud: int | None = None
    holes: int = 2
    offset: Point = ORIGIN
    timeout: float = DEFAULT_TIMEOUT
    watchdog: bool = True
    type: str = KHEPERA.name

    @property
    def model(self) -> RobotModel:
        """What the robot can do."""
        return MODELS[self.type]


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """The camera above all arenas.

    Attributes:
        source: Any source of OpenCV: the number of a device, a file, a URL.
        calibration: A file written by `khepera-forage camera calibrate`; None for frames without distortion.
        oldest: Seconds after which the camera counts as lost: the age of the newest frame, or the wait for one that
            shows the scene of the present round.
        size: Width and height of the frames; None for those of the calibration, or 640 x 480.
        rate: Frames a second; None leaves the camera's own, as for exposure and focus.
        exposure: In the driver's unit.
        focus: In the driver's unit.
    """

    source: int | str = 0
    calibration: Path | None = None
    oldest: float = 0.5
    size: tuple[int, int] | None = None
    rate: float | None = None
    exposure: float | None = None
    focus: float | None = None


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Allowed deviations of robots and food from their places.

    Attributes:
        position: In mm.
        heading: In degrees.
    """

    position: float = 15.0
    heading: float = 10.0


@dataclass(frozen=True, slots=True)
class LabSettings:
    """The contents of a `lab.toml`.

    Attributes:
        arena: The arena, without the offsets of the robots.
        robots: The teacher first, then the learners; in a recall the last one forages.
        camera: Settings of the camera.
        period: Duration of a round in seconds.
        tracker: Settings of the camera's tracker.
        tolerance: Allowed deviations of the operator's placement.
        safe_speed: Limit of all wheel speeds in speed units (8 mm/s).
        food_cubes: Names or addresses of the toio cubes that are the food, one per object; empty for other food.
    """

    arena: Arena
    robots: tuple[RobotSettings, ...]
    camera: CameraSettings
    period: float
    tracker: TrackerSettings = field(default_factory=TrackerSettings)
    tolerance: Tolerance = Tolerance()
    safe_speed: int = MAX_SPEED
    food_cubes: tuple[str, ...] = ()

    @property
    def has_mat(self) -> bool:
        """Whether the robots are toio cubes, which see their places on a mat themselves."""
        return self.robots[0].type == TOIO.name

    @property
    def arenas(self) -> tuple[Arena, ...]:
        """The copy of the arena of every robot."""
        return tuple(self.arena.shifted(*robot.offset) for robot in self.robots)

    def for_recall(self) -> "LabSettings":
        """The settings for a recall: only the last robot takes part."""
        return replace(self, robots=self.robots[-1:])
