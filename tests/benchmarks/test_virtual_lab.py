"""`benchmarks/virtual_lab.py`: both worlds, the parts of a round, and failures that the measurement must detect."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("serial")
pytest.importorskip("cv2")

from laboratory.observed_training import LEARNER, ObservedTraining, Truth, moving

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.virtual.faults import FAULTS, Faults
from khepera_forage.sim.world import Layout
from khepera_forage.task.states import Behaviour
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read
from tests.benchmarks.test_scripts import SCRIPTS

ROUNDS = 25


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("virtual_lab", *SCRIPTS["virtual_lab"].run)


def test_rounds_recover_or_end_the_episode_with_all_robots_stopped_and_no_experience_lost(out: Path) -> None:
    faults = {row["fault"]: row for row in read(out / "table_faults.csv")}
    assert list(faults) == ["none", *FAULTS]
    for fault, row in faults.items():
        disturbed = int(row["rounds disturbed"])
        assert int(row["rounds"]) == int(row["shown"]) == ROUNDS
        assert disturbed == 0 if fault == "none" else 0 < disturbed <= int(row["faults"])
        assert int(row["robots lost"]) == (disturbed if fault == "unplug" else 0)
        assert row["kept"] == row["robots lost"]
        assert (row["moving"], row["altered"]) == ("0", "0")
        if fault != "garble":
            assert row["unseen"] == row["misread"] == row["wrong"] == "0"
        if fault not in ("garble", "reset"):
            assert row["miscounted"] == "0"
    assert all("no answer to" in row["lost"] for row in read(out / "attempts.csv") if row["lost"])


def test_the_same_recalls_in_both_worlds(out: Path) -> None:
    rows = read(out / "recalls.csv")
    names = ("arena", "learner", "seed", "start_x", "food_x")
    pymunk, virtual = (
        [[row[name] for name in names] for row in rows if row["world"] == world]
        for world in ("pymunk", "virtual")
    )
    assert pymunk == virtual
    assert len(pymunk) == 4
    for row in rows:
        if (row["learner"], row["arena"]) == ("teacher", "corridor"):
            assert row["delivered"] == row["foods"]
    assert [row["rounds_by_state"] for row in rows[:4]] != [row["rounds_by_state"] for row in rows[4:]]


def test_the_comparison_is_that_of_the_rows(out: Path) -> None:
    for line in read(out / "table_recalls.csv"):
        if line["measure"] == "score (%)":
            pymunk, virtual = (
                float(row["score"])
                for row in read(out / "recalls.csv")
                if (row["arena"], row["learner"]) == (line["arena"], line["policy"])
            )
            assert float(line["pymunk alone"]) == pytest.approx(pymunk, rel=1e-4)
            assert float(line["difference"]) == pytest.approx(virtual - pymunk, rel=1e-4, abs=1e-4)


def test_parts_of_a_round_sum_up_to_the_round(out: Path) -> None:
    rows = read(out / "rounds.csv")
    parts = ("transmit", "simulate", "receive", "render", "track", "decide")
    for row in rows:
        assert float(row["busy"]) == pytest.approx(sum(float(row[part]) for part in parts))
        assert all(float(row[part]) > 0 for part in parts)
        if row["pace"] == "lock-step":
            assert float(row["wait"]) == 0
        else:
            # At least D,0,0 and N, T,1,G and H with their shortest replies, at 11 bits a byte.
            assert float(row["transmit"]) > 1000 * 11 * len("D,0,0\nd\r\n") / 38400 * 0.8
    in_time = [
        float(row["busy"]) + float(row["wait"])
        for row in rows
        if row["pace"] == "wall clock" and row["late"] == "0"
    ]
    assert np.mean(in_time) == pytest.approx(100, abs=25)


def test_a_robot_that_is_left_moving_is_detected() -> None:
    with virtual_laboratory("corridor", 2) as lab:
        lab.reset(np.random.default_rng(0), Layout(tuple(arena.start for arena in lab.arenas), ()))
        assert moving(lab) == set()
        lab.robots[1].drive(Motors(1, -1, 215, 200))
        lab.advance()
        assert moving(lab) == {1}
        lab.stop()
        assert moving(lab) == set()


def test_untrue_vectors_are_detected() -> None:
    with virtual_laboratory("corridor", 2) as lab:
        env = ObservedTraining(lab, faults=Faults())
        env.reset(seed=1)
        attempt = env.attempts[-1]

        def one_round(word: Behaviour) -> None:
            env.observe(TEACHER)
            env.step(word)
            env.observe(LEARNER)
            env.step(word)

        one_round(Behaviour.SEARCH_FOR_FOOD)
        assert (attempt.wrong, attempt.misread, attempt.miscounted) == ([False], 0, 0)
        one_round(Behaviour.GO_HOME)  # not what the teacher would call
        learner = env.foragers[1]
        learner.vector = learner.vector._replace(arms_height=learner.vector.arms_height + 1)
        one_round(Behaviour.SEARCH_FOR_FOOD)
        assert attempt.wrong == [False, True, True]


def test_readings_that_differ_from_the_body_are_detected() -> None:
    with virtual_laboratory("corridor", 2) as lab:
        env = TrainingEnv(world=lab, noise=Noise.none())
        env.reset(seed=1)
        truth, learner = Truth(lab, env.foragers), env.foragers[1]
        assert truth.end_round() == (False, False)
        right = learner.senses
        for wrong in ({"arm": 216}, {"object_presence": 255}, {"proximity": (1, *right.proximity[1:])}):
            learner.senses = right._replace(**wrong)
            assert truth.end_round() == (True, False)
        learner.senses = right._replace(left_pulses=right.left_pulses + 1)
        assert truth.end_round() == (False, True)
