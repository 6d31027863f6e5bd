"""Rollouts of training and recall: experience files, attempts and rows."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience, ExperienceError
from khepera_forage.policies import NearestNeighbourImitator, Teacher
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import TEACHER, TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError, arrays, train
from khepera_forage.task.decisions import Decisions, decisions_text


def test_training_writes_the_experience_that_it_returns(tmp_path: Path) -> None:
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


def test_training_without_a_complete_attempt_is_an_error_and_leaves_no_file(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    attempts = Decisions().most_attempts
    with pytest.raises(IncompleteTrainingError, match=f"none of {attempts} attempts"):
        train(TrainingEnv(max_cycles=2), np.random.SeedSequence(0), path=path)
    assert not path.exists()


def test_attempt_whose_file_cannot_be_discarded_does_not_look_complete(tmp_path: Path) -> None:
    """As when the disk is unmounted for a moment, or the process is killed before the file is deleted."""
    folder, away = tmp_path / "experience", tmp_path / "away"
    folder.mkdir()

    def unmount(row: TrainingRow) -> None:
        assert row.reason == "out of time"
        folder.rename(away)

    with pytest.raises(FileNotFoundError, match=r"g1\.csv"):
        train(TrainingEnv(max_cycles=20), 1, path=folder / "g1.csv", on_attempt=unmount)
    with pytest.raises(ExperienceError, match="ends before its closing line: 20 complete rows"):
        Experience.load(away / "g1.csv")


def test_recall_counts_ties_of_an_imitator_and_none_of_a_teacher() -> None:
    env = recall_env("corridor")
    files = [train(TrainingEnv(), seed)[0] for seed in np.random.SeedSequence(2).spawn(3)]
    imitator = NearestNeighbourImitator(diagonal=env.diagonal).fit(*arrays(files))
    row = recall(env, imitator, 7)
    assert 0 < row.ties <= row.steps
    assert 0 <= row.conflicts <= row.ties
    teacher = recall(env, Teacher(), 7, learner=TEACHER, number=3)
    assert (teacher.ties, teacher.conflicts, teacher.score, teacher.recall) == (0, 0, 100.0, 3)
    assert (teacher.food_x, teacher.start_x) == (row.food_x, row.start_x), "the seed determines the places"


def test_rows_and_files_have_the_decisions_of_their_environment(tmp_path: Path) -> None:
    decisions = replace(Decisions.v0_1(), next_to_food=22, patience=50)
    path, text = tmp_path / "g1.csv", "v0.1;next_to_food=22;patience=50"
    experience, rows = train(TrainingEnv(decisions=decisions), np.random.SeedSequence(3), path=path)
    assert experience.decisions == decisions
    assert Experience.load(path, decisions=decisions) == experience
    assert {row.decisions for row in rows} == {text}
    env = recall_env("corridor", decisions=decisions)
    assert recall(env, Teacher.of(env), 1, learner=TEACHER).decisions == text
    row = recall(recall_env("corridor"), Teacher(), 1, learner=TEACHER)
    assert row.decisions == decisions_text(Decisions())
