"""`benchmarks/learners.py`: rows, table, page and picture agree, and a run that was killed goes on where it was."""

import importlib
import json
import math
import subprocess
import sys
import time
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sklearn.ensemble import RandomForestClassifier

from khepera_forage.policies.learners import LEARNERS, FromVectors, Needs
from tests.benchmarks.running import ROOT, help_of, is_picture, quick, read

NAMES = ("teacher", "random", "imitator", "tree", "dagger_tree")
ONLY = [part for name in NAMES for part in ("--only", name)]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "learners"
    quick("learners.py", folder, *ONLY, "--jobs", "1")
    return folder


@pytest.fixture
def rooms(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    names = ("rows", "lessons", "units", "folder", "tuning", "backends", "curves", "page")
    return SimpleNamespace(**{name: importlib.import_module(f"_learners.{name}") for name in names})


def timeless(path: Path) -> list[str]:
    """A file of rows but for wall times, which come last."""
    return [line.rsplit(",", 1)[0] for line in path.read_text(encoding="utf-8").splitlines()]


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


def test_steps_are_those_lived_through(out: Path) -> None:
    vectors: dict[tuple[str, str], tuple[int, int]] = {}
    for row in read(out / "rows.csv"):
        steps, learned = int(row["steps"]), int(row["vectors"])
        if row["learner"] in ("teacher", "random"):
            assert (steps, learned) == (0, 0)
        elif row["learner"] == "dagger_tree":
            assert steps == learned == int(row["amount"])
        else:
            assert steps >= learned > 0
            key = (row["replication"], row["amount"])
            assert vectors.setdefault(key, (steps, learned)) == (steps, learned), "the same training files"
    assert all(vectors[seed, "1"] < vectors[seed, "2"] for seed in "01")
    assert vectors["0", "2"] != vectors["1", "2"], "other seeds, other training files"


def test_the_teacher_delivers_all_and_chance_next_to_nothing(out: Path) -> None:
    rows = read(out / "rows.csv")
    share = {
        name: sum(int(r["delivered"]) for r in rows if r["learner"] == name)
        / sum(int(r["foods"]) for r in rows if r["learner"] == name)
        for name in NAMES
    }
    assert share["teacher"] == 1
    assert share["random"] < 0.2 < share["dagger_tree"]


def test_tables_are_those_of_the_rows(out: Path) -> None:
    rows = read(out / "rows.csv")
    titles = {LEARNERS[name].title: name for name in NAMES if name in LEARNERS}
    titles |= {"the teacher": "teacher", "any behaviour": "random"}
    table = read(out / "table_learners.csv")
    assert len(table) == 2 * len(NAMES)
    for line in table:
        own = [r for r in rows if r["learner"] == titles[line["learner"]] and r["arena"] == line["arena"]]
        last = [r for r in own if int(r["amount"]) == max(int(row["amount"]) for row in own)]
        assert int(line["seeds"]) == len(last) == 2
        food = sum(int(r["delivered"]) for r in last) / sum(int(r["foods"]) for r in last)
        assert float(line["food delivered (%)"]) == pytest.approx(100 * food, rel=1e-5)
        assert float(line["score (%)"]) == pytest.approx(sum(float(r["score"]) for r in last) / 2, rel=1e-5)
        assert float(line["steps lived through"]) == pytest.approx(sum(int(r["steps"]) for r in last) / 2)
    assert len(read(out / "table_amounts.csv")) * 2 == len(rows)


def test_page_has_picture_settings_and_command(out: Path) -> None:
    page = (out / "learners.md").read_text(encoding="utf-8")
    assert "](learners.png)" in page
    assert (
        "| `imitator` | the thesis' imitator | `NearestNeighbourImitator(); diagonal of the arena` |" in page
    )
    assert "| `dagger_tree` | DAgger, tree | `tree(); queries_a_round=100` |" in page
    assert "--seeds 2 --recalls 1 --steps 1000 --seed 1 --quick" in page
    assert is_picture(out / "learners.png")


def reading(rooms: SimpleNamespace, rows: list[Any]) -> str:
    """What came out, as the page says it of these rows."""
    found = rooms.curves.curves(rows, np.random.default_rng(0))
    text: str = rooms.page.page(found, rooms.units.everyone(), {}, "", "")
    return text.split("## What came out")[1].split("## How")[0]


def batch(rooms: SimpleNamespace, learner: str, amount: int, steps: int, delivered: int) -> Any:
    return rooms.rows.Batch(learner, 0, amount, "corridor", steps, 0, 10, 50.0, delivered, 10, 900, 1.0)


def test_who_needs_the_same_amount_is_level(rooms: SimpleNamespace) -> None:
    rows = [batch(rooms, "ppo", 10_000, 10_240, 9), batch(rooms, "dqn", 10_000, 10_000, 9)]
    rows += [batch(rooms, name, 1_000, 1_000, 7) for name in ("ppo", "dqn")]
    level = "80 %, level: PPO on behaviours, after 10,240 steps; DQN on behaviours, after 10,000 steps.\n"
    text = reading(rooms, rows)
    assert f"First to deliver {level}" in text
    assert "PPO on behaviours, 90.0 % after 10,240 steps; DQN on behaviours, 90.0 % after 10,000" in text
    rows[-1] = batch(rooms, "dqn", 1_000, 1_000, 8)
    assert "First to deliver 80 %: DQN on behaviours, after 1,000 steps.\n" in reading(rooms, rows)


def test_the_median_replication_says_who_is_first(rooms: SimpleNamespace) -> None:
    rows = [
        replace(batch(rooms, "tree", amount, 90 * amount, 9 if amount >= enough else 0), replication=number)
        for number, enough in enumerate((1, 2, 3, 4))
        for amount in (1, 2, 3)
    ]
    (curve,) = rooms.curves.curves(rows, np.random.default_rng(0))
    assert (curve.enough_asked, curve.enough.value) == (2, 180)
    (curve,) = rooms.curves.curves(rows[3:], np.random.default_rng(0))
    assert (curve.enough_asked, curve.enough.value) == (3, 270)
    (curve,) = rooms.curves.curves(rows[9:], np.random.default_rng(0))
    assert curve.enough_asked == curve.enough.value == math.inf


def test_whether_wheels_are_learned_comes_of_the_rows(rooms: SimpleNamespace) -> None:
    rows = [batch(rooms, "ppo", 10_000, 10_240, 9)]
    assert "on wheels" not in reading(rooms, rows)
    rows += [batch(rooms, "ppo_wheels", 10_000, 10_240, 2), batch(rooms, "sac_wheels", 10_000, 10_000, 1)]
    text = reading(rooms, rows)
    assert "trial and error on wheels.** Within 10,000 steps none learns to forage (80 %" in text
    assert "Food delivered in the end: PPO on wheels, 20.0 %; SAC on wheels, 10.0 %.\n" in text
    rows[-1] = batch(rooms, "sac_wheels", 10_000, 10_000, 8)
    assert "on wheels.** 1 of 2 learn to forage within 10,000 steps (80 %" in reading(rooms, rows)


def test_same_rows_on_any_number_of_processes(out: Path, tmp_path: Path) -> None:
    quick("learners.py", tmp_path / "two", *ONLY, "--jobs", "2")
    assert timeless(tmp_path / "two/rows.csv") == timeless(out / "rows.csv")


def test_a_killed_run_goes_on_from_its_rows(tmp_path: Path) -> None:
    arguments = ["--only", "tree", "--seeds", "4", "--jobs", "1"]
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    quick("learners.py", whole, *arguments)
    script = str(ROOT / "benchmarks/learners.py")
    command = [sys.executable, script, "--quick", "--seed", "1", "--out", str(killed), *arguments]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    rows = killed / "rows.csv"
    while process.poll() is None and not (rows.exists() and rows.read_bytes().count(b"\n") > 4):
        time.sleep(0.005)
    process.kill()
    assert process.wait() == -9
    done = (rows.read_bytes().count(b"\n") - 1) // 4
    assert 1 <= done < 4, "it was killed with work done, and with work to do"
    with rows.open("ab") as file:
        file.write(b"tree,7,1,corr")  # a line cut short, as a kill in the middle of a write leaves it
    printed = quick("learners.py", killed, *arguments)
    assert f"{done} of 4 units are done already" in printed
    assert f"{4 - done} units for 1 processes" in printed
    assert timeless(rows) == timeless(whole / "rows.csv")
    finished = rows.read_bytes()
    assert "4 of 4 units are done already" in quick("learners.py", killed, *arguments)
    assert rows.read_bytes() == finished


def test_a_unit_that_is_not_whole_is_done_again(rooms: SimpleNamespace, out: Path, tmp_path: Path) -> None:
    size = rooms.rows.Size(1, (1, 2), (100, 200), (1_000,))
    everyone = rooms.units.everyone()
    lines = (out / "rows.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "rows.csv").write_text("".join(lines[:-1]), encoding="utf-8")
    rows = rooms.folder.kept(tmp_path, size, everyone)
    assert len(rows) == len(lines) - 1 - 4, "the last unit has four rows"
    assert (tmp_path / "rows.csv").read_text(encoding="utf-8") == "".join(lines[:-4])
    del everyone["tree"]
    with pytest.raises(ValueError, match="learner is 'tree'; allowed: teacher, random, imitator"):
        rooms.folder.kept(tmp_path, size, everyone)


def test_rows_of_other_settings_are_refused(rooms: SimpleNamespace, tmp_path: Path) -> None:
    claim, size = rooms.folder.claim, rooms.rows.Size(1, (1, 2), (100,), (1_000,))
    claim(tmp_path, 1, size, {"tree": "tree()"})
    claim(tmp_path, 1, size, {"forest": "forest()"})
    with pytest.raises(
        ValueError, match=r"settings\.json: .* with seed 1, and this run has 2; allowed: the same"
    ):
        claim(tmp_path, 2, size, {"tree": "tree()"})
    with pytest.raises(ValueError, match=r"with recalls 1, and this run has 3"):
        claim(tmp_path, 1, size._replace(recalls=3), {"tree": "tree()"})
    with pytest.raises(ValueError, match=r"with tree 'tree\(\)', and this run has 'tree\(max_depth=3\)'"):
        claim(tmp_path, 1, size, {"tree": "tree(max_depth=3)"})
    noted = json.loads((tmp_path / "settings.json").read_text(encoding="utf-8"))
    assert noted["learners"] == {"tree": "tree()", "forest": "forest()"}
    (tmp_path / "settings.json").write_text("[]", encoding="utf-8")
    with pytest.raises(ValueError, match=r"settings\.json: allowed: what a run of this benchmark wrote"):
        claim(tmp_path, 1, size, {})
    (tmp_path / "settings.json").unlink()
    (tmp_path / "rows.csv").touch()
    with pytest.raises(ValueError, match=r"rows\.csv: rows of unknown settings"):
        claim(tmp_path, 1, size, {})


def test_a_run_with_another_seed_says_why_it_stops(out: Path) -> None:
    command = [
        sys.executable,
        str(ROOT / "benchmarks/learners.py"),
        "--quick",
        "--seed",
        "2",
        "--out",
        str(out),
    ]
    finished = subprocess.run([*command, *ONLY], capture_output=True, text=True)
    assert finished.returncode == 1
    assert finished.stderr.startswith("learners.py: ")
    assert "with seed 1, and this run has 2" in finished.stderr
    assert "Traceback" not in finished.stderr


def test_an_entry_of_ones_own_takes_part(rooms: SimpleNamespace, monkeypatch: pytest.MonkeyPatch) -> None:
    settings: dict[str, Any] = {"n_estimators": 5}
    monkeypatch.setitem(
        LEARNERS, "forest", FromVectors("forest", RandomForestClassifier, settings, seeded=True)
    )
    size = rooms.rows.Size(1, (1, 2), (100,), (1_000,))
    forest = rooms.units.everyone()["forest"]
    assert rooms.units.told(forest) == "RandomForestClassifier(n_estimators=5)"
    (unit,) = rooms.units.plan({"forest": forest}, range(1), size, 0)
    rows = unit.run()
    assert {(row.amount, row.arena) for row in rows} == rooms.units.cells(forest, size)
    assert all(row.learner == "forest" and row.seconds > 0 for row in rows)


def test_whoever_needs_what_is_not_installed_is_left_out(rooms: SimpleNamespace) -> None:
    for learner in LEARNERS.values():
        fits = learner.needs is not Needs.STEPS or find_spec("stable_baselines3") is not None
        assert bool(rooms.units.left_out(learner)) is not fits


def test_backends_that_cannot_be_say_why(rooms: SimpleNamespace) -> None:
    unavailable = rooms.backends.unavailable
    assert unavailable("loky", None) == ""
    assert (
        unavailable("loky", "tcp://here:1")
        == "--address is 'tcp://here:1'; allowed: with --backend ray or dask"
    )
    for backend in ("ray", "dask"):
        missing = f"--backend {backend} needs the extra {backend}: pip install 'khepera-forage[{backend}]'"
        assert unavailable(backend, None) == ("" if find_spec(backend) else missing)


def test_tuning_compares_settings_over_other_seeds(rooms: SimpleNamespace, tmp_path: Path) -> None:
    quick("learners.py", tmp_path, "--tune", "--only", "dagger_tree", "--seeds", "1", "--jobs", "1")
    table = read(tmp_path / "tuning/table_tuning.csv")
    settings = [line["settings"] for line in table]
    assert settings[0] == rooms.units.told(LEARNERS["dagger_tree"])
    assert len(set(settings)) == len(settings) == 5
    best = [line for line in table if line["best"]]
    assert len(best) == 1
    assert float(best[0]["food delivered (%)"]) == max(float(line["food delivered (%)"]) for line in table)
    for line in table[1:]:
        more = float(line["food delivered (%)"]) - float(table[0]["food delivered (%)"])
        assert float(line["more (points)"]) == pytest.approx(more)
    assert table[0]["more (points)"] == ""
    seeds = {row["replication"] for row in read(tmp_path / "tuning/rows.csv")}
    assert seeds == {"1000"}
    page = (tmp_path / "tuning/tuning.md").read_text(encoding="utf-8")
    assert page.startswith("# Settings of the learners\n\n## What came out\n\n4 other settings were tried. ")
    assert (
        "    python benchmarks/learners.py --tune --only dagger_tree --seeds 1 --recalls 1 --seed 1 --quick\n"
        in page
    )


def test_the_page_leads_to_that_of_the_settings_if_there_is_one(out: Path, tmp_path: Path) -> None:
    assert "tuning/tuning.md" not in (out / "learners.md").read_text(encoding="utf-8")
    arguments = ["--only", "dagger_tree", "--seeds", "1", "--jobs", "1"]
    quick("learners.py", tmp_path, "--tune", *arguments)
    quick("learners.py", tmp_path, *arguments)
    page = (tmp_path / "learners.md").read_text(encoding="utf-8")
    assert "What came of it ([all settings](tuning/tuning.md)): 4 other settings were tried. " in page


def test_a_setting_that_is_clearly_better_is_named(rooms: SimpleNamespace) -> None:
    tried = rooms.tuning.candidates()

    def rows(name: str, more: int) -> list[Any]:
        # The replications differ by more than the settings do.
        return [
            replace(batch(rooms, name, 10, 900, delivered + more), replication=1_000 + number)
            for number, delivered in enumerate((1, 8, 3, 5, 1, 8))
        ]

    found = [*rows("tree", 0), *rows("tree.1", 1), *rows("tree.2", -1), *rows("tree.3", 0)]
    gains = rooms.tuning.differences(found, np.random.default_rng(0))
    for name, more in (("tree.1", 10), ("tree.2", -10), ("tree.3", 0)):
        assert tuple(gains[name]) == pytest.approx((more, more, more))
    text = rooms.tuning.reading(gains, tried)
    assert (
        "above 0: 1 (decision tree with `tree(min_samples_leaf=3)`, 10.0 [10.0, 10.0] points more)." in text
    )
    assert text.startswith("3 other settings were tried.")
    assert "Clearly less: 1." in text


def test_tuned_learners_have_as_many_settings_each(rooms: SimpleNamespace) -> None:
    tried = rooms.tuning.CANDIDATES
    needing = {name for name, learner in LEARNERS.items() if learner.needs is not Needs.STEPS}
    assert set(tried) == needing - {"imitator"}
    assert {len(changes) for changes in tried.values()} == {3}
    assert len({rooms.units.told(learner) for learner in rooms.tuning.candidates().values()}) == 5 * len(
        tried
    )


def test_contradictions_in_rows_are_found(rooms: SimpleNamespace) -> None:
    row = {"learner": "tree", "replication": 0, "amount": 1, "arena": "corridor", "steps": 90, "vectors": 90}
    row |= {"recalls": 2, "score": 50.0, "delivered": 1, "foods": 2, "recall_steps": 300, "seconds": 0.5}
    rooms.rows.Batch(**row)
    wrong = {
        "arena": "kitchen",
        "delivered": 3,
        "score": 101.0,
        "recalls": 0,
        "seconds": -1.0,
        "recall_steps": 1,
    }
    for name, value in wrong.items():
        with pytest.raises(ValueError, match=f"{name} is {value!r}; allowed: "):
            rooms.rows.Batch(**{**row, name: value})


def test_help_names_every_argument() -> None:
    told = help_of("learners.py")
    for argument in (
        "seed",
        "out",
        "quick",
        "seeds",
        "recalls",
        "steps",
        "only",
        "tune",
        "jobs",
        "backend",
        "address",
    ):
        assert f"--{argument}" in told
    assert all(name in told for name in LEARNERS)
