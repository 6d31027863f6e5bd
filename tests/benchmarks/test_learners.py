"""`khepera-forage compare`: rows, tables and page agree, settings are compared, and a killed run is continued."""

import math
import re
import shutil
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from khepera_forage.comparison.compare import CANDIDATES, candidates, differences, unavailable
from khepera_forage.comparison.learning import ALL_ARENAS, RecallBatch, settings_text
from khepera_forage.comparison.results import curves
from khepera_forage.policies import Teacher
from khepera_forage.policies.learners import LEARNERS, Supervision
from khepera_forage.rollouts.recall import recall, recall_env
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import quick, quick_here, read, refused
from tests.benchmarks.test_scripts import LEARNERS_RUN

NAMES = ("teacher", "random", "imitator", "tree", "dagger_tree")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("learners", *LEARNERS_RUN)


def test_every_learner_has_a_row_for_each_seed_amount_and_arena(out: Path) -> None:
    rows = read(out / "rows.csv")
    amounts = {"imitator": "12", "tree": "12", "teacher": "0", "random": "0"}
    wanted = {
        (name, seed, amount, arena)
        for name in NAMES
        for seed in "01"
        for amount in (("100", "200") if name == "dagger_tree" else amounts[name])
        for arena in ("corridor", "rectangle")
    }
    assert sorted(wanted) == sorted((r["learner"], r["replication"], r["amount"], r["arena"]) for r in rows)
    assert all(int(row["foods"]) == (1 if row["arena"] == "corridor" else 2) for row in rows)


def test_steps_are_those_of_the_learning(out: Path) -> None:
    vectors: dict[tuple[str, str], tuple[int, int]] = {}
    for row in read(out / "rows.csv"):
        steps, learned = int(row["steps"]), int(row["vectors"])
        if row["learner"] in ("imitator", "tree"):
            assert steps >= learned > 0
            known = vectors.setdefault((row["replication"], row["amount"]), (steps, learned))
            assert known == (steps, learned), "the same training files"
        else:
            assert steps == learned == int(row["amount"])
    assert all(vectors[seed, "1"] < vectors[seed, "2"] for seed in "01")
    assert vectors["0", "2"] != vectors["1", "2"], "other seeds, other training files"


def test_the_teacher_delivers_all_and_random_behaviours_little(out: Path) -> None:
    rows = [row for row in read(out / "rows.csv") if row["amount"] in ("0", "2", "200")]  # after all learning
    share = {
        name: np.mean([int(row["delivered"]) / int(row["foods"]) for row in rows if row["learner"] == name])
        for name in NAMES
    }
    assert share["teacher"] == 1
    assert share["random"] < 0.2 < share["dagger_tree"]


def test_rows_of_the_teacher_are_those_of_its_recalls(out: Path) -> None:
    for row in (row for row in read(out / "rows.csv") if row["learner"] == "teacher"):
        sequences = np.random.SeedSequence(1, spawn_key=(int(row["replication"]),)).spawn(1 + len(ALL_ARENAS))
        seeds = sequences[1 + ALL_ARENAS.index(row["arena"])].generate_state(int(row["recalls"])).tolist()
        done = [recall(recall_env(row["arena"]), Teacher(), seed) for seed in seeds]
        assert int(row["recall_steps"]) == sum(one.steps for one in done)
        assert int(row["delivered"]) == sum(one.delivered for one in done) > 0
        assert float(row["score"]) == pytest.approx(np.mean([one.score for one in done]))


def test_tables_are_those_of_the_rows(out: Path) -> None:
    rows = read(out / "rows.csv")
    titles = {LEARNERS[name].title: name for name in NAMES if name in LEARNERS}
    titles |= {"the teacher": "teacher", "random behaviours": "random"}
    table = read(out / "table_learners.csv")
    assert len(table) == 2 * len(NAMES)
    for line in table:
        own = [r for r in rows if r["learner"] == titles[line["learner"]] and r["arena"] == line["arena"]]
        last = [r for r in own if int(r["amount"]) == max(int(row["amount"]) for row in own)]
        assert int(line["seeds"]) == len(last) == 2
        food = sum(int(r["delivered"]) for r in last) / sum(int(r["foods"]) for r in last)
        assert float(line["food delivered (%)"]) == pytest.approx(100 * food, rel=1e-5)
        assert float(line["score (%)"]) == pytest.approx(sum(float(r["score"]) for r in last) / 2, rel=1e-5)
        assert float(line["steps of learning"]) == pytest.approx(sum(int(r["steps"]) for r in last) / 2)
    assert len(read(out / "table_amounts.csv")) * 2 == len(rows)


def test_page_has_settings(out: Path) -> None:
    page = (out / "learners.md").read_text(encoding="utf-8")
    assert "| `imitator` | the thesis's imitator | `NearestNeighbourImitator(); diagonal of the arena` |" in page
    assert "| `dagger_tree` | DAgger, tree | `tree(); queries_a_round=100` |" in page


