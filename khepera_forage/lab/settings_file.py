"""Reading `lab.toml`, the settings of a laboratory.

`sample.toml` explains every key; `python -m khepera_forage.lab.settings_file` prints it.
"""

from collections.abc import Sequence
from dataclasses import fields, replace
from importlib import resources
from pathlib import Path
from typing import Any

from khepera_forage.lab.settings import ORIGIN, CameraSettings, LabSettings, RobotSettings, Tolerance
from khepera_forage.robots.drivers import serial_driver
from khepera_forage.robots.khepera import MAX_SPEED
from khepera_forage.robots.model import KHEPERA, MODELS, TOIO
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT, MAX_TIMEOUT
from khepera_forage.robots.toio.driver import SIMPLE_MAT
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.arena_file import ArenaPlan, arena_of
from khepera_forage.sim.arenas.named import ARENAS, named_arena
from khepera_forage.sim.arenas.thesis import CORRIDOR, SetUp
from khepera_forage.sim.layout_checks import check_seen
from khepera_forage.toml_table import (
    Table,
    TableError,
    list_of,
    number,
    numbers,
    one_of,
    quoted,
    table_of,
    text,
    text_of,
    true_or_false,
)
from khepera_forage.vision.tracker_settings import MARKER_NUMBERS, TrackerSettings


class LabFileError(ValueError):
    """An invalid `lab.toml`; the message names the file and the key."""


def load(path: Path | str, set_up: SetUp, period: float) -> LabSettings:
    """Read a file.

    Args:
        path: The file.
        set_up: Where start, food and home are in an arena that the file only names.
        period: Duration of a round in seconds, if the file does not set it.

    Raises:
        LabFileError: The file is not TOML, or a key is missing, unknown, or has a value that is not allowed.
        OSError: The file cannot be read.
    """
    path = Path(path)
    try:
        return parse(text_of(path), set_up, period, path.parent)
    except (TableError, LabFileError) as error:
        raise LabFileError(f"{path}: {error}") from None


def parse(toml: str, set_up: SetUp, period: float, folder: Path = Path()) -> LabSettings:
    """Parse the text of a file.

    Args:
        toml: The text.
        set_up: As for `load`.
        period: As for `load`.
        folder: Folder of a calibration file with a relative path.

    Raises:
        LabFileError: As `load`.
    """
    try:
        return _lab_settings(table_of(toml), folder, set_up, period)
    except TableError as error:
        raise LabFileError(str(error)) from None


def sample() -> str:
    """The commented sample file of the package."""
    return resources.files("khepera_forage.lab").joinpath("sample.toml").read_text(encoding="utf-8")


def _lab_settings(table: Table, folder: Path, set_up: SetUp, default_period: float) -> LabSettings:
    table.check_keys(_names(LabSettings))
    arena = _arena(table.table("arena"), set_up)
    tracker = _tracker(table.table("tracker"))
    allowed = MARKER_NUMBERS[tracker.markers]
    robots = tuple(_robot(entry, i, allowed) for i, entry in enumerate(table.tables("robots")))
    if not robots:
        raise TableError("robots is empty; allowed: at least one table [[robots]]")
    food_cubes: tuple[str, ...] = table.take("food_cubes", list_of(text, 0), tuple[str, ...]())
    if robots[0].type == "toio" and not table.has("camera"):
        camera = CameraSettings()
    else:
        camera = _camera(table.table("camera"), folder)
    if tracker.markers != "holes":
        try:
            tracker = replace(tracker, numbers=tuple(sorted({robot.holes for robot in robots})))
        except ValueError as error:  # a robot and food have the same tag
            raise TableError(str(error)) from None
    tolerance_table = table.table("tolerance")
    tolerance_table.check_keys(_names(Tolerance))
    defaults = Tolerance()
    tolerance = Tolerance(
        tolerance_table.take("position", number(1.0, 100.0, "mm"), defaults.position),
        tolerance_table.take("heading", number(1.0, 90.0, "degrees"), defaults.heading),
    )
    safe_speed = table.take("safe_speed", one_of(range(1, MAX_SPEED + 1)), MAX_SPEED)
    period = table.take("period", number(0.05, 0.5, "seconds"), default_period)
    settings = LabSettings(arena, robots, camera, period, tracker, tolerance, safe_speed, food_cubes)
    _check_robots(settings)
    _check_mat(settings)
    return settings


def _robot(table: Table, index: int, markers: Sequence[int]) -> RobotSettings:
    name = "teacher" if index == 0 else f"learner_{index - 1}"
    table.check_keys(_names(RobotSettings))
    kind = table.take("type", _kind, KHEPERA.name)
    driver = serial_driver(kind)
    if driver is None and table.has("baud"):
        raise TableError(
            f"{table.key('baud')} is given; allowed: for a robot with a serial line, not for {kind}"
        )
    return RobotSettings(
        port=table.take("port", text),
        name=table.take("name", text, name),
        type=kind,
        baud=None
        if driver is None
        else table.take("baud", one_of(driver.protocol.baud_rates), driver.default_baud),
        holes=table.take("holes", one_of(markers), 1 if index == 0 else 2),
        timeout=table.take("timeout", number(0.01, MAX_TIMEOUT, "seconds"), DEFAULT_TIMEOUT),
        watchdog=table.take("watchdog", true_or_false, True),
        offset=Point(*table.take("offset", numbers("[x mm, y mm]"), tuple(ORIGIN))),
    )


