"""The examples of the README run, and what it lists exists."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import khepera_forage

README = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


def run(block: str) -> dict[str, Any]:
    names: dict[str, Any] = {}
    exec(compile(block, "README.md", "exec"), names)
    return names


def test_readme_has_four_short_examples() -> None:
    assert len(BLOCKS) == 4
    assert all(len(block.splitlines()) <= 18 for block in BLOCKS)


def test_gymnasium_example_delivers_the_food(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(BLOCKS[0])["terminated"]
    assert "food 1" in capsys.readouterr().out


def test_pettingzoo_example_makes_an_imitator() -> None:
    imitator = run(BLOCKS[1])["imitator"]
    assert 0 <= imitator.act((0, 60, 0, 215, 40), np.random.default_rng(0)) <= 9


def test_decisions_example_changes_environment_and_teacher(capsys: pytest.CaptureFixture[str]) -> None:
    names = run(BLOCKS[2])
    changed = {"next_to_food": 22.0, "search_speed": 10.0}
    assert names["env"].unwrapped.decisions.changed() == changed == names["teacher"].decisions.changed()
    assert capsys.readouterr().out == f"{changed}\n"


def test_compiled_example_steps_all_worlds() -> None:
    names = run(BLOCKS[3])
    assert names["rewards"].shape == (256,)
    assert names["env"].unwrapped.backend == "compiled"


@pytest.mark.parametrize("path", re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", README))
def test_link_of_readme_exists(path: str) -> None:
    if not path.startswith("http"):
        assert (Path(__file__).parent.parent / path).exists(), path


def test_folders_of_the_package_are_in_the_readme() -> None:
    package = Path(khepera_forage.__file__).parent
    folders = {path.parent.name for path in package.glob("*/__init__.py")}
    assert folders == set(re.findall(r"^\| \[`\w+`\]\(khepera_forage/(\w+)\)", README, flags=re.MULTILINE))


def test_benchmarks_are_in_the_readme() -> None:
    row = re.search(r"^\| \[`benchmarks`\].*$", README, flags=re.MULTILINE)
    assert row is not None
    scripts = {path.name for path in (Path(__file__).parent.parent / "benchmarks").glob("*.py")}
    assert set(re.findall(r"`(\w+\.py)`", row[0])) == scripts - {"arguments.py"}
