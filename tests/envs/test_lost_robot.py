"""A robot or the camera is lost in the middle of an episode."""

import logging
import signal
from collections.abc import Callable, Iterator
from itertools import count
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


def in_call(number: int, act: Callable[[], object]) -> Callable[[], object]:
    """A callback that acts when it is called for that time."""
    calls = count(1)
    return lambda: act() if next(calls) == number else None


def rounds(env: TrainingEnv, number: int) -> None:
    """Rounds in which every robot searches."""
    for _ in range(number * len(env.possible_agents)):
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
        assert (env.truncations[agent], env.terminations[agent]) == (True, False)
        assert env.infos[agent]["robot_lost"].startswith(f"{env.world.settings.robots[robot].port}: ")
        assert env.infos[agent]["steps"] == 6
        np.testing.assert_array_equal(env.observe(agent)[:5], before[agent][:5])
    env.reset(seed=2)
    rounds(env, 5)
    assert not any(env.truncations.values())
    unplug(env.world, robot)
    env.resume_beside("learner_0")  # in a pause
    assert all(env.truncations.values())
    assert "robot_lost" in env.infos[TEACHER]
    assert standing(env.world)


def test_robots_stand_still_after_an_interrupt_between_rounds_and_after_the_end_of_an_episode(env: Any) -> None:
    with pytest.raises(KeyboardInterrupt):
        training.train(env, 1, callback=in_call(8, lambda: signal.raise_signal(signal.SIGINT)))
    assert standing(env.world)
    env.max_cycles = 6
    env.reset(seed=1)
    rounds(env, 5)
    assert not standing(env.world)
    rounds(env, 1)
    assert env.truncations[TEACHER]
    assert standing(env.world)


@pytest.mark.parametrize(
    ("kind", "action", "lost"), [(WheelsEnv, (0.5, 0.4, 1, -1), "robot"), (BehavioursEnv, 0, "camera")]
)
def test_recall_is_truncated_with_the_reason(
    kind: Any, action: Any, lost: str, alone: VirtualLaboratory, monkeypatch: pytest.MonkeyPatch
) -> None:
    env: gym.Env = kind(world=alone)
    env.reset(seed=1)
    for _ in range(4):
        observation, _, _, truncated, info = env.step(action)
        assert not truncated
        assert "robot_lost" not in info
    if lost == "robot":
        unplug(alone, 0)
    else:
        frame, _ = alone.frame_source.newest()
        monkeypatch.setattr(alone.frame_source, "newest", lambda: (frame, 2.0))
    last, reward, terminated, truncated, info = env.step(action)
    assert (reward, terminated, truncated, info["steps"]) == (-1 / 500, False, True, 5)
    reason = alone.settings.robots[0].port if lost == "robot" else "camera rendered frames: "
    assert info["robot_lost"].startswith(reason)
    np.testing.assert_equal(last, observation)
    assert standing(alone)
    with pytest.raises(gym.error.ResetNeeded):
        env.step(action)
    monkeypatch.undo()
    env.reset(seed=2)
    assert not env.step(action)[3]


def test_robot_lost_while_it_is_placed_ends_the_attempt() -> None:
    """Its port is closed when another robot takes its place."""
    placed: list[str] = []

    def operator(request: OperatorRequest) -> None:
        placed.append(request.reason.partition(":")[0])
        if len(placed) in (1, 3):
            unplug(lab, 1)
        lab.virtual_operator(request)

    with virtual_laboratory("corridor", 2, operator=operator) as lab:
        first = lab.virtual_kheperas[1]
        _, rows = training.train(TrainingEnv(world=lab, noise=Noise.none()), np.random.SeedSequence(1))
        assert [row.reason for row in rows[:2]] == [training.ROBOT_LOST] * 2
        assert rows[-1].complete
        assert (rows[0].rounds, rows[0].vectors) == (0, 0)
        assert placed[:3] == ["start of an episode", "reconnect what was lost", "start of an episode"]
        assert first not in lab.virtual_kheperas
        assert not first.connected


def test_experience_recorded_before_a_loss_is_kept(env: Any, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "g1.csv"
    (tmp_path / "g1.lost-1.csv").write_text("of an earlier training")
    watch = in_call(40, lambda: unplug(env.world, 1))
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
    watch = in_call(10, lambda: unplug(alone, 0))
    with pytest.raises(recalling.RecallInterruptedError, match=r"after 10 steps: /dev/"):
        recalling.recall(env, Teacher(env.home_radius), 3, callback=watch)
    assert recalling.recall(env, Teacher(env.home_radius), 3).steps > 20


def test_operator_who_gives_up_ends_the_episode_and_leaves_no_empty_file(tmp_path: Path) -> None:
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
    with virtual_laboratory("corridor", 2, operator=operator) as lab, pytest.raises(OperatorGaveUp):
        training.train(TrainingEnv(world=lab), np.random.SeedSequence(1), path=tmp_path / "g1.csv")
    assert not list(tmp_path.iterdir())


def test_world_needs_one_robot_in_each_arena(env: Any) -> None:
    with pytest.raises(ValueError, match="world has 2 robots in 2 arenas; allowed: 1"):
        BehavioursEnv(world=env.world)
    with pytest.raises(ValueError, match="allowed: 3, one in each"):
        TrainingEnv(num_learners=2, world=env.world)
