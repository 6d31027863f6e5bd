"""The virtual laboratory: repeatable, with all robots and markers, and driven by the command line."""

import math
import os
import signal
import threading
import time
from collections import deque
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from khepera_forage.cli.main import main
from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.lab.settings_file import parse
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher
from khepera_forage.robots.khepera import Motors
from khepera_forage.rollouts import training
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.sim.arena import Pose
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.vision.video import Frame, FrameSource
from tests.lab.laboratories import QUIET, layout_of
from tests.version_0_1 import SET_UP, V0_1

pytest.importorskip("serial")
pytest.importorskip("cv2")


def run_attempt(env: TrainingEnv, seed: int) -> list[Any]:
    """Everything that is perceived and recorded in one training attempt."""
    history: list[Any] = []

    def watch() -> None:
        senses = [forager.senses._replace(left_pulses=0, right_pulses=0) for forager in env.foragers]
        history.append((senses, env.world.camera.look(), env.world.poses(), env.world.food_places()))

    history.append(training.attempt(env, seed, lambda *row: history.append(row), callback=watch))
    return history


def test_same_seed_gives_the_same_rollout_bit_for_bit() -> None:
    """In the same laboratory after another episode, and in a new laboratory; also on a busy machine."""
    runs = []
    with virtual_laboratory("corridor", 2, timeout=2.0) as lab:
        env = TrainingEnv(world=lab, noise=Noise.none())
        runs.append(run_attempt(env, 12))
        env.reset(seed=9)
        for _ in range(33):
            env.step(2)
        runs.append(run_attempt(env, 12))
    with virtual_laboratory("corridor", 2, timeout=2.0) as lab:
        runs.append(run_attempt(TrainingEnv(world=lab, noise=Noise.none()), 12))
    assert runs[0] == runs[1] == runs[2]
    assert len(runs[0]) > 60


def test_marker_that_extends_over_a_wall_is_located_correctly() -> None:
    with virtual_laboratory("corridor", 1) as lab:
        (arena,) = lab.arenas
        dx, dy = arena.bounds[:2]
        for x, y, heading in ((36, 115, 0), (200, 36, math.pi / 2), (614, 60, math.pi), (300, 194, -math.pi / 2)):
            lab.reset(np.random.default_rng(60), Layout((Pose(x + dx, y + dy, heading),), arena.foods))
            (body,), (seen,) = lab.simulation.poses(), lab.poses()
            assert arena.clearance(body) < 45
            assert math.dist(body[:2], seen[:2]) < 5
            assert abs(math.remainder(body.heading - seen.heading, math.tau)) < math.radians(3)


def test_training_leads_around_corners() -> None:
    """In the T-maze, food and home are in opposite arms."""
    with virtual_laboratory("t_maze", 2, V0_1, timeout=2.0, **QUIET) as lab:
        (left, low, _, _), (_, _, right, high) = (arena.bounds for arena in lab.arenas)
        assert (left + right, low + high) == (3200, 2400), "in the middle of the picture"
        env = TrainingEnv(world=lab, noise=Noise.none(), decisions=V0_1)
        attempt = training.attempt(env, 2, lambda vector, behaviour: None)
        for arena, food in zip(lab.arenas, lab.simulation.food_places(), strict=True):
            assert math.dist(arena.home, food[:2]) < arena.home_radius
    assert attempt.complete


class LateFrames:
    """Shows each frame three rounds late."""

    def __init__(self, source: FrameSource) -> None:
        self.source, self.frames = source, deque[Frame](maxlen=4)

    def newest(self) -> tuple[Frame, float]:
        self.frames.append(self.source.newest()[0])
        return self.frames[0], 0.0

    def close(self) -> None:
        self.source.close()


def test_teacher_with_a_slow_arm_under_a_camera_that_is_0_3_s_late_brings_food_home() -> None:
    decisions = Decisions(lowering_speed=0, arm_travel_time=1)
    with virtual_laboratory("corridor", 1, decisions, timeout=2.0, camera=LateFrames) as lab:
        env = recall_env("corridor", world=lab, decisions=decisions)
        rows = [recall(env, Teacher.of(env), seed) for seed in range(2)]
    assert [row.delivered for row in rows] == [1, 1]


