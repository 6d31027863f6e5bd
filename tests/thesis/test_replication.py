"""Replications, baselines and the jobs of a reproduction, on both backends and under any decisions."""

from dataclasses import replace
from importlib import import_module
from typing import Any

import pytest

from khepera_forage import Noise
from khepera_forage.envs.backends import BACKENDS, COMPILED, PYMUNK
from khepera_forage.policies import Teacher
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.rows import IMITATOR, RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.study import Rows
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text
from khepera_forage.thesis import replication
from khepera_forage.thesis.design import LABORATORY, NO_LOSSES, NO_NOISE, THESIS, Cell, Subset
from khepera_forage.thesis.orient_analysis import PIXELS_BEYOND, OrientRow
from khepera_forage.thesis.replication import JobCounts, Row, UntrainedRow, comparison_counts, job_counts, jobs

V0_1 = Decisions.v0_1()
OTHER = replace(V0_1, next_to_food=22, food_to_home=200)
SMALL = (Cell("corridor", 2, (Subset((1,)), Subset((1, 2))), 2, foods=1, limit=500),)


def of_backend(backend: str) -> Any:
    """The module with the replications on a backend."""
    if backend == COMPILED:
        pytest.importorskip("numba")
    return import_module("khepera_forage.thesis." + ("replication" if backend == PYMUNK else "compiled_replications"))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("decisions", [DEFAULT_DECISIONS, V0_1, OTHER], ids=["default", "v0.1", "other"])
def test_replication_leaves_all_rows_of_its_cells(backend: str, decisions: Decisions) -> None:
    rows = Rows(of_backend(backend).replicate(5, 0, 2, LABORATORY, SMALL, decisions))
    recalls, trainings, orient = rows.of(RecallRow), rows.of(TrainingRow), rows.of(OrientRow)
    about = [(row.replication, row.file_id, row.recall) for row in recalls]
    assert about == [(n, files, number) for n in range(2) for files in ("g1", "g12") for number in range(2)]
    common = [(row.arena, row.episodes, row.learner, row.noise, row.foods, row.limit) for row in recalls]
    assert set(common) == {("corridor", 2, IMITATOR, LABORATORY, 1, 500)}
    assert len({row.seed for row in recalls}) == len(recalls)
    everything: list[Row] = [*recalls, *trainings, *orient]
    assert {row.decisions for row in everything} == {decisions_text(decisions)}
    places = [(row.replication, row.episodes, row.file_id, row.beyond) for row in orient]
    assert places == [(n, 2, files, at) for n in range(2) for files in ("g1", "g12") for at in PIXELS_BEYOND]
    attempts = [(row.replication, row.file) for row in trainings if row.complete]
    assert attempts == [(n, file) for n in range(2) for file in (1, 2)]
    assert all(row.attempt == 1 or trainings[i - 1].attempt == row.attempt - 1 for i, row in enumerate(trainings))
    for number in range(2):
        complete = [row.vectors for row in trainings if row.complete and row.replication == number]
        sizes = [row.experience_size for row in recalls if row.replication == number]
        assert len(complete) == 2
        assert sizes == [complete[0]] * 2 + [sum(complete)] * 2


@pytest.mark.parametrize("backend", BACKENDS)
def test_replication_depends_only_on_seed_and_number(backend: str) -> None:
    made = of_backend(backend)
    one, again, other = (Rows(made.replicate(seed, 0, 2, cells=SMALL)).of(RecallRow) for seed in (5, 5, 6))
    assert one == again
    assert one[:4] != other[:4]
    assert [row.score for row in one[:4]] != [row.score for row in one[4:]]


def test_replication_without_cells_trains_all_files() -> None:
    rows = Rows(replication.replicate(0, 0, 1, NO_LOSSES, cells=()))
    assert not rows.of(RecallRow)
    assert {row.noise for row in rows.of(TrainingRow)} == {"no losses"}
    assert {row.file for row in rows.of(TrainingRow)} == set(range(1, 11))


