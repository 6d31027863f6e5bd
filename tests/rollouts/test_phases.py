"""Training and recall as functions, with files and rows."""

import signal
import threading
from pathlib import Path
from typing import IO, Any

import numpy as np
import pytest

from khepera_forage import experience as experience_module
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.envs.training_episode import MAX_ATTEMPTS
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Teacher
from khepera_forage.rollouts.interrupts import interrupts_held
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import RANDOM, TEACHER
from khepera_forage.rollouts.training import HopelessTraining, arrays, train
from khepera_forage.thesis.design import THESIS, Cell, Subset
from khepera_forage.thesis.plan import PYMUNK, amounts, plan
from khepera_forage.thesis.replication import Attempts, Baseline, Replication

SMALL = (Cell("corridor", 2, (Subset((1, 2)),), 2, foods=1, limit=500),)


def test_experience_is_written_as_it_happens_and_equals_what_is_returned(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    env = TrainingEnv()
    experience, rows = train(env, np.random.SeedSequence(3), path=path)
    assert Experience.load(path) == experience
    assert len(experience) == rows[-1].vectors
    assert rows[-1].complete
    assert {row.complete for row in rows[:-1]} <= {False}
    again, _ = train(env, np.random.SeedSequence(3))
    assert again == experience
    with pytest.raises(FileExistsError, match=r"g1\.csv"):
        train(env, np.random.SeedSequence(3), path=path)


def test_incomplete_attempts_are_forgotten_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    with pytest.raises(HopelessTraining, match=str(MAX_ATTEMPTS)):
        train(TrainingEnv(max_cycles=2), np.random.SeedSequence(0), path=path)
    assert not path.exists()


def test_an_interrupt_while_the_file_is_opened_leaves_none_and_closes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[IO[Any]] = []

    def interrupted(*args: Any, **keywords: Any) -> IO[Any]:
        file: IO[Any] = open(*args, **keywords)  # noqa: SIM115 - whether it is closed is what is asked here
        opened.append(file)
        signal.raise_signal(signal.SIGINT)
        return file

    monkeypatch.setattr(experience_module, "open", interrupted, raising=False)
    with pytest.raises(KeyboardInterrupt):
        train(TrainingEnv(), np.random.SeedSequence(0), path=tmp_path / "g1.csv")
    assert [file.closed for file in opened] == [True]
    assert list(tmp_path.iterdir()) == []


def test_held_interrupts_come_at_the_end_in_the_main_thread() -> None:
    done: list[str] = []

    def interrupted() -> None:
        with interrupts_held():
            signal.raise_signal(signal.SIGINT)
            done.append("what came after it")

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert done
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler

    def elsewhere() -> None:
        with interrupts_held():
            seen.append(signal.getsignal(signal.SIGINT))

    seen: list[object] = []
    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert seen == [signal.default_int_handler]


def test_files_combine_as_in_the_thesis() -> None:
    env = TrainingEnv()
    files = [train(env, seed)[0] for seed in np.random.SeedSequence(1).spawn(2)]
    vectors, behaviours = arrays(files)
    assert len(vectors) == len(behaviours) == sum(map(len, files))
    assert (files[0] + files[1]).arrays()[0].tolist() == vectors.tolist()


def test_a_replication_is_the_same_whoever_runs_it() -> None:
    first, second = (Replication(5, 2, cells=SMALL).run() for _ in range(2))
    assert first == second
    assert first != Replication(5, 3, cells=SMALL).run()
    assert [row.file_id for row in first.recalls] == ["g12", "g12"]
    assert len({row.file for row in first.trainings}) == 2
    assert {row.experience_size for row in first.recalls} == {
        sum(row.vectors for row in first.trainings if row.complete)
    }


def test_recall_counts_ties_of_an_imitator_and_none_of_a_teacher() -> None:
    env = recall_env("corridor")
    files = [train(TrainingEnv(), seed)[0] for seed in np.random.SeedSequence(2).spawn(3)]
    imitator = NearestNeighbourImitator(diagonal=env.diagonal).fit(*arrays(files))
    row = recall(env, imitator, 7)
    assert 0 < row.ties <= row.steps
    assert 0 <= row.conflicts <= row.ties
    teacher = recall(env, Teacher(), 7, learner=TEACHER)
    assert (teacher.ties, teacher.conflicts, teacher.score) == (0, 0, 100.0)
    assert (teacher.food_x, teacher.start_x) == (row.food_x, row.start_x), "one seed, one placement"


def test_baselines_and_attempts() -> None:
    rows = Baseline(0, 0, TEACHER, "corridor", 3).run().recalls
    assert [row.delivered for row in rows] == [1, 1, 1]
    assert {row.limit for row in rows} == {1500}
    chance = Baseline(0, 0, RANDOM, "corridor", 1).run().recalls
    assert {row.limit for row in chance} == {500}
    tries = Attempts(0, 0).run()
    assert not tries.recalls
    assert {row.noise for row in tries.trainings} == {"no losses"}
    assert {row.file for row in tries.trainings} == set(range(1, 11))


def test_the_plan_holds_the_whole_design() -> None:
    work = plan(0, amounts(6, PYMUNK))
    designs = [piece for piece in work if isinstance(piece, Replication) and piece.noise == "laboratory"]
    assert len(designs) == 6
    assert all(piece.cells == THESIS for piece in designs)
    conditions = {piece.noise for piece in work if isinstance(piece, Replication)}
    assert {"none", "only wheels", "only camera jitter", "no losses"} <= conditions
    assert sum(isinstance(piece, Baseline) and piece.learner == TEACHER for piece in work) == 40


def test_recall_under_a_noise_condition_uses_it() -> None:
    env = recall_env("rectangle", Noise.none())
    assert recall(env, Teacher(), 1, learner=TEACHER, noise="none").noise == "none"
    assert env.limit == 700
