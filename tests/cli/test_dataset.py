"""`khepera-forage dataset`: a Minari dataset of new episodes or of files, and its data card."""

import re
from collections import Counter
from pathlib import Path

import minari
import pytest
from sklearn.tree import DecisionTreeClassifier

from khepera_forage import as_policy, recall, recall_env
from khepera_forage.cli.dataset import FOLDER_VARIABLE
from khepera_forage.envs import paired_arenas_v1
from khepera_forage.envs.arena_settings import settings_of
from khepera_forage.experience import Experience
from khepera_forage.experience.minari import from_minari
from khepera_forage.rollouts.training import arrays
from khepera_forage.sim.arena_file import write_arena
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import StateVector
from tests.arenas import BLOCKS
from tests.cli.running import Run

SOME = Experience([(0, 60, 0, 215, 40), (0, 60, 0, 255, 18), (0, 59, 0, 215, 39)], [0, 2, 0], seed=7)


@pytest.fixture(autouse=True)
def other_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "elsewhere"))


def test_new_episodes_are_a_dataset_with_a_card(run: Run) -> None:
    given = "--episodes 2 --arena mixed_foods --seed 4"
    printed = run(f"dataset {given} --author me --out data")
    run(f"train {given} --out files")
    parts = from_minari("khepera_forage/mixed_foods-v1")
    assert parts == [Experience.load("files/g1.csv"), Experience.load("files/g2.csv")]
    env = minari.load_dataset("khepera_forage/mixed_foods-v1").recover_environment().unwrapped
    assert (env.arena.name, env.limit) == ("mixed_foods", paired_arenas_v1.raw_env("mixed_foods").max_cycles)
    steps = sum(map(len, parts))
    assert f"khepera_forage/mixed_foods-v1: 2 episodes, {steps:,} steps, in data\n" in printed
    card = Path("data/khepera_forage/mixed_foods-v1/README.md").read_text(encoding="utf-8")
    for line in (
        "| arena | mixed_foods |",
        "in copies of the arena mixed_foods",
        "foraged for food (50 % PICKABLE, 25 % PUSHABLE, 25 % POISONOUS), and the learner listened.",
        *(f"| `{name}` | " for name in StateVector._fields),
        "Episodes that were not completed are not in the data",
        f"| steps | {steps:,}; {min(map(len, parts))} to {max(map(len, parts))} an episode |",
        "| author | me |",
        "| licence | CC0-1.0 |",
        "- Decisions, that is, readings of what the thesis leaves open: `v1`.",
        f"- Seed: 4. Seeds of the episodes: {parts[0].seed}, {parts[1].seed}.",
        "`khepera-forage dataset --episodes 2 --arena mixed_foods --seed 4 --author me --out data`",
    ):
        assert line in card
    (block,) = re.findall(r"```python\n(.*?)```", card, flags=re.DOTALL)
    names: dict[str, object] = {}
    exec(block, names)
    assert names["episodes"] == parts


def test_the_teacher_alone_is_a_dataset_that_a_learner_learns_to_forage_from(run: Run) -> None:
    run("dataset --alone --episodes 5 --out data")
    dataset = minari.load_dataset("khepera_forage/corridor-alone-v1")
    parts = from_minari(dataset)
    starts = {part.arrays()[0][0].tolist()[1] for part in parts}
    assert len(starts) > 1, "random places"
    for part, episode in zip(parts, dataset.iterate_episodes(), strict=True):
        assert sum(episode.rewards) == pytest.approx(1 - len(part) / 500)
    card = Path("data/khepera_forage/corridor-alone-v1/README.md").read_text(encoding="utf-8")
    assert "Episodes of the teacher, which forages alone." in card
    assert "It foraged for PICKABLE food, from random places." in card
    assert "dataset --alone --episodes 5 --out data`" in card
    assert "not completed" not in card, "an episode that is out of time is in the data"
    vectors, behaviours = arrays(parts)
    learner = as_policy(DecisionTreeClassifier(random_state=0).fit(vectors, behaviours))
    env = recall_env("corridor")
    assert sum(recall(env, learner, seed).delivered for seed in range(10)) >= 9


def test_card_of_a_dataset_on_wheels_counts_every_round(run: Run) -> None:
    run("dataset --wheels --episodes 1 --food-type PUSHABLE --decision separation=6 --out data --author J\udcf6rg")
    dataset = minari.load_dataset("khepera_forage/corridor-wheels-v1")
    (episode,) = dataset.iterate_episodes()
    limit = dataset.recover_environment().unwrapped.limit
    assert sum(episode.rewards) == pytest.approx(1 - len(episode.rewards) / limit)
    card = Path("data/khepera_forage/corridor-wheels-v1/README.md").read_text(encoding="utf-8")
    counted = {int(number): int(count) for number, count in re.findall(r"^\| (\d+) \| [A-Z_]+ \| (\d+) \|", card, re.M)}
    assert counted == Counter(episode.infos["heard"][:-1].tolist())
    assert counted[10] > 0, "silence"
    assert "foraged for PUSHABLE food" in card
    assert "| author | J?rg |" in card, "what is not UTF-8 is replaced"


def test_files_are_a_dataset_whose_card_names_all_arenas_and_decisions(run: Run) -> None:
    for name, level, decisions in (("g1.csv", 7, Decisions()), ("g2.csv", 3, Decisions(next_to_food=22))):
        arena = f"procedural_easy_{level}"
        Experience(SOME.vectors, SOME.behaviours, arena, level, decisions=decisions).save(name)
    command = "dataset --experience g1.csv g2.csv --allow-other-decisions --name mine-v1 --out data"
    run(command)
    card = Path("data/mine-v1/README.md").read_text(encoding="utf-8")
    for line in (
        "| arena | procedural_easy_3, procedural_easy_7 |",
        "| 0 | SEARCH_FOR_FOOD | 4 | 66.7 |",
        "| 2 | ORIENT_WITH_FOOD | 2 | 33.3 |",
        "The experience was read from g1.csv, g2.csv.",
        "`v1 and v1;next_to_food=22`",
        "Seed: that of each file. Seeds of the episodes: 7, 3.",
    ):
        assert line in card
    assert "--name is 'mine-v1'; allowed: a name that is not in data yet" in run.refused(command)


def test_files_of_an_arena_of_ones_own_need_the_file_of_the_arena(run: Run) -> None:
    write_arena(BLOCKS, "blocks.toml")
    Experience(SOME.vectors, SOME.behaviours, "blocks").save("g1.csv")
    command = "dataset --experience g1.csv --out data"
    assert "experience of ['blocks']; allowed: one arena" in run.refused(command)
    other = run.refused(f"{command} --arena doors")
    assert "experience of ['blocks']; allowed: of 'doors', the argument arena" in other
    run(f"{command} --arena blocks.toml")
    assert Path("data/khepera_forage/blocks-v1/README.md").exists()
    dataset = minari.load_dataset("khepera_forage/blocks-v1")
    env = dataset.recover_environment().unwrapped
    assert env.arena == BLOCKS
    assert {"foods": env.foods, "limit": env.limit}.items() <= settings_of(BLOCKS).items()


def test_a_dataset_that_cannot_be_finished_is_removed(monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    SOME.save("g1.csv")

    def full(path: Path) -> None:
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr("khepera_forage.cli.dataset.replacing", full)
    run.refused("dataset --experience g1.csv --name mine-v1 --out data")
    assert not Path("data/mine-v1").exists()
