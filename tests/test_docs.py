"""The examples of documentation and README run, their tables are up to date, and their links lead to files."""

import argparse
import re
import runpy
import shlex
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage
from khepera_forage.cli.main import main
from khepera_forage.noise import SOURCES, Noise
from khepera_forage.option_values import OneLineParser
from khepera_forage.policies.distance import CORRIDOR_DIAGONAL
from khepera_forage.policies.learners import LEARNERS
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY
from khepera_forage.vision.scene import MM_PER_PIXEL

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = {path.relative_to(DOCS).as_posix(): path.read_text(encoding="utf-8") for path in sorted(DOCS.rglob("*.md"))}
LEARNER_PAGE = PAGES["plug_in_a_learner.md"]
INDEX = "index.md"
INCLUDED = {"contributing.md", "changelog.md"}
"""Pages that consist of a file of the repository's own folder."""


Show = Callable[..., tuple[dict[str, Any], str]]


@pytest.fixture
def show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Show:
    """Run Python blocks of a page, all but those for missing extras, or some by number; names, and what is printed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    monkeypatch.setattr("khepera_forage.policies.learners.LEARNERS", dict(LEARNERS))

    def show(page: str, *numbers: int) -> tuple[dict[str, Any], str]:
        names: dict[str, Any] = {}
        blocks = re.findall(r"```python\n(.*?)```", PAGES[page], flags=re.DOTALL)
        for block in [blocks[number] for number in numbers] or blocks:
            extra = re.match(r"# needs the extra: (\w+)", block)
            # baselines: see tests/baselines
            if extra is None or extra[1] == "minari":
                exec(compile(block, page, "exec"), names)
        return names, capsys.readouterr().out

    return show


def test_blocks_of_learner_page_run(show: Show) -> None:
    names, printed = show("plug_in_a_learner.md")
    assert len(names["rows"]) == 3
    scores = [float(score) for score in re.findall(r"score +(-?[\d.]+) %", printed)]
    assert len(scores) == 7
    assert scores[0] > 0, "the forest forages better than nothing"
    assert "random forest" in printed
    assert names["out"].rounds[0].agreed == 100


def test_blocks_of_decisions_page_run(show: Show) -> None:
    names, printed = show("decisions.md")
    assert names["env"].unwrapped.decisions == names["training"].unwrapped.decisions == names["decisions"]
    changed, parsed = printed.splitlines()
    assert f"print(decisions.changed())  # {changed}\n" in PAGES["decisions.md"]
    assert "next_to_food=22.0" in parsed


def test_getting_started_page_shows_what_its_reader_will_see(show: Show, capsys: pytest.CaptureFixture[str]) -> None:
    shell = "\n".join(re.findall(r"```sh\n(.*?)```", PAGES["getting_started.md"], flags=re.DOTALL))
    lines = [line for line in shell.splitlines() if re.match("khepera-forage (train|recall) ", line)]
    assert len(lines) == 4
    for line in lines:
        command, _, promised = line.partition(" # ")
        assert main(shlex.split(command)[1:]) == 0
        food = re.match(r"(\d+) of 10", promised)
        assert food is None or f"food {food[1]} / 10" in capsys.readouterr().out
    names, printed = show("getting_started.md")
    assert names["vectors"].shape == (len(names["behaviours"]), 5)
    assert re.fullmatch(r"score \d+ %, food 10 of 10\n", printed), "as the commands"


def test_examples_of_environments_page_run_alone(show: Show) -> None:
    (forage, food), (paired, _), (compiled, _) = (show("environments.md", i) for i in range(3))
    assert forage["terminated"]
    assert "food 1" in food
    assert 0 <= paired["imitator"].act((0, 60, 0, 215, 40), np.random.default_rng(0)) <= 9
    assert compiled["rewards"].shape == (256,)
    assert compiled["env"].unwrapped.backend == "compiled"


def test_blocks_of_arenas_page_run(show: Show) -> None:
    names, _ = show("arenas.md")
    assert names["arena"] == names["procedural_arena"](5, "hard")
    (toml,) = re.findall(r"```toml\n(.*?)```", PAGES["arenas.md"], flags=re.DOTALL)
    Path("den.toml").write_text(toml, encoding="utf-8")
    assert names["read_arena"]("den.toml") == names["den"]
    names["env"].reset(seed=1)
    names["training"].reset(seed=1)


def test_example_of_wheels_page_films_a_forage(show: Show) -> None:
    names, _ = show("environments/wheels.md", 0)
    assert (names["terminated"], names["info"]["delivered"]) == (True, 1)
    assert names["info"]["score"] == 100, "every step is what the teacher would do"
    assert Path("wheels.gif").stat().st_size > 10_000


def test_blocks_of_other_pages_run(show: Show) -> None:
    compiled, _ = show("compiled.md")
    assert compiled["rewards"]["learner_0"].shape == (256,)
    assert compiled["episodes"].delivered.sum() > 990
    training, _ = show("environments/training.md")
    assert training["env"].possible_agents == ["teacher_0", "learner_0", "learner_1"]
    assert show("noise.md")[0]["env"].unwrapped.world.noise == Noise(wheel_slip=0.1)
    learning, printed = show("reinforcement_learning.md")
    assert learning["rewards"].shape == (256,)
    assert printed == "5 rounds\n"


@pytest.mark.parametrize(
    ("page", "count"), [("arenas.md", len(FAMILY)), ("environments/behaviours.md", 2), ("environments/wheels.md", 2)]
)
def test_page_states_foods_and_limits_of_environments(page: str, count: int) -> None:
    rows = re.findall(r"^\| `(khepera_forage/.+?)` \| .+? \| (\d) \| (\d+) steps \|$", PAGES[page], flags=re.MULTILINE)
    assert len(rows) == count
    for name, foods, limit in rows:
        own: Any = gym.make(name).unwrapped
        assert (own.foods, own.limit) == (int(foods), int(limit))


def test_arenas_page_has_the_family_and_the_difficulties() -> None:
    rows = re.findall(
        r"^\| `(khepera_forage/.+?)` \| `(\w+)`: .+? \| (\d+) x (\d+) \|", PAGES["arenas.md"], flags=re.MULTILINE
    )
    assert [name for _, name, *_ in rows] == list(FAMILY)
    for env_id, name, *size in rows:
        arena = gym.make(env_id).unwrapped.arena  # type: ignore[attr-defined]
        assert (arena.name, *arena.bounds[2:]) == (name, *map(int, size))
    for name, difficulty in DIFFICULTIES.items():
        (row,) = re.findall(rf"^\| {name} \| (\d.+) \|$", PAGES["arenas.md"], flags=re.MULTILINE)
        size, *counts, types, noise, limit = row.split(" | ")
        (short, long), (narrow, wide) = difficulty.length, difficulty.width
        assert size == f"{short} x {narrow} to {long} x {wide}"
        ranges = (difficulty.notches, difficulty.partitions, difficulty.blocks)
        texts = [f"{low}-{high}" if low < high else f"{low}" for low, high in ranges]
        assert counts == [*texts, str(difficulty.most_walls), str(difficulty.foods)]
        shares = [f"{share:.0%} {food.lower()}".replace("%", " %") for food, share in difficulty.food_types.items()]
        assert types == ", ".join(shares).replace("100 % ", "")
        assert (float(noise), int(limit)) == (difficulty.noise, difficulty.limit)


def test_box_of_reinforcement_learning_page_holds_distances_in_all_arenas() -> None:
    (bound,) = re.findall(r"Box\(-(\d), \1, \(9,\)", PAGES["reinforcement_learning.md"])
    assert f"(up to {bound} in the largest arenas" in PAGES["reinforcement_learning.md"]
    largest = max(np.hypot(one.length[1], one.width[1]) / MM_PER_PIXEL for one in DIFFICULTIES.values())
    assert largest / CORRIDOR_DIAGONAL < int(bound)


def test_sources_of_noise_page_are_all() -> None:
    listed = re.findall(r"^\| `([^`]+)` \| ([^|]*) \|$", PAGES["noise.md"], flags=re.MULTILINE)
    assert {name: tuple(re.findall(r"`(\w+)`", given)) for name, given in listed} == SOURCES


def test_extras_of_getting_started_page_are_all() -> None:
    rows = re.findall(r"^\| (`.*?`) \| .* \|$", PAGES["getting_started.md"], flags=re.MULTILINE)
    listed = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert listed == declared["optional-dependencies"].keys() - {"dev"}


def test_learner_page_lists_all_learners() -> None:
    table = LEARNER_PAGE[LEARNER_PAGE.index("## What comes with the package") :]
    listed = {
        name
        for cell in re.findall(r"^\| (`.*?) \|", table, flags=re.MULTILINE)
        for name in re.findall(r"`(\w+)`", cell)
    }
    assert listed == set(LEARNERS)


SCRIPTS = "|".join(path.stem for path in (ROOT / "benchmarks").glob("*.py"))
"""Pages also name scripts of earlier versions."""
COMMANDS = [
    (page, command)
    for page, text in PAGES.items()
    for command in re.findall(
        rf"^(?: {{4}})?((?:khepera-forage|python benchmarks/(?:{SCRIPTS})\.py) .*)$",
        text.replace("\\\n", " "),
        flags=re.MULTILINE,
    )
]


@pytest.mark.parametrize(("page", "command"), COMMANDS)
def test_command_of_page_and_its_options_exist(page: str, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def parse_only(parser: OneLineParser, *args: Any) -> None:
        argparse.ArgumentParser.parse_args(parser, *args)
        parser.exit()

    monkeypatch.setattr(OneLineParser, "parse_args", parse_only)
    program, *arguments = shlex.split(command, comments=True)
    run: Callable[[], object] = partial(main, arguments)
    if program == "python":
        script = ROOT / arguments[0]
        monkeypatch.syspath_prepend(script.parent)
        monkeypatch.setattr("sys.argv", [str(script), *arguments[1:]])
        run = partial(runpy.run_path, str(script), run_name="__main__")
    with pytest.raises(SystemExit, match=r"^0$"):
        run()


@pytest.mark.parametrize("page", [*PAGES, "../README.md"])
def test_links_lead_to_files_and_headings(page: str) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)]+)\)", text) if not link.startswith("http")]
    for path, _, heading in (link.partition("#") for link in links):
        target = ((DOCS / page).parent / path).resolve() if path else DOCS / page
        assert target.exists(), path
        if heading:
            titles = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), flags=re.MULTILINE)
            assert heading in {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}, heading


@pytest.mark.parametrize("page", [page for page in PAGES if "/" not in page and page not in {*INCLUDED, INDEX}])
def test_page_begins_with_what_its_reader_can_do(page: str) -> None:
    assert "\n\nAfter reading this page you can " in PAGES[page][:200], page


def test_architecture_page_has_all_folders_and_benchmarks() -> None:
    folders = {path.parent.name for path in Path(khepera_forage.__file__).parent.glob("*/__init__.py")}
    table = PAGES["architecture.md"].partition("| folder |")[2].partition("\n\n")[0]
    assert folders | {"benchmarks"} == set(re.findall(r"^\| \[?`(\w+)`", table, flags=re.MULTILINE))
    (row,) = re.findall(r"^\| `benchmarks`.*$", table, flags=re.MULTILINE)
    assert set(re.findall(r"`(\w+\.py)`", row)) == {path.name for path in (ROOT / "benchmarks").glob("*.py")}


# ---------------------------------------------------------------- README


def test_example_of_readme_delivers_the_food(capsys: pytest.CaptureFixture[str]) -> None:
    example = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)[0]
    assert len(example.splitlines()) <= 10
    exec(compile(example, "README.md", "exec"), {})
    assert re.fullmatch(r"score \d+\.\d % in \d+ steps, food 1 of 1\n", capsys.readouterr().out)


def test_readme_is_short_and_begins_with_picture_installation_use_and_two_commands() -> None:
    assert len(README.splitlines()) <= 150
    parts = ("![", "pip install 'khepera-forage[all]'", "```python", "make reproduce", "## Results")
    places = [README.index(part) for part in parts]
    assert places == sorted(places)


def test_results_of_readme_are_those_of_the_reproduction_page() -> None:
    rows = re.findall(r"^\| (?:corridor|rectangle) \| \d+ \|.*$", README, flags=re.MULTILINE)
    assert len(rows) == 7
    for row in rows:
        arena, episodes, *measured = row.strip("| ").split(" | ")
        assert re.search(rf"^\| {arena} \| {episodes} \| .*$", PAGES["reproduction.md"], flags=re.MULTILINE)
        assert all(f"| {value} |" in PAGES["reproduction.md"] for value in measured), row


def test_readme_links_to_every_section_of_the_site() -> None:
    pages = set(re.findall(r"^(\w+)$", PAGES[INDEX], flags=re.MULTILINE))
    only_on_the_site = {"api", "changelog", "contributing"}
    assert pages - only_on_the_site <= set(re.findall(r"\]\(docs/(\w+)\.md\)", README))
