"""The page about reinforcement learning runs from its first block to its last, stable-baselines3 included."""

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "reinforcement_learning.md"


def test_blocks_of_reinforcement_learning_page_train_and_recall(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL):
        exec(compile(block, PAGE.name, "exec"), names)
    assert names["model"].num_timesteps == 4096
    assert re.search(r"^score -?\d+\.\d %, food [01]$", capsys.readouterr().out, flags=re.MULTILINE)
