"""The environment of a Minari dataset: where a learner can forage in the arena of the experience."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import gymnasium as gym

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.arena_settings import environment_name, settings_of
from khepera_forage.experience import ExperienceError
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.named import ARENAS
from khepera_forage.sim.arenas.procedural import LEVELS, SPLITS, level_of
from khepera_forage.task.decisions import Decisions


def dataset_environment(
    names: Iterable[str], arena: Arena | str | None, decisions: Decisions | None, wheels: bool = False
) -> gym.Env[Any, Any]:
    """The environment of behaviours, or of motors, in the arena of some experience.

    Args:
        names: Of the arenas in the experience.
        arena: The arena of all of it. It may be left out if the names say what it is: one of `ARENAS`, or procedural
            levels of one difficulty and split.
        decisions: Of the environment; those of its version by default.
        wheels: Whether actions are motors.

    Raises:
        ExperienceError: The names are of several arenas, of an unknown one, or of another one than `arena`.
    """
    found = sorted(set(names))
    kind = "Wheels-v1" if wheels else "-v1"
    if arena is not None and found != [arena.name if isinstance(arena, Arena) else arena]:
        own = arena.name if isinstance(arena, Arena) else arena
        raise ExperienceError(f"experience of {found}; allowed: of {own!r}, the argument arena")
    if isinstance(arena, Arena):
        return gym.make(f"khepera_forage/Corridor{kind}", decisions=decisions, **settings_of(arena))
    if len(found) == 1 and found[0] in ARENAS:
        return gym.make(f"khepera_forage/{environment_name(found[0])}{kind}", decisions=decisions)
    levels = _levels(found)
    if levels is None:
        raise ExperienceError(
            f"experience of {found}; allowed: one arena, of {', '.join(ARENAS)}, or one of your own with the argument "
            "arena; or procedural levels of one difficulty and split"
        )
    return gym.make(f"khepera_forage/Procedural{kind}", decisions=decisions, **levels)


def arena_name(arena: Any) -> Any:
    """The name of an arena in a spec: of an `Arena`, of its fields as JSON stores them, or the name itself."""
    if isinstance(arena, Mapping):
        return arena.get("name")
    return arena.name if isinstance(arena, Arena) else arena


def _levels(names: Sequence[str]) -> dict[str, Any] | None:
    """The arguments of `Procedural-v1` in which all named levels are; None if there are none."""
    parsed = [level_of(name) for name in names]
    levels = [level for level in parsed if level is not None]
    kinds = {(difficulty, level // LEVELS) for difficulty, level in levels}
    splits = {first // LEVELS: split for split, first in SPLITS.items()}
    if len(levels) < len(names) or len(kinds) != 1:
        return None
    ((difficulty, part),) = kinds
    if part not in splits:
        return None
    first, last = min(level for _, level in levels), max(level for _, level in levels)
    return {
        "difficulty": difficulty,
        "split": splits[part],
        "num_levels": last - first + 1,
        "start_level": first % LEVELS,
    }
