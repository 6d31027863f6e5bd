"""Laboratories under decisions: what a `lab.toml` leaves open, and laboratories without hardware."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from khepera_forage.envs.arguments import set_up_of, timing_of
from khepera_forage.extras import require
from khepera_forage.lab.settings_file import CameraSettings, LabSettings, RobotSettings, fits, parse, usual_marker
from khepera_forage.lab.virtual_laboratory import VirtualCubeLaboratory, VirtualLaboratory
from khepera_forage.robots.model import KHEPERA, model_of
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT
from khepera_forage.robots.toio.driver import VIRTUAL, ToioRobot
from khepera_forage.sim.arena import Arena, Point, copies
from khepera_forage.sim.arenas.named import named_arena
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.layout_checks import cable_anchor
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.toml_table import naming, text_of
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.tracker_settings import TrackerSettings

TAG_SIZE = 40.0
"""Side in mm, on the plan, of the tag on a robot without a gripper: within its outline, so that it hides no food."""


def load_settings(path: Path | str, decisions: Decisions = DEFAULT_DECISIONS) -> LabSettings:
    """Read a `lab.toml`.

    Args:
        path: The file.
        decisions: Where start, food and home are in an arena that the file only names, and how long a round lasts if
            the file does not say so.

    Raises:
        ValueError: The file is not TOML, or a key is missing, unknown, or has a value that is not allowed.
        OSError: The file cannot be read.
    """
    path = Path(path)
    with naming(path):
        return parse(text_of(path), set_up_of(decisions), decisions.round_duration, path.parent)


def virtual_laboratory(
    arena: Arena | str = CORRIDOR,
    robots: int = 2,
    decisions: Decisions = DEFAULT_DECISIONS,
    *,
    timeout: float = DEFAULT_TIMEOUT,
    robot: str = KHEPERA.name,
    **options: Any,
) -> VirtualLaboratory:
    """A laboratory without hardware, with copies of one arena side by side.

    Args:
        arena: An arena, which is the first copy; or one of the names in `ARENAS`. The copies of a named arena are
            centred in the picture, whose border would cut off markers that extend over a wall.
        robots: Number of robots, the teacher first; a single robot is a learner.
        decisions: Where start, food and home are in a named arena, how long a round lasts, how fast arm and jaw move,
            and the marker of a single robot.
        timeout: Of the driver, in seconds: how late the virtual robots of a busy machine may reply.
        robot: Kind of the robots: khepera or e-puck2.
        **options: Arguments of `VirtualLaboratory`.
    """
    original, timing = _arena(arena, decisions), timing_of(decisions)._asdict()
    placed = copies(original, robots)
    if isinstance(arena, str):
        x, y = cable_anchor(placed)
        dx, dy = PICTURE_WIDTH * MM_PER_PIXEL / 2 - x, PICTURE_HEIGHT * MM_PER_PIXEL / 2 - y
        placed = tuple(copy.shifted(dx, dy) for copy in placed)
    ports = ["virtual"] * robots
    markers = "holes" if model_of(robot).has_gripper else "tags"
    entries = _entries(original, placed, ports, decisions, markers, type=robot, timeout=timeout)
    camera, tracker = CameraSettings(source="rendered frames"), TrackerSettings()
    if markers == "tags":
        used = tuple(entry.holes for entry in entries)
        tracker = TrackerSettings(markers=markers, tag_size=TAG_SIZE, numbers=used)
    settings = LabSettings(original, entries, camera, timing.pop("round_duration"), tracker)
    return VirtualLaboratory(settings, **timing, **options)


def virtual_cubes(
    arena: Arena | str = CORRIDOR, robots: int = 2, decisions: Decisions = DEFAULT_DECISIONS
) -> VirtualCubeLaboratory:
    """A laboratory of virtual toio cubes on a mat, with copies of one arena; arguments as for `virtual_laboratory`.

    Raises:
        ValueError: The mat has no room for the arenas.
        ImportError: toio-py is missing.
    """
    require("a laboratory of toio cubes", "toio")
    original = _arena(arena, decisions)
    x1, y1, _, y2 = original.bounds
    placed = [original.shifted(_BORDER - x1, _BORDER - y1 + i * (y2 - y1 + _GAP)) for i in range(robots)]
    check_room(placed, *ToioRobot.mat_size)
    ports = [f"{VIRTUAL}robot {i}" for i in range(robots)]
    foods = tuple(f"{VIRTUAL}food {i}" for i in range(robots * len(original.foods)))
    entries = _entries(original, placed, ports, decisions, "holes", type=ToioRobot.model.name)
    period = decisions.round_duration
    return VirtualCubeLaboratory(LabSettings(original, entries, CameraSettings(), period, food_cubes=foods))


def check_room(arenas: Sequence[Arena], width: float, height: float) -> None:
    """Complain about arenas that do not fit a mat."""
    if not all(fits(arena, width, height) for arena in arenas):
        count = f"{len(arenas)} x {arenas[0].name}"
        raise ValueError(f"arenas are {count}; allowed: what fits a mat of {width:.0f} x {height:.0f} mm")


_BORDER, _GAP = 20.0, 6.0
"""mm from the border of the mat to the first arena, and from one arena to the next."""


def _arena(arena: Arena | str, decisions: Decisions) -> Arena:
    return named_arena(arena, set_up_of(decisions)) if isinstance(arena, str) else arena


def _entries(
    original: Arena, placed: Sequence[Arena], ports: Sequence[str], decisions: Decisions, markers: str, **options: Any
) -> tuple[RobotSettings, ...]:
    """A robot for each copy of an arena, the teacher first; a single robot is a learner."""
    alone = len(placed) == 1
    return tuple(
        RobotSettings(
            port=port,
            name="teacher" if i == 0 and not alone else f"learner_{max(0, i - 1)}",
            holes=decisions.recall_marker if alone else usual_marker(i, markers),
            offset=Point(copy.home.x - original.home.x, copy.home.y - original.home.y),
            **options,
        )
        for i, (copy, port) in enumerate(zip(placed, ports, strict=True))
    )
