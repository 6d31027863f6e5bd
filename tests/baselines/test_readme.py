"""The README's program with stable-baselines3 learns to forage."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_trained_model_of_readme_delivers_the_food(capsys: pytest.CaptureFixture[str]) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n# needs the extra: baselines\n(.*?)```", readme, flags=re.DOTALL)
    exec(compile(block, "README.md", "exec"), {})
    food = re.fullmatch(r"food (\d+) of 10\n", capsys.readouterr().out)
    assert food is not None
    assert int(food[1]) >= 9
