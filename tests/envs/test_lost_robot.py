"""A robot or the camera is lost in the middle of an episode."""

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.experience import Experience, ExperienceError, ExperienceWarning
from khepera_forage.lab.operator import OperatorGaveUp, OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher
from khepera_forage.robots.virtual.virtual_khepera import Faults
from khepera_forage.rollouts import recall as recalling
from khepera_forage.rollouts import training

pytest.importorskip("serial")
pytest.importorskip("cv2")


@pytest.fixture
def env() -> Iterator[TrainingEnv]:
    with virtual_laboratory("corridor", 2) as lab:
        yield TrainingEnv(world=lab, noise=Noise.none())


@pytest.fixture
def alone() -> Iterator[VirtualLaboratory]:
    with virtual_laboratory("corridor", 1) as lab:
        yield lab


def unplug(lab: Any, robot: int) -> None:
    lab.virtual_kheperas[robot].faults = Faults(unplug=1.0)


def standing(lab: Any) -> bool:
    lab.simulation.advance()
    before = [robot.sense()[1:3] for robot in lab.simulation.robots]
    lab.simulation.advance()
    return before == [robot.sense()[1:3] for robot in lab.simulation.robots]


def rounds(env: TrainingEnv, count: int) -> None:
    """Rounds in which every robot searches."""
    for _ in range(count * len(env.possible_agents)):
        env.step(0)


@pytest.mark.parametrize("robot", [0, 1])
def test_training_is_truncated_with_the_reason(env: Any, robot: int) -> None:
    env.reset(seed=1)
    rounds(env, 5)
    assert not any("robot_lost" in info for info in env.infos.values())
    before = {agent: env.observe(agent) for agent in env.agents}
    unplug(env.world, robot)
    rounds(env, 1)
    assert standing(env.world)
    assert env.agents == [TEACHER, "learner_0"], "PettingZoo's own loop takes them away one by one"
    for agent in env.agents:
        assert env.truncations[agent]
        assert not env.terminations[agent]
        assert env.infos[agent]["robot_lost"].startswith(f"{env.world.settings.robots[robot].port}: ")
        assert env.infos[agent]["steps"] == 6
        np.testing.assert_array_equal(env.observe(agent)[:5], before[agent][:5])
    env.reset(seed=2)
    rounds(env, 5)
    assert not any(env.truncations.values())


def test_robots_stand_still_after_the_end_of_a_training_episode(env: Any) -> None:
    env.max_cycles = 6
    env.reset(seed=1)
    rounds(env, 5)
    assert not standing(env.world)
    rounds(env, 1)
    assert env.truncations[TEACHER]
    assert standing(env.world)


def test_robots_stand_still_after_an_interrupt_between_rounds(env: Any) -> None:
    count: list[int] = []

    def fail() -> None:
        count.append(1)
        if len(count) == 8:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        training.train(env, 1, callback=fail)
    assert standing(env.world)


def test_robot_lost_in_a_pause_ends_the_episode(env: Any) -> None:
    env.reset(seed=1)
    rounds(env, 5)
    unplug(env.world, 0)
    env.resume_beside("learner_0")
    assert all(env.truncations.values())
    assert "robot_lost" in env.infos[TEACHER]
    assert standing(env.world)


def test_recall_is_truncated_with_the_reason(alone: VirtualLaboratory) -> None:
    env: gym.Env = WheelsEnv(world=alone)
    action = np.array((0.5, 0.4, 1.0, -1.0), np.float32)
    env.reset(seed=1)
    for _ in range(4):
        observation, _, _, truncated, info = env.step(action)
        assert not truncated
        assert "robot_lost" not in info
    unplug(alone, 0)
    last, reward, terminated, truncated, info = env.step(action)
    assert truncated
    assert not terminated
    assert reward == -1 / 500
    assert info["steps"] == 5
    assert info["robot_lost"].startswith(alone.settings.robots[0].port)
    for key, value in observation.items():
        np.testing.assert_array_equal(last[key], value)
    assert standing(alone)
    with pytest.raises(gym.error.ResetNeeded):
        env.step(action)
    env.reset(seed=2)
    assert not env.step(action)[3]


def test_lost_camera_truncates_like_a_lost_robot(alone: VirtualLaboratory, monkeypatch: pytest.MonkeyPatch) -> None:
    env = BehavioursEnv(world=alone)
    env.reset(seed=1)
    frame, _ = alone.frame_source.newest()
    monkeypatch.setattr(alone.frame_source, "newest", lambda: (frame, 2.0))
    _, _, _, truncated, info = env.step(0)
    assert truncated
    assert info["robot_lost"].startswith("camera rendered frames: ")
    assert standing(alone)


