"""What the README shows runs as it stands there."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

README = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


def run(block: str) -> dict[str, Any]:
    names: dict[str, Any] = {}
    exec(compile(block, "README.md", "exec"), names)
    return names


def test_there_is_a_loop_for_each_phase() -> None:
    assert len(BLOCKS) == 3
    assert all(len(block.splitlines()) <= 18 for block in BLOCKS)


def test_the_gymnasium_loop(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(BLOCKS[0])["terminated"]
    assert "food 1" in capsys.readouterr().out


def test_the_pettingzoo_loop_makes_an_imitator() -> None:
    imitator = run(BLOCKS[1])["imitator"]
    assert 0 <= imitator.act((0, 60, 0, 215, 40), np.random.default_rng(0)) <= 9


def test_thousands_of_worlds() -> None:
    assert run(BLOCKS[2])["rewards"].shape == (256,)


@pytest.mark.parametrize("path", re.findall(r"\]\(([^)#]+)\)", README))
def test_links_lead_somewhere(path: str) -> None:
    if not path.startswith("http"):
        assert (Path(__file__).parent.parent / path).exists(), path