def batch(learner: str, amount: int, steps: int, delivered: int) -> RecallBatch:
    return RecallBatch(learner, 0, amount, "corridor", steps, 0, 10, 50.0, delivered, 10, 900, 1.0)


def test_steps_to_success_are_those_of_the_median_replication() -> None:
    rows = [
        replace(batch("tree", amount, 90 * amount, 9 if amount >= enough else 0), replication=number)
        for number, enough in enumerate((1, 2, 3, 4))
        for amount in (1, 2, 3)
    ]
    for first, steps in ((0, 180), (3, 270), (9, math.inf)):
        (curve,) = curves(rows[first:], 0)
        assert curve.steps_to_success.value == steps


def test_rows_of_other_learners_in_the_folder_are_kept_but_must_be_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(LEARNERS, "mine", LEARNERS["tree"])
    run = ("--seeds", "1", "--jobs", "1")
    for name in ("mine", "teacher"):
        quick_here("learners", tmp_path, "--only", name, *run)
    assert {row["learner"] for row in read(tmp_path / "rows.csv")} == {"teacher", "mine"}
    table = read(tmp_path / "table_learners.csv")
    assert {line["learner"] for line in table} == {"the teacher", "decision tree"}
    monkeypatch.delitem(LEARNERS, "mine")
    told = refused("learners", "--only", "teacher", "--seed", "1", "--out", str(tmp_path), *run)
    assert "learner is 'mine'; allowed: teacher, random, imitator" in told


def test_an_interval_does_not_depend_on_the_other_learners() -> None:
    rows = [
        replace(batch(name, 1, 90, number % 9), replication=number) for name in ("tree", "ppo") for number in range(8)
    ]
    assert curves(rows, 0)[1] == curves(rows[8:], 0)[0]


def test_learners_are_tested_in_the_arenas_that_are_named(tmp_path: Path) -> None:
    arenas = ("corridor", "mixed_foods", "hard")
    run = ("--only", "teacher", "--only", "tree", "--seeds", "1", "--jobs", "1")
    quick_here("learners", tmp_path / "some", *run, "--arenas", *arenas)
    rows = read(tmp_path / "some" / "rows.csv")
    teacher = [row for row in rows if row["learner"] == "teacher"]
    assert [row["arena"] for row in teacher] == list(arenas)
    assert all(row["delivered"] == row["foods"] for row in teacher), "food that is not poisonous counts"
    tested = [(row["amount"], row["arena"]) for row in rows if row["learner"] == "tree"]
    assert tested == [("1", "corridor"), *(("2", arena) for arena in arenas)], "elsewhere after all of the learning"
    line, _ = read(tmp_path / "some" / "table_arenas.csv")
    assert {line[column] for column in ("corridor", "other named arenas", "procedural arenas", "in hard")} == {"100"}
    assert (tmp_path / "some" / "arenas.png").exists()
    told = refused("learners", "--arenas", "kitchen")
    assert "'kitchen'" in told
    assert "t_maze" in told


def test_unavailable_backends_have_a_reason() -> None:
    assert unavailable("loky", None) == ""
    assert unavailable("loky", "tcp://here:1") == "--address is 'tcp://here:1'; allowed: with --backend dask"
    missing = "--backend dask needs the extra dask: pip install 'khepera-forage[dask]'"
    assert unavailable("dask", None) == ("" if find_spec("distributed") else missing)


@pytest.fixture(scope="module")
def tuned(quick_run: QuickRun) -> Path:
    return quick_run("learners", "--tune", "--only", "dagger_tree", "--seeds", "1")


def test_tuning_compares_settings_over_other_seeds(tuned: Path) -> None:
    table = read(tuned / "tuning/table_tuning.csv")
    settings = [line["settings"] for line in table]
    assert settings[0] == settings_text(LEARNERS["dagger_tree"])
    assert len(set(settings)) == len(settings) == 5
    best = [line for line in table if line["best"]]
    assert len(best) == 1
    assert float(best[0]["food delivered (%)"]) == max(float(line["food delivered (%)"]) for line in table)
    for line in table[1:]:
        more = float(line["food delivered (%)"]) - float(table[0]["food delivered (%)"])
        assert float(line["more (points)"]) == pytest.approx(more)
    assert table[0]["more (points)"] == ""
    seeds = {row["replication"] for row in read(tuned / "tuning/rows.csv")}
    assert seeds == {"1000"}
    page = (tuned / "tuning/tuning.md").read_text(encoding="utf-8")
    assert page.startswith("# Settings of the learners\n")
    assert "    khepera-forage compare --quick --seed 1 --out " in page
    assert " --tune --only dagger_tree --seeds 1\n" in page


def test_the_page_links_the_settings_page_if_there_is_one(out: Path, tuned: Path, tmp_path: Path) -> None:
    assert "tuning/tuning.md" not in (out / "learners.md").read_text(encoding="utf-8")
    whole = shutil.copytree(tuned, tmp_path / "whole")
    quick_here("learners", whole, "--only", "dagger_tree", "--seeds", "1", "--jobs", "1")
    page = (whole / "learners.md").read_text(encoding="utf-8")
    assert "[all settings](tuning/tuning.md)" in page


