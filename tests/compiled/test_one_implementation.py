"""Every rule of the task has one implementation: kernels call the functions that Python calls."""

import ast
import inspect
import pkgutil
from collections.abc import Callable
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

import khepera_forage
from khepera_forage import task
from khepera_forage.envs.compiled.rules import RULE_MODULES
from khepera_forage.policies import nearest_neighbour
from khepera_forage.policies.nearest_neighbour import distance, votes
from khepera_forage.task.decisions import Decisions
from khepera_forage.vision import association

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
DECISIONS = {field.name for field in fields(Decisions)} - READ_BY_PYTHON


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
    ("module", "rules"),
    [
        ("envs.compiled.commands", {"applicable", "command", "decode_motors"}),
        (
            "envs.compiled.perception",
            {"update_food", "explored", "raw_data", "state_vector", "classify", "to_wall"},
        ),
        (
            "envs.compiled.rounds",
            {"draw_layout", "draw_food_types", "layout_key", "food_type_key"}
            | {"begin_episode", "begin_step", "end_step"},
        ),
        ("sim.compiled.tracking", {"match", "may_vanish", "start_tracks"}),
        ("rollouts.compiled.policy_kernel", {"count_decision"}),
        ("rollouts.compiled.nearest_neighbour", {"nearest_votes", "draw_label", "scaled_distance"}),
        ("rollouts.compiled.rollout_kernel", {"is_collected"}),
        (
            "rollouts.compiled.training_kernel",
            {
                "update_pairing",
                "lead",
                "teacher_says",
                "attempt_ends",
                "has_done_its_part",
                "share_identified",
            }
            | {"place_by_hand", "draw_food_types", "command", "applicable"},
        ),
    ],
)
def test_kernels_call_the_rules_that_they_need(module: str, rules: set[str]) -> None:
    tree = ast.parse((PACKAGE / (module.replace(".", "/") + ".py")).read_text(encoding="utf-8"))
    assert rules <= {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
