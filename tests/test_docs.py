"""The examples of the documentation run, its tables are up to date, and its links lead to files."""

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from khepera_forage.policies.learners import LEARNERS
from khepera_forage.task.decision_table import decision_table, markdown_table

DOCS = Path(__file__).parent.parent / "docs"
PAGES = {path.name: path.read_text(encoding="utf-8") for path in sorted(DOCS.glob("*.md"))}
LEARNER_PAGE = PAGES["plug_in_a_learner.md"]
GENERATED = {"agreement.md", "kheperax.md"}
EXTRAS = {"baselines": "stable_baselines3", "minari": "minari"}
LINKS = [
    (name, link)
    for name, text in PAGES.items()
    for link in re.findall(r"\]\(([^)]+)\)", text)
    if not link.startswith("http")
]


def run_blocks(name: str) -> dict[str, Any]:
    """Run all Python blocks of a page in one namespace, without those for extras that are not installed."""
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", PAGES[name], flags=re.DOTALL):
        extra = re.match(r"# needs the extra: (\w+)", block)
        if extra is None or (extra[1] == "minari" and find_spec("minari")):  # baselines: see tests/baselines
            exec(compile(block, name, "exec"), names)
    return names


def test_blocks_of_learner_page_run(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    monkeypatch.setattr("khepera_forage.policies.learners.LEARNERS", dict(LEARNERS))
    names = run_blocks("plug_in_a_learner.md")
    printed = capsys.readouterr().out
    assert len(names["rows"]) == 3
    scores = [float(score) for score in re.findall(r"score +(-?[\d.]+) %", printed)]
    assert len(scores) == 7
    assert scores[0] > 0, "the forest forages better than nothing"
    assert "random forest" in printed
    assert names["out"].rounds[0].agreed == 100


def test_blocks_of_decisions_page_run(capsys: pytest.CaptureFixture[str]) -> None:
    names = run_blocks("decisions.md")
    assert names["env"].unwrapped.decisions == names["training"].unwrapped.decisions == names["decisions"]
    changed, parsed = capsys.readouterr().out.splitlines()
    assert f"print(decisions.changed())  # {changed}\n" in PAGES["decisions.md"]
    assert "next_to_food=22.0" in parsed


def test_blocks_of_compiled_page_run() -> None:
    names = run_blocks("compiled.md")
    assert names["rewards"].shape == (1024,)
    assert names["episodes"].delivered.sum() > 990
    assert names["recalls"].score.shape == (1000,)


def test_blocks_for_extras_name_their_extra() -> None:
    found = re.findall(r"# needs the extra: (\w+)", LEARNER_PAGE)
    assert sorted(found) == sorted(EXTRAS)
    for extra in found:
        assert f"khepera-forage[{extra}]" in LEARNER_PAGE


def test_learner_page_lists_all_learners() -> None:
    table = LEARNER_PAGE[LEARNER_PAGE.index("## What comes with the package") :]
    listed = {
        name
        for cell in re.findall(r"^\| (`.*?) \|", table, flags=re.MULTILINE)
        for name in re.findall(r"`(\w+)`", cell)
    }
    assert listed == set(LEARNERS)


def test_decisions_page_has_the_current_table() -> None:
    assert PAGES["decisions.md"].endswith(f"\n\n{markdown_table()}"), (
        "replace the table by what python -m khepera_forage.task.decision_table prints"
    )


def test_decision_table_has_no_empty_cell() -> None:
    rows = decision_table()
    assert len({row.name for row in rows}) == len(rows)
    for row in rows:
        assert all(row), row.name
        assert "|" not in "".join(row), row.name


@pytest.mark.parametrize(("page", "link"), LINKS)
def test_link_leads_to_a_file_and_heading(page: str, link: str) -> None:
    path, _, heading = link.partition("#")
    target = (DOCS / path).resolve() if path else DOCS / page
    assert target.exists(), link
    if heading:
        titles = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), flags=re.MULTILINE)
        assert heading in {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}, link


@pytest.mark.parametrize("page", sorted(PAGES.keys() - GENERATED))
def test_page_begins_with_what_its_reader_can_do(page: str) -> None:
    assert "\n\nAfter reading this page you can " in PAGES[page][:200], page