def test_settings_are_compared_over_the_same_replications() -> None:
    def rows(name: str, more: int) -> list[Any]:
        # The replications differ by more than the settings do.
        return [
            replace(batch(name, 10, 900, delivered + more), replication=1_000 + number)
            for number, delivered in enumerate((1, 8, 3, 5, 1, 8))
        ]

    found = [*rows("tree", 0), *rows("tree.1", 1), *rows("tree.2", -1), *rows("tree.3", 0)]
    gains = differences(found, 0)
    for name, more in (("tree.1", 10), ("tree.2", -10), ("tree.3", 0)):
        assert tuple(gains[name]) == pytest.approx((more, more, more))


def test_tuned_learners_have_as_many_settings_each() -> None:
    tried = CANDIDATES
    needing = {name for name, learner in LEARNERS.items() if learner.needs is not Supervision.STEPS}
    assert set(tried) == needing - {"imitator"}
    assert {len(changes) for changes in tried.values()} == {3}
    assert len({settings_text(learner) for learner in candidates().values()}) == 5 * len(tried)


def test_a_learner_of_ones_own_has_a_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a file in the folder in which the benchmark is started; other learners have no rows."""
    file = tmp_path / "mine.py"
    file.write_text(
        "from sklearn.ensemble import RandomForestClassifier\n"
        "def small_forest(random_state=None):\n"
        "    return RandomForestClassifier(3, random_state=random_state)\n"
    )
    printed = quick("learners", tmp_path / "out", "--learner", "mine:small_forest", "--seeds", "1")
    shown = {line.partition("  ")[0] for line in printed.splitlines() if " rectangle " in line}
    assert shown == {"the teacher", "the thesis's imitator", "small forest"}
    assert max(map(len, printed.splitlines()[:-1])) <= 80
    assert {row["learner"] for row in read(tmp_path / "out" / "rows.csv")} == {"teacher", "imitator", "small_forest"}
    page = (tmp_path / "out" / "learners.md").read_text(encoding="utf-8")
    assert " --learner mine:small_forest --seeds 1\n" in page
    for text in (page, printed):
        assert "it supports no claim" in text
    file.write_text(file.read_text().replace("(3,", "(4,"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    told = refused("learners", "--learner", "mine:small_forest", "--seed", "1", "--out", str(tmp_path / "out"))
    assert re.search(r"with learner small_forest 'small_forest\(\) of mine\.py \(.*and this run has .*--fresh", told)


OWN = """
from sklearn.ensemble import RandomForestClassifier

def number():
    return 3

class NoClasses:
    def fit(self, X, y):
        return self
    def predict_proba(self, X):
        return [[1.0]]

class Fails(RandomForestClassifier):
    def fit(self, X, y):
        raise RuntimeError("my own mistake")

class Quits(RandomForestClassifier):
    def fit(self, X, y):
        raise SystemExit("no licence")

class FailsLater(RandomForestClassifier):
    def fit(self, X, y):
        if len(X) > 150:
            raise IndexError("too much")
        super().fit(X, y)
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "own_learners.py").write_text(OWN)
    (tmp_path / "broken_module.py").write_text("x = 1 / 0\n")
    (tmp_path / "no_python.py").write_text("def f(:\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("own_learners", "broken_module", "no_python"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("NoClasses", "NoClasses has no classes_; allowed: a fitted classifier"),
        ("number", "number makes 3; allowed: a classifier with fit and predict_proba"),
    ],
)
def test_a_learner_of_another_form_is_refused_in_one_line(name: str, message: str, own: Path) -> None:
    told = refused("learners", "--learner", f"own_learners:{name}", "--out", str(own / "out"))
    assert told.startswith("khepera-forage compare: --learner ")
    assert f"own_learners:{name}" in told
    assert message in told
    assert told.count("\n") == 1


@pytest.mark.parametrize(
    ("place", "line", "error"),
    [
        ("own_learners:Fails", 'raise RuntimeError("my own mistake")', "RuntimeError: my own mistake\n"),
        ("own_learners:Quits", 'raise SystemExit("no licence")', "SystemExit: no licence\n"),
        ("own_learners:FailsLater", 'raise IndexError("too much")', "IndexError: too much\n"),
        ("broken_module:x", "x = 1 / 0", "ZeroDivisionError: division by zero\n"),
        ("no_python:f", "def f(:", "SyntaxError: invalid syntax\n"),
    ],
)
def test_an_error_of_a_learner_shows_its_own_traceback(place: str, line: str, error: str, own: Path) -> None:
    told = refused("learners", "--learner", place, "--seeds", "1", "--jobs", "1", "--out", str(own / "out"))
    assert f"{place.partition(':')[2]} failed\n" in told
    assert f'File "{own / place.partition(":")[0]}.py", line ' in told
    assert line in told
    assert told.endswith(error)
    assert "khepera_forage/" not in told
    assert "importlib" not in told
