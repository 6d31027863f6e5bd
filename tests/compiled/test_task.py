"""The task in compiled worlds: the same episodes as in Python, and teachers as good as on pymunk."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from scipy import stats

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from tests.arenas import BLOCKS
from tests.compiled.decisions import DECISIONS, IDS
from tests.version_0_1 import V0_1

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
LOSSES = Noise(loss_rate_food=0.01)


class _FixedKey:
    """A generator from which `CompiledWorld` takes the key of its random numbers."""

    def __init__(self, key: int) -> None:
        self._key = key

    def spawn(self, count: int) -> "list[_FixedKey]":
        return [self] * count

    def integers(self, high: int, dtype: Any) -> Any:
        return dtype(self._key)


class _KeyedWorld(CompiledWorld):
    """Compiled bodies with the random numbers that a compiled environment has after `reset(seed=seed)`."""

    seed: int

    def reset(self, rng: Any, layout: Layout) -> None:
        generator: Any = _FixedKey(key_of(self.seed))
        super().reset(generator, layout)


def _pair(kind: type[RecallEnv[Any]], name: str, **kwargs: Any) -> tuple[Any, Any]:
    """The compiled environment, and the Python environment on compiled bodies: only the task is another."""
    arena, noise = kwargs.get("arena", name.removesuffix("Wheels").lower()), kwargs.pop("noise", None)
    compiled = gym.make(
        f"khepera_forage/{name}-v1", backend="compiled", noise=noise, disable_env_checker=True, **kwargs
    ).unwrapped
    decisions = kwargs.get("decisions", Decisions())
    arena = checked_arena(arena, decisions)
    world = _KeyedWorld([arena], (decisions.recall_marker,), noise, timing=timing_of(decisions))
    kwargs.pop("arena", None)
    return compiled, kind(world=world, **kwargs)


def _close(one: Any, two: Any) -> bool:
    """Whether numbers are equal to rounding: compiled angles and roots differ in the last digits."""
    return np.allclose(one, two, rtol=0.0, atol=1e-9)


def _check_same(compiled: Any, python: Any) -> None:
    """The same perception, food tracker and state, to rounding."""
    mine, other = compiled.forager, python.forager
    assert mine.vector == other.vector
    assert mine.state == other.state
    assert mine.senses == other.senses
    assert mine.correct_behaviour == other.correct_behaviour
    assert mine.raw.proximity == other.raw.proximity
    assert _close(mine.raw[1:], other.raw[1:])
    for name in ("held", "type_in_gripper", "delivered", "poison_home", "deliverable", "food_seen"):
        assert getattr(mine.tracker, name) == getattr(other.tracker, name), name
    for ours, theirs in zip(mine.tracker.foods, other.tracker.foods, strict=True):
        assert _close((ours.x, ours.y), (theirs.x, theirs.y))
        for name in ("type", "known", "delivered", "carried"):
            assert getattr(ours, name) == getattr(theirs, name), name


def test_episodes_of_behaviours_are_those_of_the_task_in_python() -> None:
    """Now and then another behaviour than the teacher's, so that food is lost, shoved and released anywhere."""
    compiled, python = _pair(BehavioursEnv, "Rectangle", foods=3, limit=350, noise=LOSSES, food_types=MIXED)
    rng = np.random.default_rng(0)
    delivered = poison = 0
    for seed in range(8):
        python.world.seed = seed
        obs, info = compiled.reset(seed=seed)
        other_obs, other_info = python.reset(seed=seed)
        over = False
        while not over:
            _check_same(compiled, python)
            assert repr(obs) == repr(other_obs)
            for name in info:
                assert _close(info[name], other_info[name]), name
            random = rng.random() < 0.1
            behaviour = int(rng.integers(10)) if random else info["correct_behaviour"]
            obs, *result, info = compiled.step(behaviour)
            other_obs, *other_result, other_info = python.step(behaviour)
            assert result == other_result
            over = result[1] or result[2]
        delivered += info["delivered"]
        poison += sum(food.known == 3 for food in compiled.forager.tracker.foods)
    assert delivered > 6
    assert poison > 2


@pytest.mark.parametrize("decisions", DECISIONS[1:], ids=IDS[1:])
def test_other_decisions_have_the_same_episodes_as_in_python(decisions: Decisions) -> None:
    """Around walls and past poison, with each alternative of every decision."""
    kwargs: Any = {"foods": 3, "limit": 250, "noise": LOSSES, "food_types": MIXED, "arena": BLOCKS}
    compiled, python = _pair(BehavioursEnv, "Rectangle", decisions=decisions, **kwargs)
    rng = np.random.default_rng(3)
    for seed in range(2):
        python.world.seed = seed
        _, info = compiled.reset(seed=seed)
        python.reset(seed=seed)
        over = False
        while not over:
            assert compiled.forager.vector == python.forager.vector
            behaviour = int(rng.integers(10)) if rng.random() < 0.1 else info["correct_behaviour"]
            _, *result, info = compiled.step(behaviour)
            _, *other_result, _ = python.step(behaviour)
            assert result == other_result
            over = result[1] or result[2]


def test_episodes_of_wheels_are_those_of_the_task_in_python() -> None:
    compiled, python = _pair(WheelsEnv, "CorridorWheels", foods=1, limit=200, noise=LOSSES, food_types=MIXED)
    rng = np.random.default_rng(1)
    correct = 0
    for seed in range(5):
        python.world.seed = seed
        obs, info = compiled.reset(seed=seed)
        other_obs, other_info = python.reset(seed=seed)
        over = False
        while not over:
            _check_same(compiled, python)
            for name in obs:
                assert _close(obs[name], other_obs[name]), name
            motors = compiled.forager.motors_for(compiled.forager.correct_behaviour)
            right = (motors.left / 20, motors.right / 20, (235 - motors.arm) / 20, 1 - motors.jaw / 100)
            action = rng.uniform(-1, 1, 4) if rng.random() < 0.1 else np.array(right)
            obs, *result, info = compiled.step(action)
            other_obs, *other_result, other_info = python.step(action)
            assert result == other_result
            assert (info["steps"], info["correct"]) == (other_info["steps"], other_info["correct"])
            over = result[1] or result[2]
        correct += info["correct"] / info["steps"]
    assert 0.8 < correct / 5 < 1.0


def _pymunk_steps(episodes: int) -> Any:
    env = BehavioursEnv()
    steps = []
    for seed in range(episodes):
        _, info = env.reset(seed=seed)
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step(info["correct_behaviour"])
            over = terminated or truncated
        steps.append(info["steps"])
    return np.array(steps)


def test_teacher_takes_as_many_steps_as_on_pymunk() -> None:
    """Some hundred episodes here; thousands, with all scores, in benchmarks."""
    single = _pymunk_steps(250)
    compiled = run_teacher("corridor", 4000, 7)
    assert stats.ks_2samp(single, compiled.steps).pvalue > 1e-3
    assert abs(single.mean() - compiled.steps.mean()) < 4 * single.std() / math.sqrt(250)
    in_0_1 = run_teacher("corridor", 4000, 7, decisions=V0_1)
    assert in_0_1.delivered.mean() > 0.998
    assert in_0_1.score.mean() > 99.9


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"foods": 17}, "foods is 17"),
        ({"limit": 0}, "limit is 0"),
        ({"episodes": 0}, "episodes is 0"),
        ({"arena": "moon"}, "arena is 'moon'"),
        ({"decisions": 17}, "decisions is 17"),
    ],
)
def test_bad_arguments_are_quoted(arguments: Any, message: Any) -> None:
    with pytest.raises(ValueError, match=message):
        run_teacher(**arguments)
