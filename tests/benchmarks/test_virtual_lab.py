"""`benchmarks/virtual_lab.py`: both worlds, the parts of a round, and failures that the measurement must detect."""

from pathlib import Path

import numpy as np
import pytest
from lab_comparison.episodes import LabRecall, LabTraining
from lab_comparison.observed_training import LEARNER, ObservedTraining, moving
from lab_comparison.truth import RoundFailures, Truth

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.virtual.faults import FAULTS, Faults
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.sim.world import Layout
from khepera_forage.task.states import Behaviour
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read
from tests.benchmarks.test_scripts import SCRIPTS

pytest.importorskip("serial")
pytest.importorskip("cv2")

ROUNDS = 25
WORLDS = ("pymunk", "virtual")
RATES = ("0.1", "1", "5")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("virtual_lab", *SCRIPTS["virtual_lab"].run)


@pytest.fixture(scope="module")
def faults(out: Path) -> dict[tuple[str, str], dict[str, str]]:
    """Both fault tables, by fault and rate."""
    rounds, experience = read(out / "table_faults.csv"), read(out / "table_experience.csv")
    assert [(row["fault"], row["rate (%)"]) for row in rounds] == [
        (row["fault"], row["rate (%)"]) for row in experience
    ]
    return {
        (one["fault"], one["rate (%)"]): {**one, **other}
        for one, other in zip(rounds, experience, strict=True)
    }


def recalls_of(out: Path) -> dict[str, list[LabRecall]]:
    rows = read_rows(out / "recalls.csv", LabRecall)
    return {world: [row for row in rows if row.world == world] for world in WORLDS}


def test_every_fault_at_every_rate(faults: dict[tuple[str, str], dict[str, str]]) -> None:
    assert list(faults) == [("none", "0"), *((fault, rate) for fault in FAULTS for rate in RATES)]
    for (fault, rate), row in faults.items():
        assert int(row["rounds"]) == ROUNDS
        assert int(row["rounds disturbed"]) <= min(ROUNDS, int(row["faults"]))
        if fault == "none":
            assert int(row["faults"]) == 0
        if rate == "5":
            assert int(row["faults"]) > 0
            assert int(row["rounds disturbed"]) > 0


def test_rounds_recover_or_end_the_episode_with_all_robots_stopped(
    faults: dict[tuple[str, str], dict[str, str]],
) -> None:
    for (fault, _), row in faults.items():
        lost = int(row["robots lost"])
        assert int(row["recovered"]) == int(row["rounds disturbed"]) - lost
        assert lost == (int(row["rounds disturbed"]) if fault == "unplug" else 0)
        assert int(row["moving"]) == 0


def test_no_experience_is_lost_or_wrong(faults: dict[tuple[str, str], dict[str, str]]) -> None:
    for (fault, _), row in faults.items():
        assert int(row["shown"]) == int(row["on disk"]) + int(row["forgotten"])
        assert 0 < int(row["shown"]) <= ROUNDS
        assert int(row["altered"]) == 0
        assert int(row["files kept of them"]) == int(row["episodes interrupted"])
        if fault != "garble":
            assert int(row["unseen"]) == int(row["misread"]) == int(row["wrong"]) == 0
        if fault not in ("garble", "reset"):
            assert int(row["miscounted"]) == 0


def test_the_tables_are_sums_of_the_rows(out: Path, faults: dict[tuple[str, str], dict[str, str]]) -> None:
    rows = read(out / "attempts.csv")
    names = {"rounds": "rounds", "faults": "faults", "vectors": "shown", "moving": "moving", "wrong": "wrong"}
    for (fault, rate), line in faults.items():
        own = [
            row
            for row in rows
            if row["fault"] == fault and float(row["rate"]) == pytest.approx(float(rate) / 100)
        ]
        for name, column in names.items():
            assert sum(int(row[name]) for row in own) == int(line[column])
        assert sum(bool(row["lost"]) for row in own) == int(line["robots lost"])
        for row in own:
            assert "no answer to" in row["lost"] if row["lost"] else True


def test_the_same_trainings_and_recalls_in_both_worlds(out: Path) -> None:
    recalls = recalls_of(out)
    attempts = read_rows(out / "trainings.csv", LabTraining)
    trainings = {world: [row for row in attempts if row.world == world] for world in WORLDS}
    places = [
        [(row.arena, row.learner, row.seed, row.start_x, row.food_x) for row in rows]
        for rows in recalls.values()
    ]
    assert places[0] == places[1]
    assert {(row.arena, row.learner) for row in recalls["virtual"]} == {
        (arena, learner) for arena in ("corridor", "rectangle") for learner in ("teacher", "imitator")
    }
    for world in WORLDS:
        assert trainings[world][-1].complete
        learned = sum(row.vectors for row in trainings[world] if row.complete)
        for row in recalls[world]:
            assert row.experience_size == (learned if row.learner == "imitator" else 0)
            if row.learner == "teacher":
                assert row.delivered == row.foods
                assert row.score == 100
    assert [r.rounds_by_state for r in recalls["pymunk"]] != [r.rounds_by_state for r in recalls["virtual"]]


