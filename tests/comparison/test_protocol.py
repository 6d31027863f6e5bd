"""The protocol `forage-bench-1`: what its units compute, that a killed run continues, and its datasets."""

import csv
import gzip
import zipfile
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("numba")

from khepera_forage.cli.dataset import FOLDER_VARIABLE
from khepera_forage.cli.main import main
from khepera_forage.comparison import PROTOCOL, protocol
from khepera_forage.comparison.compiled_learning import (
    Budget,
    TrainingData,
    demonstrate,
    random_marks,
    recalls_after,
    reference_recalls,
    search,
)
from khepera_forage.comparison.learning import BASELINES, settings_text
from khepera_forage.comparison.protocol import (
    ALONE,
    AS_HEARD,
    BUDGETS,
    GROUPS,
    LATE,
    THESIS,
    THINNED,
    TRACKS,
    TRAINED,
    WRONG,
    Demonstrations,
    page,
    plan,
)
from khepera_forage.comparison.results import PUBLISHED, read_results
from khepera_forage.policies import Teacher
from khepera_forage.policies.learners import LEARNERS, OfflineImitation
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.raw_episodes import teacher_alone
from khepera_forage.rollouts.recall import recall_env, recall_wheels_env
from khepera_forage.task.states import NUM_BEHAVIOURS, StateVector
from tests.benchmarks.running import read

TEN_STEPS = TrainingData(np.arange(50).reshape(10, 5), np.array([0, 0, 1, 2, 3, 4, 5, 6, 7, 8]), np.repeat((0, 1), 5))


class TeacherClassifier:
    """Has learned the teacher's program perfectly."""

    classes_ = np.arange(NUM_BEHAVIOURS, dtype=np.float64).tolist()

    def fit(self, vectors: NDArray[Any], behaviours: NDArray[Any]) -> None:
        pass

    def predict_proba(self, vectors: NDArray[Any]) -> NDArray[np.float64]:
        teacher = Teacher.of(recall_env("corridor"))
        chosen = [int(teacher.act(StateVector(*row)._asdict())) for row in vectors.tolist()]
        return np.eye(NUM_BEHAVIOURS)[chosen]


def test_the_protocol_is_that_of_the_published_rows() -> None:
    """Its definition does not change: learners and their settings, conditions, amounts, places, seeds, searches."""
    with zipfile.ZipFile(Path(__file__).parents[2] / "docs" / "published" / "protocol.zip") as archive:
        published = list(csv.DictReader(archive.read("rows.csv").decode().splitlines()))
        found = list(csv.DictReader(archive.read("demonstrations.csv").decode().splitlines()))
    assert {name: settings_text(one) for name, one in LEARNERS.items()} == {
        name: one.settings for name, one in read_results(PUBLISHED).learners.items() if name in LEARNERS
    }
    assert {"imitator": Budget(24, 20, 16, 160)} == BUDGETS
    searched = [Demonstrations(row["learner"], int(row["search"]), (0.0,) * 25) for row in found]
    planned = [
        unit
        for track in TRACKS
        for unit in plan(track, {**BASELINES, **LEARNERS}, 0, False, 50, list(dict.fromkeys(searched)))
    ]
    columns = ("track", "learner", "condition", "amount", "replication")
    units = Counter(tuple(row[column] for column in columns) for row in published if row["place"] == "corridor")
    assert units == Counter(
        (unit.track, unit.name, unit.condition, str(unit.amount), str(unit.replication)) for unit in planned
    )
    assert len({unit.key for unit in planned}) == len(planned)
    for track, one in TRACKS.items():
        places = {row["place"] for row in published if row["track"] == track}
        assert places == {place for group in one.places for place in GROUPS[group]}
    values = ("condition", "place", "recalls", "score", "delivered", "foods", "vectors")
    wanted = [
        tuple(row[column] for column in values)
        for row in published
        if (row["track"], row["learner"], row["replication"]) == ("vocabulary", "imitator", "0")
    ]
    run = [row for unit in plan("vocabulary", {"imitator": LEARNERS["imitator"]}, 0, False, 1) for row in unit.run()]
    repeated = [row for row in run if row.learner == "imitator"]
    assert [tuple(str(getattr(row, column)) for column in values) for row in repeated] == wanted


def test_lines_stand_in_the_order_of_the_protocol() -> None:
    """Rows of a continued run stand in the order in which their units ended."""
    ended = [("tree", AS_HEARD), ("imitator", LATE), ("imitator", AS_HEARD), ("mine", WRONG), ("teacher", "")]
    rows = [protocol.Tested("vocabulary", *kind, 10, 0, "corridor", 20, 50.0, 1, 2, 3, 0.1) for kind in ended]
    (table,) = page(rows, 0, False).tables
    assert [row[:2] for row in table.rows] == [
        *(("teacher", "-"), ("imitator", AS_HEARD), ("imitator", LATE), ("tree", AS_HEARD), ("mine", WRONG))
    ]


def test_a_perfect_student_forages_like_the_teacher() -> None:
    """Both kinds of recalls: within the kernel, and with classifiers that decide for all worlds of all places."""
    seeds = {"corridor": [3, 4, 5], "doors": [6], "hard": [8, 9]}
    perfect = recalls_after(OfflineImitation("perfect", TeacherClassifier), TEN_STEPS, seeds, 0, 138)
    teacher = reference_recalls(True, seeds)
    for place in seeds:
        for own, other in zip(perfect[place], teacher[place], strict=True):
            assert (own == other).all()
        assert (teacher[place].delivered == teacher[place].foods).all()


