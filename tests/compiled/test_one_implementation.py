"""Every rule of the task has one implementation: kernels call the functions that Python calls."""

import ast
import inspect
import pkgutil
from collections.abc import Callable
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import khepera_forage
from khepera_forage import task
from khepera_forage.envs.compiled.records import (
    arena_dtype,
    decisions_dtype,
    episode_dtype,
    food_object_dtype,
    link_dtype,
    nearest_wall_dtype,
    place_dtype,
    start_dtype,
    straight_way_dtype,
    tracker_dtype,
    wall_dtype,
    way_corner_dtype,
)
from khepera_forage.envs.compiled.rules import RULE_MODULES
from khepera_forage.geometry.known_ways import StraightWay
from khepera_forage.geometry.nearest_wall import NearestWall
from khepera_forage.geometry.paths import Corner, Spot
from khepera_forage.geometry.walls import Wall
from khepera_forage.policies import nearest_neighbour
from khepera_forage.policies.nearest_neighbour import distance, votes
from khepera_forage.rollouts.compiled.records import decision_dtype, pair_dtype
from khepera_forage.sim.compiled import records as bodies
from khepera_forage.sim.compiled.listed_walls import ListedWall
from khepera_forage.sim.compiled.records import detection_dtype, track_dtype
from khepera_forage.task.arena_map import ArenaMap, Floor
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.episode import DecisionCounts, Episode
from khepera_forage.task.food_links import Link
from khepera_forage.task.food_tracking import FoodObject, FoodTracker
from khepera_forage.task.pairing import Pairing
from khepera_forage.task.placement import Place, Start
from khepera_forage.vision import association
from khepera_forage.vision.association import Detection, Track

PACKAGE = Path(khepera_forage.__file__).parent
COMPILED = sorted(
    path
    for folder in ("envs", "rollouts", "sim")
    for path in (PACKAGE / folder / "compiled").glob("*.py")
    if path.stem != "__init__"
)
COMPILING = {"entrance", "kernel", "inline", "sequence"}
"""Decorators of compiled functions."""


def _functions(module: ModuleType) -> dict[str, Callable[..., object]]:
    return {
        name: function
        for name, function in vars(module).items()
        if inspect.isfunction(function) and function.__module__ == module.__name__
    }


RULES = {
    name: function
    for module in (*RULE_MODULES, association, distance, votes)
    for name, function in _functions(module).items()
}
READ_BY_PYTHON = {"home_radius", "round_duration", "recall_marker", "patience", "most_attempts"}
"""Decisions that become part of an arena, of timing or of an operator's terms before a kernel runs."""
HANDED_ON = {"distance_arithmetic"}
"""A parameter of the imitator."""
DECISIONS = {field.name for field in fields(Decisions)} - READ_BY_PYTHON - HANDED_ON


def _module_name(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)


def second_implementations(source: str) -> list[str]:
    """Functions with the name of a public rule, and compiled functions with the name of any rule."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef) and node.name in RULES:
            decorators = {ast.unparse(decorator) for decorator in node.decorator_list}
            if not node.name.startswith("_") or decorators & COMPILING:
                found.append(node.name)
    return found


def unused_rules(source: str) -> list[str]:
    """Rules that a module imports and does not use."""
    tree = ast.parse(source)
    imported = {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.name in RULES
    }
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return sorted(imported - used)


def decisions_read(source: str) -> list[str]:
    """Decisions that a module reads itself, as `something.next_to_food`."""
    return [
        node.attr
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Attribute) and node.attr in DECISIONS
    ]


SECOND_RULE = """
from khepera_forage.task.food_tracking import is_finished
from khepera_forage.task.states import classify

@kernel
def _count(tracker, foods):
    pass

@kernel
def state_of(task, decisions):
    return 2 if task.robot_food_distance[0] <= decisions.next_to_food else 0

def is_raised(arm, decisions):
    return classify(arm)