def test_robot_lost_while_it_is_placed_ends_the_attempt() -> None:
    """Its port is closed when another robot takes its place."""
    placed: list[OperatorRequest] = []

    def operator(request: OperatorRequest) -> None:
        placed.append(request)
        if len(placed) in (1, 3):
            unplug(lab, 1)
        lab.virtual_operator(request)

    with virtual_laboratory("corridor", 2, operator=operator) as lab:
        first = lab.virtual_kheperas[1]
        _, rows = training.train(TrainingEnv(world=lab, noise=Noise.none()), np.random.SeedSequence(1))
        assert [row.reason for row in rows[:2]] == [training.ROBOT_LOST] * 2
        assert rows[-1].complete
        assert (rows[0].rounds, rows[0].vectors) == (0, 0)
        assert [request.reason[:18] for request in placed[:3]] == [
            "start of an episod",
            "reconnect what was",
            "start of an episod",
        ]
        assert first not in lab.virtual_kheperas
        assert not first.connected


def test_experience_recorded_before_a_loss_is_kept(env: Any, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "g1.csv"
    (tmp_path / "g1.lost-1.csv").write_text("of an earlier training")
    seen: list[int] = []

    def watch() -> None:
        seen.append(1)
        if len(seen) == 40:
            unplug(env.world, 1)

    with caplog.at_level(logging.WARNING, training.__name__):
        experience, rows = training.train(env, np.random.SeedSequence(3), path=path, callback=watch)
    assert rows[0].reason == training.ROBOT_LOST
    assert rows[-1].complete
    assert rows[0].rounds == 41
    kept = tmp_path / "g1.lost-2.csv"
    assert f"its {rows[0].vectors} experience vectors are kept in {kept}" in caplog.text
    with pytest.raises(ExperienceError):
        Experience.load(kept)
    with pytest.warns(ExperienceWarning):
        recovered = Experience.load(kept, recover=True)
    assert len(recovered) == rows[0].vectors
    assert rows[0].vectors > 30
    assert Experience.load(path) == experience
    assert (tmp_path / "g1.lost-1.csv").read_text() == "of an earlier training"


def test_recall_with_a_lost_robot_raises_an_error(alone: VirtualLaboratory) -> None:
    env = recalling.recall_env("corridor", world=alone)
    steps: list[int] = []

    def watch() -> None:
        steps.append(1)
        if len(steps) == 10:
            unplug(alone, 0)

    with pytest.raises(recalling.RecallInterruptedError, match=r"after 10 steps: /dev/"):
        recalling.recall(env, Teacher(env.home_radius), 3, callback=watch)
    assert recalling.recall(env, Teacher(env.home_radius), 3).steps > 20


def test_reset_that_the_operator_gives_up_ends_the_episode() -> None:
    calls: list[OperatorRequest] = []

    def operator(request: OperatorRequest) -> None:
        calls.append(request)
        if len(calls) > 1:
            raise OperatorGaveUp("no time")
        lab.virtual_operator(request)

    with virtual_laboratory("corridor", 1, operator=operator) as lab:
        env = BehavioursEnv(world=lab)
        env.reset(seed=1)
        with pytest.raises(OperatorGaveUp):
            env.reset(seed=2)
        with pytest.raises(gym.error.ResetNeeded):
            env.step(0)


def test_world_needs_one_robot_in_each_arena(env: Any) -> None:
    with pytest.raises(ValueError, match="world has 2 robots in 2 arenas; allowed: 1"):
        BehavioursEnv(world=env.world)
    with pytest.raises(ValueError, match="allowed: 3, one in each"):
        TrainingEnv(num_learners=2, world=env.world)


def test_operator_who_gives_up_leaves_no_empty_file(tmp_path: Path) -> None:
    def nobody(request: OperatorRequest) -> None:
        raise OperatorGaveUp("no time")

    path = tmp_path / "g1.csv"
    with virtual_laboratory("corridor", 2, operator=nobody) as lab:
        env = TrainingEnv(world=lab, noise=Noise.none())
        with pytest.raises(OperatorGaveUp):
            training.train(env, np.random.SeedSequence(1), path=path)
        assert not path.exists()
