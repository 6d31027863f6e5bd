"""The direction of dependencies between packages."""

import ast
from pathlib import Path

import pytest

import khepera_forage

PACKAGE = Path(khepera_forage.__file__).parent
ABOVE_TASK = ("sim", "lab", "envs", "policies", "rollouts", "thesis", "cli")
FORBIDDEN = {
    "geometry": ("robots", "vision", "task", "experience", *ABOVE_TASK),
    "robots": ("task", "experience", *ABOVE_TASK),
    "vision": ("task", "experience", *ABOVE_TASK),
    "task": (
        "vision.tracker",
        "vision.simulated_camera",
        "vision.detection",
        "vision.rendering",
        "noise",
        *ABOVE_TASK,
    ),
    "sim": ("task", "lab", "envs", "policies", "rollouts", "thesis", "cli"),
    "lab": ("task", "envs", "policies", "rollouts", "thesis", "cli"),
    "policies": ("sim", "lab", "envs", "rollouts", "thesis", "cli"),
    "envs": ("rollouts", "thesis", "cli"),
    "rollouts": ("thesis", "cli"),
    "thesis": ("cli",),
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
