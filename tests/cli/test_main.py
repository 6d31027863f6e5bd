"""The `khepera-forage` command and its subcommands for simulations."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from khepera_forage.cli.main import COMMANDS, main
from khepera_forage.experience import Experience
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from tests.cli.running import Run
from tests.limited_disk import largest_file


@pytest.fixture(scope="module")
def experience(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("experience")
    assert main(["train", "--episodes", "2", "--out", str(folder)]) == 0
    (folder / "g1.lost-1.csv").write_text("not to be read")
    return folder


def recalled(run: Run, arguments: str) -> list[RecallRow]:
    assert "mean score" in run(f"recall --episodes 2 --out rows.csv {arguments}")
    return read_rows(Path("rows.csv"), RecallRow)


def test_train_recall_and_watch_work_together(experience: Path, run: Run) -> None:
    assert len(read_rows(experience / "attempts.csv", TrainingRow)) >= 2
    rows = recalled(run, f"--experience {experience}")
    assert [(row.learner, row.recall) for row in rows] == [("imitator", 0), ("imitator", 1)]
    assert recalled(run, f"--experience {experience}/g1.csv {experience}/g2.csv") == rows
    run(f"watch recall --experience {experience} --out film.gif --every 100")
    assert Path("film.gif").read_bytes().startswith(b"GIF")
    # The first attempt of this seed fails.
    first, *_, last, frames = run("watch training --seed 6 --every 100 --out film.mp4").splitlines()
    assert Path("film.mp4").read_bytes()[4:8] == b"ftyp"
    assert first == "attempt 1: out of time after 600 rounds, not filmed"
    rounds = int(last.removeprefix("complete after ").removesuffix(" rounds"))
    assert frames.endswith(f": {-(-rounds // 100) + 1} frames"), "the last one shows how it ended"
    assert sorted(path.name for path in Path().glob("*film*")) == ["film.gif", "film.mp4"]


def test_recall_tells_a_learner_which_vectors_are_of_one_episode(experience: Path, run: Run) -> None:
    Path("grouped.py").write_text(
        "from collections import Counter\n"
        "from sklearn.tree import DecisionTreeClassifier\n"
        "from khepera_forage.policies.learners import OfflineImitation\n"
        "class Counting(DecisionTreeClassifier):\n"
        "    def fit(self, X, y, groups):\n"
        "        print(list(Counter(groups.tolist()).values()))\n"
        "        return super().fit(X, y)\n"
        "counting = OfflineImitation('counting', Counting, grouped=True)\n"
    )
    printed = run(f"recall --episodes 1 --out rows.csv --experience {experience} --learner grouped:counting")
    sizes = [len(Experience.load(experience / f"g{number}.csv")) for number in (1, 2)]
    assert f"{sizes}\n" in printed


def test_recall_with_another_learner_noise_and_food(experience: Path, run: Run) -> None:
    rows = recalled(run, f"--experience {experience} --learner tree")
    assert {(row.learner, row.noise) for row in rows} == {("tree", "laboratory")}
    assert rows != recalled(run, f"--experience {experience}")
    rows = recalled(run, "--foods 3 --noise none --arena rectangle")
    assert {(row.learner, row.noise, row.foods) for row in rows} == {("teacher", "none", 3)}
    assert recalled(run, "--noise placement") != recalled(run, "--noise 'wheels,tracking losses'")
    run("watch recall --noise none --foods 2 --every 50 --out new/f.gif")


def test_attempts_are_written_even_if_none_is_complete(run: Run) -> None:
    hopeless = "--decision next_to_food=12 --decision most_attempts=3"
    assert "none of 3 attempts" in run.refused(f"train --episodes 1 --out g {hopeless}")
    rows = read_rows(Path("g/attempts.csv"), TrainingRow)
    assert [(row.attempt, row.complete) for row in rows] == [(1, False), (2, False), (3, False)]
    assert [path.name for path in Path("g").iterdir()] == ["attempts.csv"]


def test_installed_command_prints_its_version() -> None:
    command = Path(sys.executable).with_name("khepera-forage")
    done = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("khepera-forage 0.")


@pytest.mark.parametrize("command", COMMANDS)
def test_help_fits_in_eighty_columns(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main([command, "--help"])
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


TRAIN = "train --seed 3 --out"


def test_interrupted_training_is_continued_with_the_same_result(run: Run) -> None:
    whole, part = Path("whole"), Path("part")
    run(f"{TRAIN} whole --episodes 3")
    run(f"{TRAIN} part --episodes 2")
    lines = (part / "g2.csv").read_text().splitlines(keepends=True)
    (part / "g2.csv").write_text("".join(lines[:-3]))  # as a kill in the second episode leaves it
    os.truncate(part / "attempts.csv", (part / "attempts.csv").stat().st_size - 20)
    assert "g1.csv exists; --continue goes on after it" in run.refused(f"{TRAIN} part --episodes 3")
    assert "g2.csv was interrupted" in run(f"{TRAIN} part --episodes 3 --continue")
    for name in ("g1.csv", "g2.csv", "g3.csv", "attempts.csv"):
        assert (part / name).read_bytes() == (whole / name).read_bytes()
    assert "all 3 files are in" in run(f"{TRAIN} part --episodes 3 --continue")
    recall = "recall --episodes 1 --out r.csv --experience part/g2.interrupted-1.csv"
    assert "--recover" in run.refused(recall)
    assert "rows kept" in run(f"{recall} --recover")


def test_continued_training_names_complete_episodes_without_a_row(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    run(f"{TRAIN} . --episodes 3")
    lines = Path("attempts.csv").read_text().splitlines(keepends=True)
    Path("attempts.csv").write_text("".join(lines[:2]))  # a row of the first episode
    for episodes in (4, 4):  # and when all files are there
        assert main(f"{TRAIN} . --episodes {episodes} --continue".split()) == 0
        assert capsys.readouterr().err == "attempts.csv has no row of the complete episodes 2, 3\n"
    Path("attempts.csv").unlink()
    assert main(f"{TRAIN} . --episodes 5 --continue".split()) == 0
    assert capsys.readouterr().err == "attempts.csv has no row of the complete episodes 1, 2, 3, 4\n"


def test_training_beside_another_run_ends_with_what_is_allowed(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    run(f"{TRAIN} part --episodes 1")
    monkeypatch.setattr("khepera_forage.cli.train.require_new", lambda *_: None)  # as if the other run began later
    allowed = "--out is 'part', where another run writes; allowed: another one, or --continue after that run has ended"
    assert allowed in run.refused(f"{TRAIN} part --episodes 1")


def test_full_disk_ends_training_with_what_to_do_and_is_continued(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    whole, part = Path("whole"), Path("part")
    run(f"{TRAIN} whole --episodes 2")
    size = (whole / "g1.csv").stat().st_size
    with largest_file(size - 10):  # not even the first episode fits
        assert main(f"{TRAIN} part --episodes 2".split()) == 2
    assert capsys.readouterr().err == (
        "the same command with --continue goes on from here\n"
        f"khepera-forage train: [Errno 28] No space left on device: '{part / 'g1.csv'}'\n"
    )
    stored = (part / "g1.csv").read_bytes()
    assert (whole / "g1.csv").read_bytes().startswith(stored)
    run(f"{TRAIN} part --episodes 2 --continue")
    assert (part / "g1.interrupted-1.csv").read_bytes() == stored
    for name in ("g1.csv", "g2.csv", "attempts.csv"):
        assert (part / name).read_bytes() == (whole / name).read_bytes()


def test_training_of_another_seed_arena_or_decisions_is_not_continued_and_nothing_is_changed(run: Run) -> None:
    run(f"{TRAIN} . --episodes 2")
    run("train --seed 2 --episodes 2 --out other")
    Path("other/g2.csv").replace("g2.csv")
    lines = Path("g1.csv").read_text().splitlines(keepends=True)
    Path("g1.csv").write_text("".join(lines[:-2]))  # interrupted
    before = {path.name: path.read_bytes() for path in Path().glob("*.csv")}
    for option, message in (
        ("", "g2.csv is of another --seed; allowed with --continue: the same one"),
        ("--decision search_speed=10", "search_speed"),
        ("--arena rectangle", "arena is 'corridor'; allowed: 'rectangle'"),
    ):
        assert message in run.refused(f"{TRAIN} . --episodes 3 --continue {option}")
    Path("g2.csv").unlink()  # so that the folder is of one seed
    before["attempts.csv"] = before["attempts.csv"].replace(b"rounds", b"round")
    del before["g2.csv"]
    Path("attempts.csv").write_bytes(before["attempts.csv"])
    assert "attempts.csv:1: header is" in run.refused(f"{TRAIN} . --episodes 3 --continue")
    assert {path.name: path.read_bytes() for path in Path().glob("*.csv")} == before


def test_interrupt_ends_in_one_line_even_while_modules_are_imported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(name: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("khepera_forage.cli.main.import_module", interrupted)
    assert main(["robot", "probe"]) == 130
    assert capsys.readouterr().err == "stopped\n"
