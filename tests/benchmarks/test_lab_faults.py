"""`benchmarks/lab_faults.py`: after every fault the robots stand, the experience is right, and training goes on."""

import numpy as np
import pytest

pytest.importorskip("serial")
pytest.importorskip("cv2")

from lab_faults import KINDS, LEARNER, ObservedTraining, moving

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TEACHER
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.world import Layout
from khepera_forage.task.states import Behaviour
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read


def test_after_every_fault_robots_stand_experience_is_right_and_training_goes_on(quick_run: QuickRun) -> None:
    out = quick_run("lab_faults")
    faults = read(out / "faults.csv")
    assert [row["kind"] for row in faults] == [kind.name for kind in KINDS[::3]]
    assert {row["part"] for row in faults} == {"robot", "camera"}
    assert {row["outcome"] for row in faults} == {"recovered", "attempt lost"}
    for row in faults:
        assert int(row["vectors"]) > 0
        for name in ("moving", "out_of_reach", "missing", "altered", "wrong", "outdated"):
            assert row[name] == "0", (name, row)
        if row["outcome"] != "recovered":
            assert (row["notices"], row["named"]) == ("1", "1"), row
    for line, row in zip(read(out / "table_faults.csv"), faults, strict=True):
        wanted = {name: str(int(name == row["outcome"])) for name in ("recovered", "attempt lost")}
        wanted |= {"part": row["part"], "moving": "0", "out of reach": "0", "vectors": row["vectors"]}
        assert {name: line[name] for name in wanted} == wanted
        assert (line["fault"], line["faulty vectors"]) == (row["kind"], "0")
        assert float(line["until noticed (s)"]) == pytest.approx(float(row["seconds"]), rel=1e-4)
        assert float(line["wheels unattended (s)"]) == pytest.approx(float(row["unattended"]), rel=1e-4)


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
        env = ObservedTraining(lab)
        env.reset(seed=1)

        def one_round(word: Behaviour) -> None:
            env.observe(TEACHER)
            env.step(word)
            env.observe(LEARNER)
            env.step(word)

        one_round(Behaviour.SEARCH_FOR_FOOD)
        learner = env.foragers[1]
        learner.vector = learner.vector._replace(arms_height=learner.vector.arms_height + 1)
        one_round(Behaviour.SEARCH_FOR_FOOD)
        assert env.wrong == [False, True]
        assert len(env.perceived[1]) == 2
