"""A laboratory: requests to the operator, checks by camera, pause and resume, and food positions."""

import math
import time

import numpy as np
import pytest

from khepera_forage.lab.operator import OperatorGaveUp, OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.arena import Point, Pose
from tests.lab.laboratories import LAYOUT, ClumsyOperator, drive_all, is_stopped, moved, quiet_laboratory

cv2 = pytest.importorskip("cv2")


def test_reset_repeats_the_request_until_the_check_succeeds() -> None:
    operator = ClumsyOperator(
        lambda request: moved(request, 1, dy=30),
        lambda request: request._replace(foods=(request.foods or ())[:1]),
        lambda request: moved(request, 0, degrees=170),
    )
    with quiet_laboratory(operator) as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        errors = [request.errors for request in operator.requests]
        assert errors == [
            (),
            ("robot learner_0 stands at (90, 445) mm, 30 mm off its mark",),
            ("no food is seen at (370, 415) mm",),
            ("robot teacher is turned 170 degrees too far to the left",),
        ]
        assert all(request.robots[0].name == "teacher" for request in operator.requests)
        for pose, start in zip(lab.poses(), LAYOUT.starts, strict=True):
            assert math.dist(pose[:2], start[:2]) < 3


def test_repeated_errors_end_with_the_operator_giving_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("khepera_forage.lab.laboratory.CHECK_ROUNDS", 3)

    def always(request: OperatorRequest) -> OperatorRequest:
        return moved(request, 0, dx=40)

    with (
        quiet_laboratory(ClumsyOperator(*[always] * 20)) as lab,
        pytest.raises(OperatorGaveUp, match="40 mm off its mark"),
    ):
        lab.reset(np.random.default_rng(0), LAYOUT)
    with pytest.raises(RuntimeError, match="closed"):
        lab.reset(np.random.default_rng(0), LAYOUT)


def test_error_in_a_block_stops_the_robots() -> None:
    lab = quiet_laboratory()
    lab.reset(np.random.default_rng(0), LAYOUT)
    drive_all(lab)
    with pytest.raises(OSError, match="elsewhere"), lab:
        raise OSError("elsewhere")
    assert is_stopped(lab)


def test_impossible_layouts_are_rejected_without_a_request(lab: VirtualLaboratory) -> None:
    before = len(lab.virtual_operator.requests)
    for layout, message in (
        (LAYOUT._replace(starts=LAYOUT.starts[::-1]), r"robot at \(90, 415\)"),
        (LAYOUT._replace(foods=(Point(100, 115), LAYOUT.foods[1])), "overlaps robot"),
    ):
        with pytest.raises(ValueError, match=message):
            lab.reset(np.random.default_rng(0), layout)
    for pose, message in ((Pose(600, 115, 0), "gripper in a wall"), (Pose(370, 120, 0), "overlaps")):
        with pytest.raises(ValueError, match=message):
            lab.place(0, pose)
    assert len(lab.virtual_operator.requests) == before
    lab.advance()


def test_place_moves_one_robot_while_all_are_stopped() -> None:
    operator = ClumsyOperator()
    with quiet_laboratory(operator) as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        labels = [region.label for region in lab.camera.look().regions]
        for robot in lab.robots:
            robot.drive(Motors(5, 5, 215, 200))
        lab.advance()
        operator.errors = [lambda request: moved(request, 0, dx=-50)]
        teacher = lab.poses()[0]
        lab.place(1, Pose(250, 415, 1.0))
        assert [mark.name for mark in operator.requests[-1].robots] == ["learner_0"]
        assert operator.requests[-1].foods is None
        assert "50 mm off" in operator.requests[-1].errors[0]
        assert math.dist(lab.poses()[1][:2], (250, 415)) < 3
        assert math.dist(lab.poses()[0][:2], teacher[:2]) < 1, "all robots are stopped during the pause"
        assert [region.label for region in lab.camera.look().regions] == labels, "the tracks continue"


def test_held_food_moves_with_the_gripper(lab: VirtualLaboratory) -> None:
    lab.place(0, Pose(LAYOUT.foods[0].x - 57, LAYOUT.foods[0].y, 0.0))
    for rounds, motors in (
        (12, Motors(0, 0, 255, 200)),
        (8, Motors(0, 0, 255, 0)),
        (12, Motors(0, 0, 215, 0)),
        (10, Motors(-8, -8, 215, 0)),
    ):
        lab.robots[0].drive(motors)
        for _ in range(rounds):
            lab.advance()
    seen, truth = lab.food_places()[0], lab.simulation.food_places()[0]
    assert seen.lifted
    assert truth.lifted
    assert math.dist(seen[:2], truth[:2]) < 5
    assert not lab.food_places()[1].lifted
    lab.robots[0].drive(Motors(0, 0, 255, 0))
    for _ in range(12):
        lab.advance()
    assert not lab.food_places()[0].lifted


def test_laboratory_in_real_time_keeps_the_period() -> None:
    with quiet_laboratory(real_time=True) as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        begin, rounds = time.monotonic(), lab.clock.rounds
        lab.robots[0].drive(Motors(5, 5, 215, 200))
        for _ in range(4):
            lab.advance()
        assert time.monotonic() - begin > 0.3
        assert lab.clock.rounds == rounds + 4
        assert lab.simulation.poses()[0].x - LAYOUT.starts[0].x > 10, "overruns advance the simulation, too"
