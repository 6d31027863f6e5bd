"""The direction of dependencies between packages, names of daily use, and policies under the default decisions."""

import ast
from pathlib import Path

import pytest

import khepera_forage
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies import NearestNeighbourImitator, Teacher
from khepera_forage.task.decisions import Decisions

PACKAGE = Path(khepera_forage.__file__).parent
ABOVE_ROLLOUTS = ("study", "thesis", "comparison", "cli")
ABOVE_TASK = ("sim", "lab", "envs", "policies", "rollouts", *ABOVE_ROLLOUTS)
FORBIDDEN = {
    "geometry": ("robots", "vision", "task", "experience", *ABOVE_TASK),
    "robots": ("task", "experience", *ABOVE_TASK),
    "vision": ("task", "experience", *ABOVE_TASK),
    "task": ("vision.tracker", "vision.detection", "vision.rendering", "noise", *ABOVE_TASK),
    "sim": ("task", "lab", "envs", "policies", "rollouts", *ABOVE_ROLLOUTS),
    "lab": ("task", "envs", "policies", "rollouts", *ABOVE_ROLLOUTS),
    "policies": ("sim", "lab", "envs", "rollouts", *ABOVE_ROLLOUTS),
    "envs": ("rollouts", *ABOVE_ROLLOUTS),
    "rollouts": ABOVE_ROLLOUTS,
    "thesis": ("comparison", "cli"),
    "comparison": ("cli",),
}
"""What each package must not import."""


def imported(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("package", FORBIDDEN)
def test_package_imports_only_what_lies_below(package: str) -> None:
    files = list((PACKAGE / package).rglob("*.py"))
    assert files
    for path in files:
        for name in imported(path):
            for other in FORBIDDEN[package]:
                assert not name.startswith(f"khepera_forage.{other}."), f"{path.name} imports {name}"


ALLOWED_IN_TASK = {"math", "numbers", "enum", "typing", "collections", "dataclasses", "khepera_forage"}


def test_task_imports_only_the_language_and_the_package() -> None:
    for path in (PACKAGE / "task").glob("*.py"):
        foreign = {name.split(".")[0] for name in imported(path)}
        assert foreign <= ALLOWED_IN_TASK, path.name


def test_policies_have_the_default_decisions() -> None:
    decisions = Decisions()
    radius = round(decisions.home_radius / 5)
    assert Teacher.of(BehavioursEnv()) == Teacher(radius, decisions)
    assert NearestNeighbourImitator().arithmetic == decisions.distance_arithmetic


def test_names_of_daily_use_are_at_the_top_and_others_are_not() -> None:
    # A list of its own: a name that users import stays.
    names = "Arena Decisions Experience NearestNeighbourImitator Noise Teacher as_policy dagger read_arena recall"
    assert {*names.split(), "recall_env", "train", "__version__"} == set(khepera_forage.__all__)
    assert set(khepera_forage.__all__) <= set(dir(khepera_forage))
    assert all(getattr(khepera_forage, name) for name in khepera_forage.__all__)
    with pytest.raises(AttributeError, match="module 'khepera_forage' has no attribute 'Nothing'"):
        _ = khepera_forage.Nothing