def test_the_comparison_is_that_of_the_rows(out: Path) -> None:
    recalls = recalls_of(out)
    names = {"pymunk": "pymunk alone", "virtual": "virtual laboratory"}
    lines = [row for row in read(out / "table_recalls.csv") if row["measure"] == "score (%)"]
    assert len(lines) == 4
    for line in lines:
        means = {}
        for world in WORLDS:
            own = [r for r in recalls[world] if (r.arena, r.learner) == (line["arena"], line["policy"])]
            means[world] = np.mean([row.score for row in own])
            assert float(line[names[world]]) == pytest.approx(means[world], rel=1e-4)
        assert float(line["difference"]) == pytest.approx(
            means["virtual"] - means["pymunk"], rel=1e-4, abs=1e-4
        )


def test_parts_of_a_round(out: Path) -> None:
    rows = read(out / "rounds.csv")
    parts = ("transmit", "wait", "simulate", "receive", "render", "track", "decide")
    lock_step, paced = ([row for row in rows if row["pace"] == pace] for pace in ("lock-step", "wall clock"))
    assert len(lock_step) > len(paced) > 20
    assert all(float(row[part]) > 0 for row in rows for part in parts if part != "wait")
    assert all(float(row["wait"]) == 0 and row["late"] == "0" for row in lock_step)
    for row in paced:
        # At least D,0,0 and N, T,1,G and H with their shortest replies, at 11 bits a byte.
        assert float(row["transmit"]) > 1000 * 11 * len("D,0,0\nd\r\n") / 38400 * 0.8
        assert (
            float(row["receive"])
            > 1000 * 11 * len("N\nT,1,G\nH\n" + 18 * "0" + 8 * "0" + 7 * "0") / 38400 * 0.8
        )
    in_time = [sum(float(row[part]) for part in parts) for row in paced if row["late"] == "0"]
    assert np.mean(in_time) == pytest.approx(100, abs=25)


def test_a_robot_that_is_left_moving_is_detected() -> None:
    with virtual_laboratory("corridor", 2) as lab:
        arenas = lab.arenas
        lab.reset(np.random.default_rng(0), Layout(tuple(a.start for a in arenas), ()))
        assert moving(lab) == 0
        lab.robots[1].drive(Motors(1, -1, 215, 200))
        lab.advance()
        assert moving(lab) == 1
        lab.stop()
        assert moving(lab) == 0


def test_untrue_vectors_are_detected() -> None:
    with virtual_laboratory("corridor", 2) as lab:
        env = ObservedTraining(lab, Faults())
        env.reset(seed=1)
        record = env.records[-1]

        def one_round(word: Behaviour) -> None:
            env.observe(TEACHER)
            env.step(word)
            env.observe(LEARNER)
            env.step(word)

        one_round(Behaviour.SEARCH_FOR_FOOD)
        assert (len(record.heard), record.wrong, record.misread, record.miscounted, record.halted) == (
            1,
            0,
            0,
            0,
            0,
        )
        one_round(Behaviour.GO_HOME)  # not what the teacher would call
        assert record.wrong == 1
        learner = env.foragers[1]
        learner.vector = learner.vector._replace(arms_height=learner.vector.arms_height + 1)
        one_round(Behaviour.SEARCH_FOR_FOOD)
        assert record.wrong == 2


def test_readings_that_differ_from_the_body_are_detected() -> None:
    with virtual_laboratory("corridor", 2) as lab:
        env = TrainingEnv(world=lab, noise=Noise.none())
        env.reset(seed=1)
        truth, learner = Truth(lab, env.foragers), env.foragers[1]
        assert truth.end_round() == RoundFailures(halted=False, misread=False, miscounted=False)
        right = learner.senses
        for wrong in ({"arm": 216}, {"object_presence": 255}, {"proximity": (1, *right.proximity[1:])}):
            learner.senses = right._replace(**wrong)
            assert truth.end_round() == RoundFailures(halted=False, misread=True, miscounted=False)
        learner.senses = right._replace(left_pulses=right.left_pulses + 1)
        assert truth.end_round() == RoundFailures(halted=False, misread=False, miscounted=True)
        learner.applied = Motors(1, 0, 215, 200)
        assert truth.end_round() == RoundFailures(halted=True, misread=False, miscounted=False)