def test_a_search_finds_better_demonstrations_than_chance() -> None:
    learner = LEARNERS["imitator"]
    assert isinstance(learner, OfflineImitation)

    def delivered(marks: NDArray[np.float64]) -> float:
        seeds = {"corridor": range(50)}
        trainings = demonstrate(marks, 10**6, 8)
        return float(np.mean([recalls_after(learner, t, seeds, 0, 138)["corridor"].delivered for t in trainings]))

    found = search(learner, 1, Budget(12, 3, 8, 64), np.random.default_rng(1))
    chance = np.mean([delivered(random_marks(1, seed)) for seed in range(8)])
    assert delivered(found) > chance
    near = np.array([[40.0, 40.0, 0.0, 41.0, 40.0]])
    with pytest.raises(ValueError, match="allowed"):
        demonstrate(near, 0)


@pytest.fixture
def compare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    return lambda *words: main(["compare", "--protocol", "--quick", "--jobs", "1", "--out", "out", *words])


def timeless_rows() -> list[dict[str, str]]:
    return [row | {"seconds": ""} for row in read(Path("out/rows.csv"))]


def test_a_killed_run_continues(compare: Callable[..., int], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--only", "imitator", "--only", "tree", "--track", "teaching", "--track", "vocabulary"]
    assert compare(*words) == 0
    assert "best for imitator" in Path("out/table_transfer.csv").read_text()
    rows, searched = timeless_rows(), Path("out/demonstrations.csv").read_text()
    vectors = {(row["condition"], row["replication"]): row["vectors"] for row in rows if row["track"] == "teaching"}
    assert all(vectors[THINNED, number] == vectors[THESIS, number] for number in "01"), "as many"
    units = Path("out/units.jsonl.gz")
    units.write_bytes(gzip.compress(b"".join(gzip.decompress(units.read_bytes()).splitlines(True)[:9])))
    capsys.readouterr()
    assert compare(*words) == 0
    printed = capsys.readouterr().out
    assert "8 of 33 units are done already" in printed
    assert "1 of 1 units are done already" in printed
    assert Path("out/demonstrations.csv").read_text() == searched
    assert timeless_rows() == rows
    page = Path(f"out/{PROTOCOL}.md").read_text()
    assert "smoke test" in page
    assert {track for track in TRACKS if f"Track: {track}" in page} == {"teaching", "vocabulary"}


def test_wheels_and_many_places_in_small(compare: Callable[..., int]) -> None:
    only = ("--only", "tree", "--only", "k_nearest")
    assert compare(*only, "--seeds", "1", "--track", "offline", "--track", "wheels") == 0
    offline = Path("out/table_offline.csv").read_text()
    assert all(f"{name},thesis's,1,1," in offline for name in ("tree", "k_nearest"))
    wheels = Path("out/table_wheels.csv").read_text()
    assert all(f"{name},{data},10,1," in wheels for name in ("network", "trees") for data in (TRAINED, ALONE))
    assert "teacher,-,0,1,100," in wheels


def test_raw_episodes_replay() -> None:
    """What was recorded is what the environment shows and pays when the recorded motors are commanded."""
    env = recall_wheels_env("corridor")
    for seed in range(2):
        episode = teacher_alone(env, seed)[1]
        shown, _ = env.reset(seed=seed)
        for number, action in enumerate(episode.actions):
            assert all((shown[name] == episode.observations[name][number]).all() for name in shown)
            shown, reward, terminated, _, _ = env.step(action)
            assert reward == episode.rewards[number]
        assert terminated
        assert episode.rewards.sum() == pytest.approx(1 - len(episode.actions) / 500)


def test_rewards_of_compiled_training_are_those_of_the_environment() -> None:
    """+1 for the delivery and -1/600 a round, also for the rounds of silence."""
    trained = train_learners(30, seed=3, episodes=2)
    rounds = trained.attempts.rounds[trained.attempts.complete].reshape(30, 2)
    for learner in range(30):
        for episode in range(2):
            rewards = trained.rewards_of(learner, episode)
            assert len(rewards) == len(trained.vectors_of(learner, episode))
            assert rewards.sum() == pytest.approx(1 - rounds[learner, episode] / 600, abs=1e-4)


def test_one_command_makes_the_datasets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    minari = pytest.importorskip("minari")
    pytest.importorskip("h5py")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "elsewhere"))
    assert main(["dataset", "--protocol", "--episodes", "2", "--out", "data"]) == 0
    heard = import_module("khepera_forage.experience.minari").from_minari(f"{PROTOCOL}/corridor-v1")
    unit = next(iter(plan("offline", {"imitator": LEARNERS["imitator"]}, 0, False, 1)))._replace(
        condition="thesis's", amount=2, name="imitator"
    )
    assert np.concatenate([part.arrays()[0] for part in heard]).tolist() == unit.training(0).vectors.tolist()
    for name, actions in (("corridor-v1", ()), ("corridor-wheels-v1", (4,)), ("alone-wheels-v1", (4,))):
        dataset = minari.load_dataset(f"{PROTOCOL}/{name}")
        for episode in dataset.iterate_episodes():
            assert episode.actions.shape[1:] == actions
            assert 0.2 < episode.rewards.sum() < 0.95
        env = dataset.recover_environment()
        assert env.unwrapped.limit == (500 if name.startswith("alone") else 600), "as the rewards have it"
        env.reset(seed=0)
        env.step(episode.actions[0])
    card = Path(f"data/{PROTOCOL}/alone-wheels-v1/README.md").read_text()
    assert "the teacher, which forages alone" in card
    assert main(["dataset", "--protocol", "--wheels"]) == 2
    assert "--wheels has no effect here; allowed: without --protocol" in capsys.readouterr().err
