"""The programs with stable-baselines3 in README and documentation run, and learn what they say."""

import re
from pathlib import Path
from typing import Any

import pytest

from khepera_forage.policies.learners import LEARNERS
from khepera_forage.rollouts.recall import recall, recall_env

ROOT = Path(__file__).parents[2]


def run(page: str, names: dict[str, Any], marked: str = "# needs the extra: baselines\n") -> None:
    """Run the blocks of a page that begin with a mark, one after the other."""
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = re.findall(rf"```python\n({marked}.*?)```", text, flags=re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, page, "exec"), names)


def test_trained_model_of_readme_delivers_the_food(capsys: pytest.CaptureFixture[str]) -> None:
    run("README.md", {})
    food = re.fullmatch(r"food (\d+) of 10\n", capsys.readouterr().out)
    assert food is not None
    assert int(food[1]) >= 9


def test_blocks_of_reinforcement_learning_page_train_and_recall(capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    run("docs/reinforcement_learning.md", names, marked="")
    assert names["model"].num_timesteps == 4096
    assert re.search(r"^score -?\d+\.\d %, food [01]$", capsys.readouterr().out, flags=re.MULTILINE)


def test_code_on_the_page_about_learners_runs(capsys: pytest.CaptureFixture[str]) -> None:
    run(
        "docs/plug_in_a_learner.md",
        {"LEARNERS": LEARNERS, "recall": recall, "corridor": recall_env("corridor", limit=50)},
    )
    assert re.findall(r"after (\d+) steps", capsys.readouterr().out) == ["2560", "5120"]
