"""The arrows of the house: what foraging and policies may know."""

import ast
from pathlib import Path

import pytest

import khepera_forage

PACKAGE = Path(khepera_forage.__file__).parent
FORBIDDEN = {
    "foraging": ("worlds", "envs", "policies", "experiments", "vision.tracker", "vision.overhead", "noise"),
    "policies": ("worlds", "envs", "experiments"),
    "robots": ("worlds", "foraging", "envs", "policies", "experiments"),
    "vision": ("worlds", "foraging", "envs", "policies", "experiments"),
    "worlds": ("foraging", "envs", "policies", "experiments"),
    "envs": ("experiments",),
}


def imported(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("room", FORBIDDEN)
def test_arrows_point_one_way(room: str) -> None:
    files = list((PACKAGE / room).rglob("*.py"))
    assert files
    for path in files:
        for name in imported(path):
            for other in FORBIDDEN[room]:
                assert not name.startswith(f"khepera_forage.{other}"), f"{path.name} imports {name}"


def test_foraging_is_plain_arithmetic() -> None:
    for path in (PACKAGE / "foraging").glob("*.py"):
        foreign = {name.split(".")[0] for name in imported(path)}
        assert foreign <= {"math", "enum", "typing", "collections", "khepera_forage"}, path.name
