"""Dataclasses of the rules as numpy records, and their comparison."""

import math
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np

from khepera_forage.envs.arguments import food_odds
from khepera_forage.envs.compiled import rules  # noqa: F401 (registers the rules)
from khepera_forage.envs.compiled.parameters import (
    TaskParameters,
    task_parameters,
)
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled import tracking  # noqa: F401 (registers the rules of association)
from khepera_forage.task.decisions import Decisions

DECISIONS = (
    Decisions(),
    Decisions(next_to_food=17, close_to_food=36, equal_distance="farther state", separation=8, same_place=1),
    Decisions(
        food_beside_robot="unseen until the arm is down",
        redetection_time=0.3,
        no_food_distance="last one known",
        held_food="no candidate",
        search_without_food="wander",
        beside_food="drive on",
        orienting="lowered over food",
        arm_after_orienting="as it is",
        rounds_after_training=5,
        distance_arithmetic="32-bit floats",
    ),
    Decisions(
        food_beside_robot="unseen",
        held_food="candidate in the gripper",
        beside_food="turn away",
        distance_arithmetic="64-bit floats",
    ),
    Decisions(held_food="hides all food"),
)
"""The defaults, other numbers, and each reading that is not the default at least once."""
IDS = ("default", "numbers", "readings", "more readings", "hidden")


def task_of(arena: Arena, decisions: Decisions = DECISIONS[0]) -> TaskParameters:
    """Parameters of kernels; all food is pickable."""
    return task_parameters(arena, 500, food_odds(None), decisions)


def records(dtype: np.dtype[Any], things: Any) -> Any:
    """Dataclasses as an array of records: the fields that both have."""
    array = np.zeros(len(things), dtype)
    for record, thing in zip(array, things, strict=True):
        kind: Any = type(thing)
        for name in _common(dtype, kind):
            record[name] = getattr(thing, name)
    return array


def check_same(array: Any, things: Any) -> None:
    """Records and dataclasses with the same values, to rounding."""
    for record, thing in zip(array, things, strict=True):
        kind: Any = type(thing)
        for name in _common(array.dtype, kind):
            expected, found = getattr(thing, name), record[name]
            # Tests compare a million of these: `pytest.approx` and `np.array_equal` would take most of their time.
            if isinstance(expected, float):
                share = 1e-6 if array.dtype[name] == np.float32 else 0.0
                assert math.isclose(found, expected, rel_tol=share, abs_tol=1e-9), name
            elif isinstance(expected, int):
                assert found == expected, name
            else:
                assert np.array_equal(found, expected), name


@cache
def _common(dtype: np.dtype[Any], kind: Any) -> tuple[str, ...]:
    """The fields that records and a kind of dataclass, or of named tuple, both have."""
    names = [field.name for field in fields(kind)] if is_dataclass(kind) else kind._fields
    return tuple(name for name in names if name in (dtype.names or ()))