@pytest.mark.parametrize(
    ("markers", "numbers"), [("grid", [3, 12]), ("tags", [7, 4]), ("holes", []), ("grid", []), ("tags", [])]
)
def test_laboratory_of_a_file_shows_its_markers(markers: str, numbers: list[int]) -> None:
    """Without numbers those are 1, 2, 3; of the thesis's two kinds, all learners have the second."""
    robots = [f'[[robots]]\nport = "{i}"\noffset = [600, {300 + 600 * i}]\n' for i in range(len(numbers) or 3)]
    robots = [f"{robot}holes = {n}\n" for robot, n in zip(robots, numbers, strict=True)] if numbers else robots
    settings = parse(f'[camera]\nsource = 0\n[tracker]\nmarkers = "{markers}"\n' + "".join(robots), SET_UP, 0.1)
    assert [robot.holes for robot in settings.robots] == (numbers or [1, 2, 2 if markers == "holes" else 3])
    with VirtualLaboratory(settings, arm_speed=40, jaw_speed=333, noise="none") as lab:
        lab.reset(np.random.default_rng(0), layout_of(lab.arenas))
        for pose, arena in zip(lab.poses(), lab.arenas, strict=True):
            assert math.dist(pose[:2], arena.start[:2]) < 5


def test_e_puck2_brings_food_home_from_behind_it() -> None:
    """No marker hides the food that it pushes, and what it pushed away leaves no food behind."""
    with virtual_laboratory("corridor", 1, robot="e-puck2") as lab:
        env = recall_env("corridor", world=lab)
        teacher = Teacher.of(env)
        observation, info = env.reset(seed=1216546553)
        assert lab.poses()[0].x > lab.food_places()[0].x, "the robot starts nearer home than the food"
        ended = False
        while not ended:
            observation, _, ended, truncated, info = env.step(int(teacher.act(observation)))
            assert not truncated
        assert info["delivered"] == 1


def test_interrupt_ends_the_command_and_its_threads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupt() -> None:
        while not (tmp_path / "e" / "g1.csv").exists():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    hand = threading.Thread(target=interrupt)
    hand.start()
    command = ["train", "--lab", "virtual", "--episodes", "500", "--out", str(tmp_path / "e")]
    assert main(command) == 130
    hand.join()
    assert "stopped" in capsys.readouterr().err
    left = [thread.name for thread in threading.enumerate() if thread.name.startswith(("khepera", "port"))]
    assert left == []


@pytest.mark.parametrize("period", [0.05, 0.18, 0.2, 0.5])
def test_rounds_set_up_and_arm_follow_the_decisions(period: float) -> None:
    decisions = replace(V0_1, round_duration=period, arm_travel_time=0.8, food_to_home=200, start_to_wall=120)
    with virtual_laboratory("corridor", 2, decisions, **QUIET) as lab:
        for arena in lab.arenas:
            assert arena.home.x - arena.foods[0].x == pytest.approx(200)
            assert arena.start.x - arena.bounds[0] == pytest.approx(120)
        assert lab.round_duration == period
        lab.reset(np.random.default_rng(0), layout_of(lab.arenas))
        lab.robots[0].drive(Motors(5, 5, 255, 200))
        for number in range(1, 6):
            lab.advance()
            assert lab.robots[0].sense().arm == pytest.approx(min(255, 215 + 50 * number * period), abs=0.51)
        assert lab.simulation.poses()[0].x == pytest.approx(lab.arenas[0].start.x + 5 * 5 * 8 * period)
        assert b"".join(lab.firmwares[0].handle(b"E").split()) == b"e,5,5"


def test_robot_without_a_serial_line_is_refused() -> None:
    with pytest.raises(ValueError, match="robots are of type 'toio'; allowed: khepera, e-puck2"):
        virtual_laboratory("corridor", 1, robot="toio")
