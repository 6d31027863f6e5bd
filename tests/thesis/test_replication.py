"""Replications, baselines and the jobs of a reproduction, on pymunk."""

from khepera_forage.envs.backends import PYMUNK
from khepera_forage.rollouts.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.study import Rows
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.thesis.design import NO_LOSSES, THESIS, Cell, Subset
from khepera_forage.thesis.replication import baseline, job_counts, pymunk_jobs, replicate

SMALL = (Cell("corridor", 2, (Subset((1, 2)),), 2, foods=1, limit=500),)


def test_replication_depends_only_on_seed_and_number() -> None:
    first, second = (replicate(5, 2, cells=SMALL) for _ in range(2))
    assert first == second
    assert first != replicate(5, 3, cells=SMALL)
    rows = Rows(first)
    assert [row.file_id for row in rows.of(RecallRow)] == ["g12", "g12"]
    assert len({row.file for row in rows.of(TrainingRow)}) == 2
    assert {row.experience_size for row in rows.of(RecallRow)} == {
        sum(row.vectors for row in rows.of(TrainingRow) if row.complete)
    }


def test_replication_without_cells_trains_all_files() -> None:
    outcome = Rows(replicate(0, 0, NO_LOSSES, cells=()))
    assert not outcome.of(RecallRow)
    assert {row.noise for row in outcome.of(TrainingRow)} == {"no losses"}
    assert {row.file for row in outcome.of(TrainingRow)} == set(range(1, 11))


def test_baseline_of_the_teacher_has_three_times_the_limit() -> None:
    rows = Rows(baseline(0, 0, TEACHER, "corridor", 3)).of(RecallRow)
    assert [row.delivered for row in rows] == [1, 1, 1]
    assert {row.limit for row in rows} == {1500}
    chance = Rows(baseline(0, 0, RANDOM, "corridor", 1)).of(RecallRow)
    assert {row.limit for row in chance} == {500}


def test_jobs_contain_the_whole_design() -> None:
    jobs = pymunk_jobs(0, job_counts(6, PYMUNK), DEFAULT_DECISIONS)
    replications = [job.arguments for job in jobs if job.function is replicate]
    designs = [cells for _, _, noise, cells, _ in replications if noise == "laboratory"]
    assert designs == [THESIS] * 6
    conditions = {noise for _, _, noise, _, _ in replications}
    assert {"none", "only wheels", "only camera jitter", "no losses"} <= conditions
    assert sum(job.function is baseline and job.arguments[2] == TEACHER for job in jobs) == 40
    assert len({job.key for job in jobs}) == len(jobs)
