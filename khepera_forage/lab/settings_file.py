"""The settings of a laboratory, robots, camera and arena, and reading them from a `lab.toml`.

`sample.toml` explains every key; `python -m khepera_forage.lab.settings_file` prints it.
"""

from dataclasses import dataclass, field, fields, replace
from importlib import resources
from pathlib import Path
from typing import Any

from khepera_forage.robots.drivers import DRIVERS, open_robot
from khepera_forage.robots.khepera import MAX_SPEED
from khepera_forage.robots.mat import MatRobot
from khepera_forage.robots.model import KHEPERA
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT, MAX_TIMEOUT
from khepera_forage.robots.serial.serial_robot import SerialRobot
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.arena_file import ArenaPlan, plan_of
from khepera_forage.sim.arenas.named import ARENAS, named_arena
from khepera_forage.sim.arenas.thesis import CORRIDOR, SetUp
from khepera_forage.sim.layout_checks import check_seen
from khepera_forage.toml_table import (
    Reader,
    anything,
    content_of,
    is_number,
    list_of,
    naming,
    number,
    numbers,
    one_of,
    refusal,
    table,
    text,
    true_or_false,
)
from khepera_forage.vision.tracker_settings import MARKER_NUMBERS, TrackerSettings
from khepera_forage.vision.video import VideoSettings