def _kind(key: str, value: Any) -> str:
    """A reader of the kind of a robot."""
    if value not in MODELS:
        raise TableError(f"{key} is {quoted(value)}; allowed: {', '.join(MODELS)}")
    return str(value)


def _camera(table: Table, folder: Path) -> CameraSettings:
    def source(key: str, value: Any) -> int | str:
        if isinstance(value, str) and value.strip():
            return value
        if type(value) is int and value >= 0:
            return value
        raise TableError(
            f"{key} is {quoted(value)}; allowed: the number of a device, the name of a file, or a URL"
        )

    def size(key: str, value: Any) -> tuple[int, int]:
        if (
            isinstance(value, list)
            and len(value) == 2
            and all(type(n) is int and 16 <= n <= 16384 for n in value)
        ):
            return value[0], value[1]
        raise TableError(f"{key} is {quoted(value)}; allowed: [width, height] in pixels")

    table.check_keys(_names(CameraSettings))
    calibration = table.take("calibration", text, "")
    return CameraSettings(
        source=table.take("source", source),
        calibration=folder / calibration if calibration else None,
        oldest=table.take("oldest", number(0.05, 10.0, "seconds"), 0.5),
        size=table.take("size", size, None),
        rate=table.take("rate", number(0.1, 1000.0, "frames a second"), None),
        exposure=table.take("exposure", number(-1e6, 1e6, "the driver's unit"), None),
        focus=table.take("focus", number(-1e6, 1e6, "the driver's unit"), None),
    )


def _tracker(table: Table) -> TrackerSettings:
    """Any field of `TrackerSettings` but the numbers in use, as a key of the same name."""
    names, defaults = set(_names(TrackerSettings)) - {"numbers"}, TrackerSettings()
    table.check_keys(names)
    readers: dict[type, Any] = {
        bool: true_or_false,
        str: text,
        tuple: list_of(one_of(MARKER_NUMBERS["tags"]), 0),
    }
    settings = {}
    for name in names:
        default = getattr(defaults, name)
        settings[name] = table.take(name, readers.get(type(default), _any_number), default)
    try:
        return replace(defaults, numbers=(1, 2), **settings)
    except ValueError as error:
        raise TableError(str(error)) from None


def _any_number(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TableError(f"{key} is {quoted(value)}; allowed: a number")
    return value


def _arena(table: Table, set_up: SetUp) -> Arena:
    table.check_keys(ArenaPlan._fields)
    if table.has("walls"):
        return arena_of(table)
    name = table.take("name", text, CORRIDOR)
    if name not in ARENAS:
        raise TableError(
            f"{table.key('name')} is {name!r} and there are no walls; allowed: {', '.join(ARENAS)}, "
            "or another name with walls, home, home_radius, start and foods"
        )
    table.check_keys(("name", "walls"))  # without walls, the others have no effect
    return named_arena(name, set_up)


def _names(settings: type[Any]) -> list[str]:
    """The keys of a table, which are the fields of a dataclass."""
    return [field.name for field in fields(settings)]


def _check_robots(settings: LabSettings) -> None:
    """Check that ports and names are unique, and that the arenas do not overlap and are in the camera's view."""
    for i, robot in enumerate(settings.robots):
        for j, other in enumerate(settings.robots[:i]):
            if robot.port == other.port:
                raise TableError(
                    f"robots[{i}].port is {robot.port!r}, as robots[{j}].port; allowed: one port a robot"
                )
            if robot.name == other.name:
                raise TableError(
                    f"robots[{i}].name is {robot.name!r}, as robots[{j}].name; allowed: one name each"
                )
            if _overlap(settings.arenas[i], settings.arenas[j]):
                raise TableError(
                    f"robots[{i}].offset is {list(robot.offset)}: its arena overlaps that of robots[{j}]; "
                    "allowed: arenas side by side"
                )
        try:
            check_seen((settings.arenas[i],))
        except ValueError as error:
            raise TableError(f"robots[{i}].offset is {list(robot.offset)}: {error}") from None


def _check_mat(settings: LabSettings) -> None:
    """Check that toio cubes are on a mat that has room for their arenas, and that no other robots are with them."""
    kinds = {robot.type for robot in settings.robots}
    if TOIO.name not in kinds:
        if settings.food_cubes:
            raise TableError("food_cubes is given; allowed: for robots of type toio")
        return
    if len(kinds) > 1:
        raise TableError(
            f"robots are of types {', '.join(sorted(kinds))}; allowed: toio cubes alone, or other robots"
        )
    width, height = SIMPLE_MAT.size
    for i, arena in enumerate(settings.arenas):
        x1, y1, x2, y2 = arena.bounds
        if not (x1 >= 0 and x2 <= width and y1 >= 0 and y2 <= height):
            raise TableError(
                f"robots[{i}].offset is {list(settings.robots[i].offset)}: its arena leaves the mat; allowed: within "
                f"0 to {width:.0f} and 0 to {height:.0f} mm"
            )


def _overlap(a: Arena, b: Arena) -> bool:
    ax1, ay1, ax2, ay2 = a.bounds
    bx1, by1, bx2, by2 = b.bounds
    return ax1 < bx2 and bx1 < ax2 and ay1 < by2 and by1 < ay2


if __name__ == "__main__":
    print(sample(), end="")