@pytest.mark.parametrize("backend", BACKENDS)
def test_replication_that_cannot_be_trained_leaves_a_row(backend: str) -> None:
    """A robot that backs off before it is near enough to orient hovers in every attempt."""
    hovering = replace(DEFAULT_DECISIONS, back_off_distance=17.0, most_attempts=2)
    reason = "none of 2 attempts at a training episode was complete"
    rows = of_backend(backend).replicate(0, 0, 1, NO_NOISE, SMALL, hovering)
    assert rows == [UntrainedRow(0, 1, NO_NOISE, reason, decisions_text(hovering))]


def test_seed_of_a_compiled_training_reproduces_it() -> None:
    """With the learner of that seed, whatever its number in the group."""
    rows = Rows(of_backend(COMPILED).replicate(5, 0, 3, LABORATORY, SMALL)).of(TrainingRow)
    train_learners = import_module("khepera_forage.rollouts.compiled.training").train_learners
    own = [row for row in rows if row.replication == 2]
    again = train_learners(1, seed=own[0].seed, episodes=2).attempts
    assert [(row.rounds, row.vectors, row.reason) for row in own] == [
        *zip(again.rounds, again.vectors, again.reason, strict=True)
    ]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("learner", "limit"), [(TEACHER, 1500), (RANDOM, 500)])
def test_baseline_of_the_teacher_has_three_times_the_limit(backend: str, learner: str, limit: int) -> None:
    rows = Rows(of_backend(backend).baselines(0, 0, 2, learner, "corridor", 3, OTHER)).of(RecallRow)
    assert {(row.limit, row.decisions) for row in rows} == {(limit, decisions_text(OTHER))}
    assert [(row.replication, row.recall) for row in rows] == [(block, i) for block in (0, 1) for i in range(3)]
    assert {(row.learner, row.episodes, row.file_id, row.noise) for row in rows} == {(learner, 0, "-", LABORATORY)}
    if learner == TEACHER:
        assert {(row.score, row.delivered) for row in rows} == {(100.0, 1)}, "under the same decisions"
        env = recall_env("corridor", limit=limit, decisions=OTHER, backend=backend)
        for row in rows:
            about: dict[str, Any] = {"learner": TEACHER, "replication": row.replication, "number": row.recall}
            assert row == recall(env, Teacher.of(env), row.seed, **about), "every column"


def test_jobs_contain_the_whole_design() -> None:
    made = jobs(0, job_counts(6, PYMUNK), DEFAULT_DECISIONS, PYMUNK)
    replications = [job.arguments[1:5] for job in made if job.function is replication.replicate]
    assert [cells for _, _, noise, cells in replications if noise == "laboratory"] == [THESIS] * 6
    conditions = {noise for _, _, noise, _ in replications}
    assert {"none", "only wheels", "only camera jitter", "no losses"} <= conditions
    assert [(first, count) for first, count, noise, _ in replications if noise == "no losses"] == [
        (number, 1) for number in range(6)
    ]
    assert sum(job.function is replication.baselines and job.arguments[3] == TEACHER for job in made) == 40
    assert len({job.key for job in made}) == len(made)
    pytest.importorskip("numba")
    groups = jobs(3, JobCounts(250), V0_1, COMPILED)
    assert [job.arguments[1:3] for job in groups] == [(0, 100), (100, 100), (200, 50)]


@pytest.mark.parametrize(("replications", "expected"), [(1, 1), (2, 2), (24, 5), (1000, 200)])
def test_comparison_has_a_share_of_the_replications(replications: int, expected: int) -> None:
    made = jobs(0, comparison_counts(replications), V0_1, PYMUNK)
    about = LABORATORY, THESIS, V0_1, Noise.laboratory()
    assert [job.arguments for job in made] == [(0, i, 1, *about) for i in range(expected)]