ORIGIN = Point(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """One robot of the laboratory: the keys of a table `[[robots]]`, see `sample.toml`."""

    port: str
    name: str
    baud: int | None = None
    holes: int = 2
    offset: Point = ORIGIN
    timeout: float = DEFAULT_TIMEOUT
    watchdog: bool = True
    type: str = KHEPERA.name

    def open(self, period: float, max_speed: int | None = None) -> RealRobot:
        """Open the robot for rounds of `period` seconds; errors are those of its driver."""
        return open_robot(
            self.type,
            self.port,
            baud=self.baud,
            max_speed=max_speed,
            timeout=self.timeout,
            watchdog=self.watchdog,
            period=period,
        )


@dataclass(frozen=True, slots=True)
class CameraSettings(VideoSettings):
    """The camera above all arenas: the keys of the table `[camera]`, see `sample.toml`."""

    source: int | str = 0
    calibration: Path | None = None
    oldest: float = 0.5


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Allowed deviations of robots and food from their places, in mm and degrees."""

    position: float = 15.0
    heading: float = 10.0


@dataclass(frozen=True, slots=True)
class LabSettings:
    """The contents of a `lab.toml`; `sample.toml` explains every key.

    Attributes:
        arena: The arena, without the offsets of the robots.
        robots: The teacher first, then the learners; in a recall the last one forages.
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
        """Whether the robots report their places on a mat themselves."""
        return issubclass(DRIVERS[self.robots[0].type], MatRobot)

    @property
    def food_robots(self) -> tuple[RobotSettings, ...]:
        """The food cubes, which are of the robots' kind."""
        return tuple(RobotSettings(port, f"food cube {port}", type=self.robots[0].type) for port in self.food_cubes)

    @property
    def arenas(self) -> tuple[Arena, ...]:
        """The copy of the arena of every robot."""
        return tuple(self.arena.shifted(*robot.offset) for robot in self.robots)

    def for_recall(self) -> "LabSettings":
        """The settings for a recall: only the last robot takes part."""
        return replace(self, robots=self.robots[-1:])


def parse(toml: str, set_up: SetUp, period: float, folder: Path = Path()) -> LabSettings:
    """Parse the text of a file; `envs.laboratories.load_settings` reads one.

    Args:
        toml: The text.
        set_up: Where start, food and home are in an arena that the text only names.
        period: Duration of a round in seconds, if the text does not set it.
        folder: That of a calibration file with a relative path.
    """
    given = table("", content_of(toml), _KEYS)
    given["arena"] = _arena(given.get("arena", {}), set_up)
    tracker = given.setdefault("tracker", TrackerSettings())
    entries = list_of(anything, 0, "one or more tables [[robots]]")("robots", given.get("robots", []))
    robots = given["robots"] = tuple(_robot(i, entry, tracker.markers) for i, entry in enumerate(entries))
    if not robots:
        raise ValueError("robots is empty; allowed: at least one table [[robots]]")
    if issubclass(DRIVERS[robots[0].type], MatRobot) and "camera" not in given:
        given["camera"] = CameraSettings()
    else:
        camera = table("camera", given.get("camera", {}), _CAMERA_KEYS, ["source"])
        if "calibration" in camera:
            camera["calibration"] = folder / camera["calibration"]
        given["camera"] = CameraSettings(**camera)
    if tracker.markers != "holes":  # an error if a robot and food have the same tag
        given["tracker"] = replace(tracker, numbers=tuple(sorted({robot.holes for robot in robots})))
    settings = LabSettings(**{"period": period, **given})
    _check(settings)
    return settings


def sample() -> str:
    """The commented sample file of the package."""
    return resources.files("khepera_forage.lab").joinpath("sample.toml").read_text(encoding="utf-8")


def _robot(index: int, value: Any, markers: str) -> RobotSettings:
    key = f"robots[{index}]"
    given = table(key, value, _ROBOT_KEYS | {"holes": one_of(MARKER_NUMBERS[markers])}, ["port"])
    driver = DRIVERS[given.get("type", KHEPERA.name)]
    if issubclass(driver, SerialRobot):
        baud = given.get("baud", driver.protocol.baud)
        given["baud"] = one_of(driver.protocol.baud_rates)(f"{key}.baud", baud)
    elif ignored := [name for name in ("baud", "timeout", "watchdog") if name in given]:
        raise ValueError(f"{key}.{ignored[0]} is given; allowed: for a robot with a serial line")
    name = f"learner_{index - 1}" if index else "teacher"
    return RobotSettings(**{"name": name, "holes": usual_marker(index, markers), **given})


def usual_marker(index: int, markers: str) -> int:
    """The marker of a robot by its number, the teacher's 0; of the thesis's markers, all learners have the second."""
    return min(index + 1, 2) if markers == "holes" else index + 1


def _source(key: str, value: Any) -> int | str:
    if (isinstance(value, str) and value.strip()) or (type(value) is int and value >= 0):
        return value
    raise refusal(key, value, "the number of a device, the name of a file, or a URL")


def _tracker(key: str, value: Any) -> TrackerSettings:
    """Any field of `TrackerSettings` but the numbers in use, as a key of the same name."""
    readers: dict[type, Reader] = {bool: true_or_false, str: text, tuple: list_of(one_of(MARKER_NUMBERS["tags"]), 0)}
    keys = {f.name: readers.get(type(f.default), _any_number) for f in fields(TrackerSettings)}
    del keys["numbers"]
    return TrackerSettings(**table(key, value, keys))


def _any_number(key: str, value: Any) -> float:
    if not is_number(value):
        raise refusal(key, value, "a number")
    return value  # type: ignore[no-any-return]


def _arena(value: Any, set_up: SetUp) -> Arena:
    given = table("arena", value, dict.fromkeys(ArenaPlan._fields, anything))
    if "walls" in given:
        plan = plan_of("arena", value)
        with naming("arena"):
            return plan.arena()
    name = text("arena.name", given.get("name", CORRIDOR))
    if name not in ARENAS:
        raise ValueError(
            f"arena.name is {name!r} and there are no walls; allowed: {', '.join(ARENAS)}, "
            "or another name with walls, home, home_radius, start and foods"
        )
    table("arena", value, {"name": text, "walls": anything})  # without walls, the others have no effect
    return named_arena(name, set_up)


def _check(settings: LabSettings) -> None:
    """Check what robots share: one type, unique ports and names, arenas side by side and in view, or on the mat."""
    arenas = settings.arenas
    for i, robot in enumerate(settings.robots):
        offset = f"robots[{i}].offset is {list(robot.offset)}"
        for j, other in enumerate(settings.robots[:i]):
            unique = {"port": "one port a robot", "name": "one name each"}
            if settings.tracker.markers == "tags":
                unique["holes"] = "one tag each"
            for key, allowed in unique.items():
                value = getattr(robot, key)
                if value == getattr(other, key):
                    raise ValueError(f"robots[{i}].{key} is {value!r}, as robots[{j}].{key}; allowed: {allowed}")
            (x1, y1, x2, y2), (left, low, right, high) = arenas[i].bounds, arenas[j].bounds
            if x1 < right and left < x2 and y1 < high and low < y2:
                raise ValueError(f"{offset}: its arena overlaps that of robots[{j}]; allowed: arenas side by side")
        if not settings.has_mat:
            try:
                check_seen((arenas[i],))
            except ValueError as error:
                raise ValueError(f"{offset}: {error}") from None
    kinds = sorted({robot.type for robot in settings.robots})
    if len(kinds) > 1:
        raise ValueError(f"robots are of types {', '.join(kinds)}; allowed: one type, because each has its own scale")
    driver = DRIVERS[kinds[0]]
    if not issubclass(driver, MatRobot):
        if settings.food_cubes:
            on_mat = [kind for kind, each in DRIVERS.items() if issubclass(each, MatRobot)]
            raise ValueError(f"food_cubes is given; allowed: for robots of type {', '.join(on_mat)}")
        return
    if not settings.food_cubes and settings.arena.foods:
        raise ValueError(f"food_cubes is empty; allowed with {kinds[0]}: a cube for each food (a mat sees no other)")
    cubes = [*(robot.port for robot in settings.robots), *settings.food_cubes]
    for cube in settings.food_cubes:
        if cubes.count(cube) > 1:
            raise ValueError(f"food_cubes has {cube!r}, which is given twice; allowed: a cube of its own for each food")
    width, height = driver.mat_size
    for i, arena in enumerate(arenas):
        if not fits(arena, width, height):
            raise ValueError(
                f"robots[{i}].offset is {list(settings.robots[i].offset)}: its arena leaves the mat; allowed: within "
                f"0 to {width:.0f} and 0 to {height:.0f} mm"
            )


def fits(arena: Arena, width: float, height: float) -> bool:
    """Whether an arena lies on a mat of this size, whose corner is the origin."""
    x1, y1, x2, y2 = arena.bounds
    return x1 >= 0 and y1 >= 0 and x2 <= width and y2 <= height


_TOLERANCE_KEYS = {"position": number(1.0, 100.0, "mm"), "heading": number(1.0, 90.0, "degrees")}
_KEYS: dict[str, Reader] = {
    "arena": anything,
    "robots": anything,
    "camera": anything,
    "period": number(0.05, 0.5, "seconds"),
    "tracker": _tracker,
    "tolerance": lambda key, value: Tolerance(**table(key, value, _TOLERANCE_KEYS)),
    "safe_speed": one_of(range(1, MAX_SPEED + 1)),
    "food_cubes": list_of(text, 0),
}
_ROBOT_KEYS: dict[str, Reader] = {
    "type": one_of(tuple(DRIVERS)),
    "port": text,
    "name": text,
    "baud": anything,
    "timeout": number(0.01, MAX_TIMEOUT, "seconds"),
    "watchdog": true_or_false,
    "offset": lambda key, value: Point(*numbers("[x mm, y mm]")(key, value)),
}
_CAMERA_KEYS: dict[str, Reader] = {
    "source": _source,
    "calibration": text,
    "oldest": number(0.05, 10.0, "seconds"),
    "size": list_of(anything, 0, "[width, height] in pixels"),  # `VideoSettings` checks the numbers
    "rate": number(0.1, 1000.0, "frames a second"),
    "exposure": number(-1e6, 1e6, "the driver's unit"),
    "focus": number(-1e6, 1e6, "the driver's unit"),
}

if __name__ == "__main__":
    print(sample(), end="")
