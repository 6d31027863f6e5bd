"""Duration of a round and speed of arm and jaw, as `Decisions` set them on pymunk."""

import pytest

from khepera_forage import Decisions
from khepera_forage.envs.arguments import timing_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    JAW_CLOSED,
    JAW_OPEN,
    PULSE,
    SPEED_UNIT,
    Motors,
)
from khepera_forage.task.states import Behaviour


def driven(decisions: Decisions, motors: Motors, rounds: int) -> BehavioursEnv:
    """An environment without noise, after rounds under one motor command, far from everything."""
    env = BehavioursEnv(arena="rectangle", noise=Noise.none(), decisions=decisions)
    env.reset(seed=1, options={"start": (200, 150, 0), "foods": [(100, 500)]})
    for _ in range(rounds):
        env.forager.drive(motors)
        env.world.advance()
        env.forager.perceive(env.world.camera.look())
    return env


@pytest.mark.parametrize("duration", [0.05, 0.1, 0.2])
def test_round_duration_is_how_long_a_command_acts(duration: float) -> None:
    env = driven(Decisions(round_duration=duration), Motors(10, 10, ARM_RAISED, JAW_OPEN), 10)
    # The body starts to move one physics step after the command.
    assert env.world.poses()[0].x - 200 == pytest.approx(10 * SPEED_UNIT * 10 * duration, abs=2.5)
    assert env.forager.senses.left_pulses == pytest.approx(10 * SPEED_UNIT * 10 * duration / PULSE, abs=1)


@pytest.mark.parametrize("duration", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("travel", [0.4, 1.0, 2.0])
def test_arm_travel_time_is_how_long_the_arm_takes(travel: float, duration: float) -> None:
    decisions = Decisions(arm_travel_time=travel, round_duration=duration)
    lowering = Motors(0, 0, ARM_DOWN, JAW_OPEN)
    rounds = round(travel / duration)
    positions = [driven(decisions, lowering, count).forager.senses.arm for count in (1, rounds - 1, rounds)]
    step = (ARM_DOWN - ARM_RAISED) * duration / travel
    assert positions == pytest.approx([ARM_RAISED + step, ARM_DOWN - step, ARM_DOWN], abs=0.5)


@pytest.mark.parametrize("duration", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("travel", [0.4, 0.8, 2.0])
def test_jaw_travel_time_is_how_long_the_jaw_takes(travel: float, duration: float) -> None:
    decisions = Decisions(jaw_travel_time=travel, round_duration=duration)
    closing = Motors(0, 0, ARM_RAISED, JAW_CLOSED)
    rounds = round(travel / duration)
    positions = [driven(decisions, closing, count).forager.senses.jaw for count in (1, rounds - 1, rounds)]
    step = (JAW_OPEN - JAW_CLOSED) * duration / travel
    assert positions == pytest.approx([JAW_OPEN - step, JAW_CLOSED + step, JAW_CLOSED], abs=0.5)


def test_timing_of_version_0_1_is_that_of_the_devices() -> None:
    timing = timing_of(Decisions.v0_1())
    assert timing.round_duration == 0.1
    assert timing.arm_speed == 40.0
    assert timing.jaw_speed == pytest.approx(333.0, abs=0.5)


def test_training_world_runs_at_the_decided_times() -> None:
    env = TrainingEnv(
        noise=Noise.none(), decisions=Decisions(round_duration=0.2, arm_travel_time=0.4, home_speed=12)
    )
    env.reset(seed=1)
    for _ in range(2 * len(env.possible_agents)):
        env.step(int(Behaviour.EXPLORE_FOOD))
    assert [forager.senses.arm for forager in env.foragers] == [ARM_DOWN, ARM_DOWN]
