"""What makes up a laboratory: its robots, its camera, its arena, as a `lab.toml` says it."""

from dataclasses import dataclass, field, replace
from pathlib import Path

from khepera_forage.robots.khepera import CONTROL_PERIOD, MAX_SPEED
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.vision.tracker_settings import TrackerSettings

ORIGIN = Point(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """One robot of the laboratory.

    Attributes:
        port: What `serial.serial_for_url` opens: a device, `socket://host:port`, `rfc2217://host:port`.
        name: How the operator is told of it.
        baud: One of `BAUD_RATES`.
        holes: Of the marker on its back, 1 or 2.
        offset: From the arena of the file to this robot's own copy of it, in mm.
    """

    port: str
    name: str
    baud: int = 38400
    holes: int = 2
    offset: Point = ORIGIN


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """The camera above all arenas.

    Attributes:
        source: What OpenCV opens: the number of a device, a file, a URL.
        calibration: A file that `khepera-forage camera calibrate` has written; None for a picture that needs none.
        oldest: Age in seconds of the newest frame beyond which the camera counts as lost.
    """

    source: int | str
    calibration: Path | None = None
    oldest: float = 0.5


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far from its mark something may stand after the operator has placed it.

    Attributes:
        position: In mm.
        heading: In degrees.
    """

    position: float = 15.0
    heading: float = 10.0


@dataclass(frozen=True, slots=True)
class LabSettings:
    """What a `lab.toml` says.

    Attributes:
        arena: The arena of the first robot, before its offset.
        robots: The teacher first, then the learners; in a recall the last one forages.
        camera: Above them.
        tracker: What it takes for a marker and for food.
        tolerance: Of what the operator places.
        safe_speed: Speed units (8 mm/s) beyond which no wheel is commanded.
        period: Of a round in seconds.
    """

    arena: Arena
    robots: tuple[RobotSettings, ...]
    camera: CameraSettings
    tracker: TrackerSettings = field(default_factory=TrackerSettings)
    tolerance: Tolerance = Tolerance()
    safe_speed: int = MAX_SPEED
    period: float = CONTROL_PERIOD

    @property
    def arenas(self) -> tuple[Arena, ...]:
        """Every robot's own copy of the arena."""
        return tuple(self.arena.shifted(*robot.offset) for robot in self.robots)

    def alone(self) -> "LabSettings":
        """The laboratory of a recall: the last robot forages, the others are left alone."""
        return replace(self, robots=self.robots[-1:])