"""


def test_checks_find_second_implementations() -> None:
    assert second_implementations(SECOND_RULE) == ["_count", "is_raised"]
    assert unused_rules(SECOND_RULE) == ["is_finished"]
    assert decisions_read(SECOND_RULE) == ["next_to_food"]


def test_every_module_of_the_task_with_rules_is_enumerated() -> None:
    """The other modules of `task` make and check `Decisions` before an environment exists."""
    names = [f"{task.__name__}.{module.name}" for module in pkgutil.iter_modules(task.__path__)]
    modules = {name for name in names if "decision" not in name and _functions(import_module(name))}
    assert modules <= {module.__name__ for module in RULE_MODULES}
    others = {
        f"{nearest_neighbour.__name__}.{m.name}" for m in pkgutil.iter_modules(nearest_neighbour.__path__)
    }
    assert {distance.__name__, votes.__name__} <= others
    assert len(RULES) > 80
    assert len(COMPILED) > 30


@pytest.mark.parametrize(
    "path", COMPILED, ids=lambda path: _module_name(path).removeprefix("khepera_forage.")
)
def test_compiled_module_has_no_rule_of_its_own(path: Path) -> None:
    source = path.read_text(encoding="utf-8")
    assert second_implementations(source) == []
    assert unused_rules(source) == []
    assert decisions_read(source) == []


@pytest.mark.parametrize(
    "path", COMPILED, ids=lambda path: _module_name(path).removeprefix("khepera_forage.")
)
def test_rules_in_a_compiled_module_are_the_functions_that_python_calls(path: Path) -> None:
    """The very function objects, neither wrapped nor copied."""
    module = import_module(_module_name(path))
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                if alias.name in RULES and node.module == RULES[alias.name].__module__:
                    assert getattr(module, alias.asname or alias.name) is RULES[alias.name], alias.name


@pytest.mark.parametrize(
    ("package", "needed"),
    [
        ("sim", "match may_vanish start_tracks"),
        ("envs", "applicable command decode_motors explored update_food raw_data state_vector classify"),
        ("envs", "draw_layout draw_food_types layout_key food_type_key begin_episode end_step"),
        ("envs", "score penalty"),
        ("rollouts", "nearest_votes draw_label scaled_distance count_decision is_collected share_identified"),
        ("rollouts", "score penalty"),
        ("rollouts", "update_pairing lead teacher_says attempt_ends has_done_its_part place_by_hand"),
    ],
)
def test_compiled_modules_call_the_rules_that_they_need(package: str, needed: str) -> None:
    used = {
        node.id
        for path in COMPILED
        if path.parent.parent.name == package
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Name)
    }
    assert set(needed.split()) <= used


@pytest.mark.parametrize(
    ("record", "thing"),
    [
        (tracker_dtype, FoodTracker),
        (food_object_dtype, FoodObject),
        (link_dtype, Link),
        (straight_way_dtype, StraightWay),
        (nearest_wall_dtype, NearestWall),
        (track_dtype, Track),
        (episode_dtype, Episode),
        (decision_dtype, DecisionCounts),
        (pair_dtype, Pairing),
        (start_dtype, Start),
        (place_dtype, Place),
        (decisions_dtype, Decisions),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_records_have_the_fields_of_the_dataclasses(record: Any, thing: Any) -> None:
    """Lists of records are arrays of their own."""
    assert {field.name for field in fields(thing)} - {"foods", "nearest_wall", "known_ways", "links"} <= set(
        record.names
    )


def test_records_of_walls_arenas_and_detections_have_the_fields_of_the_tuples() -> None:
    assert set(Wall._fields) == set(wall_dtype.names or ())
    assert ListedWall._fields == bodies.wall_dtype.names
    assert set(Corner._fields) == set(way_corner_dtype.names or ())
    assert set(Spot._fields) == set(place_dtype.names or ())
    for prefix, known in (("map", ArenaMap), ("floor", Floor)):
        names = {f"{prefix}_{name}" for name in known._fields if name not in ("walls", "ways")}
        assert names <= set(arena_dtype.names or ())
    assert set(detection_dtype.names or ()) <= set(Detection._fields)
