"""The README is short, its example runs, and what it links to exists."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


def test_readme_is_short() -> None:
    assert len(README.splitlines()) <= 150


def test_example_of_readme_delivers_the_food(capsys: pytest.CaptureFixture[str]) -> None:
    example = BLOCKS[0]
    assert len(example.splitlines()) <= 10
    exec(compile(example, "README.md", "exec"), {})
    assert re.fullmatch(r"score \d+\.\d % in \d+ steps, food 1 of 1\n", capsys.readouterr().out)


def test_readme_begins_with_picture_installation_use_and_two_commands() -> None:
    parts = ("![", "pip install 'khepera-forage[all]'", "```python", "make reproduce", "## Results")
    places = [README.index(part) for part in parts]
    assert places == sorted(places)


def test_results_of_readme_are_those_of_the_reproduction_page() -> None:
    page = (ROOT / "docs" / "reproduction.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (?:corridor|rectangle) \| \d+ \|.*$", README, flags=re.MULTILINE)
    assert len(rows) == 7
    for row in rows:
        arena, episodes, *measured = row.strip("| ").split(" | ")
        assert re.search(rf"^\| {arena} \| {episodes} \| .*$", page, flags=re.MULTILINE)
        assert all(f"| {value} |" in page for value in measured), row


@pytest.mark.parametrize("path", re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", README))
def test_link_of_readme_exists(path: str) -> None:
    if not path.startswith("http"):
        assert (ROOT / path).exists(), path


def test_readme_links_to_every_section_of_the_site() -> None:
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    pages = set(re.findall(r"^(\w+)$", index, flags=re.MULTILINE))
    only_on_the_site = {"api", "changelog", "contributing"}
    assert pages - only_on_the_site <= set(re.findall(r"\]\(docs/(\w+)\.md\)", README))
