"""The page on plugging in a learner runs as it stands there, from the first block to the last."""

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from khepera_forage.policies.learners import LEARNERS

DOCS = Path(__file__).parent.parent / "docs"
PAGE = (DOCS / "plug_in_a_learner.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
EXTRAS = {"baselines": "stable_baselines3", "minari": "minari"}


def test_every_block_runs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    monkeypatch.setattr("khepera_forage.policies.learners.LEARNERS", dict(LEARNERS))
    names: dict[str, Any] = {}
    for block in BLOCKS:
        extra = re.match(r"# needs the extra: (\w+)", block)
        if extra is None or (extra[1] == "minari" and find_spec("minari")):  # baselines: see tests/baselines
            exec(compile(block, "plug_in_a_learner.md", "exec"), names)
    printed = capsys.readouterr().out
    assert len(names["rows"]) == 3
    scores = [float(score) for score in re.findall(r"score +(-?[\d.]+) %", printed)]
    assert len(scores) == 7
    assert scores[0] > 0, "the forest forages better than nothing"
    assert "random forest" in printed
    assert names["out"].rounds[0].agreed == 100


def test_blocks_for_extras_are_marked() -> None:
    found = re.findall(r"# needs the extra: (\w+)", PAGE)
    assert sorted(found) == sorted(EXTRAS)
    for extra in found:
        assert f"khepera-forage[{extra}]" in PAGE


def test_every_learner_of_the_registry_is_on_the_page() -> None:
    table = PAGE[PAGE.index("## What comes with the package") :]
    listed = {
        name
        for cell in re.findall(r"^\| (`.*?) \|", table, flags=re.MULTILINE)
        for name in re.findall(r"`(\w+)`", cell)
    }
    assert listed == set(LEARNERS)


@pytest.mark.parametrize("path", re.findall(r"\]\(([^)#]+)\)", PAGE))
def test_links_lead_somewhere(path: str) -> None:
    assert path.startswith("http") or (DOCS / path).exists(), path
