"""The task in compiled worlds: the same episodes as in Python."""

from typing import Any

import numpy as np
import pytest

from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.raw_episodes import encoded_motors
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.task.decisions import Decisions
from tests.arenas import BLOCKS
from tests.compiled.decisions import DECISIONS, IDS

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
LOSSES = Noise(loss_rate_food=0.01)


def _close(one: Any, two: Any) -> bool:
    """Whether numbers are equal to rounding: compiled angles and roots differ in the last digits."""
    return np.allclose(one, two, rtol=0.0, atol=1e-9)


def _check_same(compiled: Any, python: Any) -> None:
    """The same perception, food tracker and state, to rounding."""
    mine, other = compiled.forager, python.forager
    for name in ("vector", "state", "senses", "correct_behaviour"):
        assert getattr(mine, name) == getattr(other, name), name
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
    if isinstance(env, BehavioursEnv):
        return behaviour
    return np.array(encoded_motors(applicable(env.forager.motors_for(behaviour))))


@pytest.mark.parametrize(
    ("kind", "arena", "decisions", "foods", "limit"),
    [
        (BehavioursEnv, "rectangle", DECISIONS[0], 3, 350),
        (WheelsEnv, "corridor", DECISIONS[0], 1, 200),
        *((BehavioursEnv, BLOCKS, decisions, 3, 250) for decisions in DECISIONS[1:]),
    ],
    ids=("behaviours", "wheels", *IDS[1:]),
)
def test_episodes_are_those_of_the_task_in_python(
    kind: type[RecallEnv[Any]], arena: Any, decisions: Decisions, foods: int, limit: int
) -> None:
    """The Python environment has compiled bodies, too: only the task is another.

    Now and then another behaviour than the teacher's, so that food is lost, shoved and released anywhere. With other
    decisions, around walls and past poison, with each alternative of every decision.
    """
    kwargs: dict[str, Any] = {"foods": foods, "limit": limit, "food_types": MIXED, "decisions": decisions}
    compiled: Any = kind(arena=arena, backend="compiled", noise=LOSSES, **kwargs)
    bodies = [checked_arena(arena, decisions)], (decisions.recall_marker,), LOSSES
    python: Any = kind(world=CompiledWorld(*bodies, timing=timing_of(decisions)), **kwargs)
    assert compiled.backend == python.backend == "compiled"
    rng = np.random.default_rng(0)
    delivered = wrong = 0
    for seed in range(6 if decisions == Decisions() else 2):
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
    assert delivered or decisions != Decisions()
