"""Laboratories under decisions: what a `lab.toml` leaves open, and laboratories without hardware."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from khepera_forage.envs.arguments import set_up_of, timing_of
from khepera_forage.extras import require
from khepera_forage.lab.settings import LabSettings
from khepera_forage.lab.settings_file import load
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.named import named_arena
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

if TYPE_CHECKING:
    from khepera_forage.lab.virtual_cubes import VirtualCubeLaboratory


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
    return load(path, set_up_of(decisions), decisions.round_duration)


def virtual_laboratory(
    arena: Arena | str = CORRIDOR,
    robots: int = 2,
    decisions: Decisions = DEFAULT_DECISIONS,
    **options: Any,
) -> VirtualLaboratory:
    """A laboratory without hardware, with copies of one arena side by side.

    Args:
        arena: An arena, which is the first copy; or one of the names in `ARENAS`.
        robots: Number of robots, the teacher first; a single robot is a learner.
        decisions: Where start, food and home are in a named arena, how long a round lasts, how fast arm and jaw move,
            and the marker of a single robot.
        **options: Arguments of `VirtualLaboratory`, and `timeout`, that of the driver in seconds.
    """
    return VirtualLaboratory.from_arena(
        arena, robots, set_up_of(decisions), timing_of(decisions), decisions.recall_marker, **options
    )


def virtual_cubes(
    arena: Arena | str = CORRIDOR, robots: int = 2, decisions: Decisions = DEFAULT_DECISIONS
) -> "VirtualCubeLaboratory":
    """A laboratory of virtual toio cubes on a mat, with copies of one arena side by side.

    Args:
        arena: As for `virtual_laboratory`.
        robots: As for `virtual_laboratory`.
        decisions: As for `virtual_laboratory`.

    Raises:
        ValueError: The mat has no room for the arenas.
        ImportError: toio-py is missing.
    """
    require("a laboratory of toio cubes", "toio")
    from khepera_forage.lab.virtual_cubes import VirtualCubeLaboratory

    original = named_arena(arena, set_up_of(decisions)) if isinstance(arena, str) else arena
    return VirtualCubeLaboratory(original, robots, decisions.round_duration, decisions.recall_marker)
