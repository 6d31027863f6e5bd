"""Environments under other decisions: those of their version, the set-up, and times on both backends."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from khepera_forage import Decisions
from khepera_forage.envs import paired_corridors_v0, paired_corridors_v1
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, CONTROL_PERIOD, JAW_CLOSED, JAW_OPEN, SPEED_UNIT
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import CORRIDOR, V0_1

pytest.importorskip("numba")

OTHER = replace(V0_1, separation=20)


@pytest.mark.parametrize("make", ["env", "raw_env", "parallel_env"])
@pytest.mark.parametrize(("module", "default"), [(paired_corridors_v0, V0_1), (paired_corridors_v1, Decisions())])
def test_paired_corridors_have_the_decisions_of_their_version(module: Any, default: Decisions, make: str) -> None:
    for given, decisions in ((None, default), (OTHER, OTHER)):
        env = getattr(module, make)(num_learners=2, decisions=given)
        env.reset(seed=1)
        raw = getattr(env.unwrapped, "aec_env", env).unwrapped
        assert raw.decisions == decisions
        assert all(forager.decisions.separation == decisions.separation for forager in raw.foragers)
        assert env.metadata["name"] == module.__name__.rpartition(".")[2]


# ---------------------------------------------------------------- the set-up of figure 5.1


@pytest.mark.parametrize("name", THESIS_ARENAS)
def test_set_up_of_a_named_arena_follows_the_decisions(name: str) -> None:
    decisions = Decisions(start_to_wall=120, food_to_home=200, home_to_wall=90, home_radius=80)
    arena = checked_arena(name, decisions)
    assert (arena.start.x, arena.home.x, arena.home_radius) == (120, 650 - 90, 80)
    assert {arena.home.x - food.x for food in arena.foods} == {200}
    env = BehavioursEnv(arena=name, decisions=decisions)
    assert (env.arena, env.home_radius) == (arena, 16)
    assert TrainingEnv(arena=name, decisions=decisions).arenas[0] == arena
    assert BehavioursEnv(arena=CORRIDOR, decisions=decisions).arena is CORRIDOR, "a given arena stays"


@pytest.mark.parametrize("name", ["start_to_wall", "food_to_home", "home_to_wall", "home_radius"])
def test_ends_of_the_set_up_ranges_fit_in_the_named_arenas(name: str) -> None:
    known = Decisions.__dataclass_fields__[name].metadata["decision"]
    for value in (known.least, known.most):
        changes = {name: value}
        if name == "home_to_wall" and value < 100:
            changes["home_radius"] = value
        if name == "home_radius" and value > 100:
            changes["home_to_wall"] = value
        for arena in THESIS_ARENAS:
            BehavioursEnv(arena=arena, decisions=Decisions.from_changes(changes)).reset(seed=1)


# ---------------------------------------------------------------- times


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
@pytest.mark.parametrize(("duration", "arm", "jaw"), [(0.05, 0.4, 2.0), (0.1, 0.8, 0.4), (0.25, 2.0, 1.0)])
def test_rounds_arm_and_jaw_take_the_decided_times(backend: str, duration: float, arm: float, jaw: float) -> None:
    decisions = Decisions(round_duration=duration, arm_travel_time=arm, jaw_travel_time=jaw)
    env = WheelsEnv(arena="rectangle", backend=backend, decisions=decisions, noise="none", foods=2)
    env.reset(seed=1, options={"start": (200, 150, 0), "foods": [(100, 500), (300, 500)]})
    for rounds in range(1, 11):
        env.step(np.array((0.5, 0.5, -1.0, 1.0)))
        senses, shares = env.forager.senses, [min(1.0, rounds * duration / time) for time in (arm, jaw)]
        assert senses.arm == pytest.approx(ARM_RAISED + shares[0] * (ARM_DOWN - ARM_RAISED), abs=0.5)
        assert senses.jaw == pytest.approx(JAW_OPEN + shares[1] * (JAW_CLOSED - JAW_OPEN), abs=0.5)
    assert env.forager.raw.x * 5.0 - 200 == pytest.approx(10 * SPEED_UNIT * 10 * duration, abs=2.5)


def test_training_environments_run_at_the_decided_times() -> None:
    training = TrainingEnv(decisions=Decisions(round_duration=0.2, arm_travel_time=0.4), noise="none")
    training.reset(seed=1)
    for _ in range(2 * len(training.possible_agents)):
        training.step(int(Behaviour.EXPLORE_FOOD))
    assert [forager.senses.arm for forager in training.foragers] == [ARM_DOWN, ARM_DOWN]


@pytest.mark.parametrize("duration", [0.05, 0.18, 0.5])
def test_bodies_of_a_virtual_laboratory_move_for_about_a_control_period_at_a_time(duration: float) -> None:
    """In rounds as long as the decided ones, what touches something would be moved in too large steps."""
    pytest.importorskip("serial")
    pytest.importorskip("cv2")
    with virtual_laboratory("corridor", 1, Decisions(round_duration=duration)) as lab:
        assert lab.simulation.round_duration == pytest.approx(CONTROL_PERIOD, rel=0.5)
        assert (duration / lab.simulation.round_duration) % 1 == pytest.approx(0)
