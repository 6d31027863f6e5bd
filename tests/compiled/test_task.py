"""The task in compiled worlds: the same episodes as in Python, and teachers as good as on pymunk."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled.step import _write_raw
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.records import blank
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.perception import RawData
from tests.arenas import BLOCKS
from tests.compiled.decisions import DECISIONS, IDS

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
LOSSES = Noise(loss_rate_food=0.01)


def test_every_field_of_raw_data_is_written() -> None:
    raw, record = RawData((1, 2, 3, 4, 5, 6), *range(7, 6 + len(RawData._fields))), blank(RawData)
    _write_raw(record, raw)
    assert vars(record) == {**raw._asdict(), "proximity": [1, 2, 3, 4, 5, 6]}


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
    for ours, theirs in zip(mine.food.objects, other.food.objects, strict=True):
        assert _close((ours.x, ours.y), (theirs.x, theirs.y))
        for name in ("type", "known", "delivered", "carried"):
            assert getattr(ours, name) == getattr(theirs, name), name


def _action(env: Any, behaviour: int) -> Any:
    """The action that commands a behaviour, in either kind of environment."""
    if isinstance(env.action_space, gym.spaces.Discrete):
        return behaviour
    left, right, arm, jaw = env.forager.motors_for(behaviour)
    return np.array((left / 20, right / 20, (235 - arm) / 20, 1 - jaw / 100))


@pytest.mark.parametrize(
    ("kind", "name", "kwargs"),
    [
        (BehavioursEnv, "Rectangle", {"foods": 3, "limit": 350}),
        (WheelsEnv, "CorridorWheels", {"foods": 1, "limit": 200}),
        *(
            (BehavioursEnv, "Rectangle", {"foods": 3, "limit": 250, "arena": BLOCKS, "decisions": decisions})
            for decisions in DECISIONS[1:]
        ),
    ],
    ids=("behaviours", "wheels", *IDS[1:]),
)
def test_episodes_are_those_of_the_task_in_python(
    kind: type[RecallEnv[Any]], name: str, kwargs: dict[str, Any]
) -> None:
    """Now and then another behaviour than the teacher's, so that food is lost, shoved and released anywhere.

    With other decisions, around walls and past poison, with each alternative of every decision.
    """
    compiled, python = _pair(kind, name, noise=LOSSES, food_types=MIXED, **kwargs)
    assert compiled.backend == python.backend == "compiled"
    rng = np.random.default_rng(0)
    delivered = wrong = 0
    for seed in range(2 if "decisions" in kwargs else 6):
        python.world.seed = seed
        obs, info = compiled.reset(seed=seed)
        other_obs, other_info = python.reset(seed=seed)
        over = False
        while not over:
            _check_same(compiled, python)
            for mine, other in ((obs, other_obs), (info, other_info)):
                assert list(mine) == list(other)
                assert all(_close(mine[key], other[key]) for key in mine)
            right = compiled.forager.correct_behaviour
            action = _action(compiled, int(rng.integers(10)) if rng.random() < 0.1 else right)
            obs, *result, info = compiled.step(action)
            other_obs, *other_result, other_info = python.step(action)
            assert result == other_result
            over = result[1] or result[2]
        delivered += info["delivered"]
        wrong += info["steps"] - info["correct"]
    assert wrong > 20
    assert delivered or "decisions" in kwargs
