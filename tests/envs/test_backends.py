"""Choosing a backend: errors, and environments that are the same on either until something is touched."""

import sys
from importlib.util import find_spec
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions, Noise
from khepera_forage.envs.paired_corridors_v1 import raw_env
from khepera_forage.rollouts.training import attempt
from khepera_forage.task.states import Behaviour, StateVector
from tests.sim.worlds import FIELD

NAMES = ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")
OF_ENVIRONMENT = "arena decisions foods limit home_radius diagonal confidence metadata observation_space action_space"
OF_FORAGER = "arena holes decisions senses vector state behaviour correct_behaviour raw applied"
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="needs numba")


def _id(name: str) -> str:
    return f"khepera_forage/{name}-v1"


@pytest.mark.parametrize("name", NAMES[::3])
def test_without_numba_compiled_worlds_are_refused(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One error says what to install; no other backend takes over silently."""
    monkeypatch.setitem(sys.modules, "numba", None)
    message = r"'compiled' needs numba: pip install 'khepera-forage\[fast\]'.*vectorization_mode='sync'"
    for make, kwargs in ((gym.make, {"backend": "compiled"}), (gym.make_vec, {"num_envs": 2})):
        with pytest.raises(ImportError, match=message):
            make(_id(name), **kwargs)
    gym.make(_id(name))
    gym.make_vec(_id(name), num_envs=2, vectorization_mode="sync").close()


@needs_numba
@pytest.mark.parametrize(
    ("name", "arena"), [*((name, "its own") for name in NAMES), ("Corridor", "field"), ("CorridorWheels", "field")]
)
def test_environment_is_the_same_bit_for_bit_until_something_is_touched(name: str, arena: str) -> None:
    """The same public names, types and values, at the start of episodes and under all noise.

    In the field wheels turn on the spot, the arm goes up and down, and food around is seen, hidden and lost; behaviours
    drive towards food.
    """
    noise = Noise(loss_rate_food=0.03, loss_rate_one_hole=0.03)
    decisions, options, steps = Decisions(next_to_food=17, recall_marker=1), None, 1
    kwargs: dict[str, Any] = {"noise": noise, "decisions": decisions}
    if arena == "field":
        kwargs |= {"arena": FIELD, "foods": 3}
        foods: Any = [(1500, 1000), (1500, 1500), (1500, 500)]
        if name.endswith("Wheels"):
            foods = [(1700, 1700), (1071.2, 928.8), (928.8, 1071.2)]
        options, steps = {"start": (1000, 1000, 46), "foods": foods}, 200 if name.endswith("Wheels") else 30
    pymunk: Any = gym.make(_id(name), **kwargs).unwrapped
    compiled: Any = gym.make(_id(name), backend="compiled", **kwargs).unwrapped
    assert (pymunk.backend, compiled.backend) == ("pymunk", "compiled")
    assert _public(pymunk) == _public(compiled)
    for attribute in OF_ENVIRONMENT.split():
        assert getattr(compiled, attribute) == getattr(pymunk, attribute), attribute
    rng, tracked, near = np.random.default_rng(0), set(), set()
    for seed in range(4):
        shown, others = (env.reset(seed=seed, options=options) for env in (pymunk, compiled))
        _check_views(pymunk.view(), compiled.view())
        for step in range(steps):
            np.testing.assert_equal(others, shown)
            assert _types(others) == _types(shown)
            _check_foragers(pymunk.forager, compiled.forager)
            tracked.add(pymunk.forager.raw.tracked)
            near.add(max(pymunk.forager.senses.proximity) > 7)  # beyond the noise of infra-reds
            action = shown[-1]["correct_behaviour"]
            if name.endswith("Wheels"):
                turn = (-1) ** (step // 4) * rng.uniform(0, 0.4)
                action = np.array((-turn, turn, *rng.choice((-1.0, 1.0), 2)))
            shown, others = (env.step(action) for env in (pymunk, compiled))
    assert steps < 200 or tracked == near == {True, False}


@needs_numba
def test_forages_and_trainings_of_the_thesis_are_the_same_on_both_backends() -> None:
    """Food is gripped, carried and released alike, also by a robot that was driving a round before."""
    for seed in range(4):
        steps = [_forage(gym.make(_id("Corridor"), backend=backend), seed) for backend in ("pymunk", "compiled")]
        np.testing.assert_equal(steps[0], steps[1])
        experience: list[list[tuple[StateVector, Behaviour]]] = [[], []]
        results = [
            attempt(raw_env(backend=backend), seed, lambda *row, own=own: own.append(row))
            for backend, own in zip(("pymunk", "compiled"), experience, strict=True)
        ]
        assert results[0] == results[1]
        assert experience[0] == experience[1]


def _forage(env: Any, seed: int) -> list[Any]:
    shown = [env.reset(seed=seed)]
    while len(shown) == 1 or not (shown[-1][2] or shown[-1][3]):
        shown.append(env.step(shown[-1][-1]["correct_behaviour"]))
    assert shown[-1][-1]["delivered"] == 1
    return shown


def _public(thing: Any) -> set[str]:
    return {name for name in dir(thing) if not name.startswith("_")}


def _types(shown: Any) -> Any:
    if isinstance(shown, dict):
        return {name: _types(value) for name, value in shown.items()}
    return [_types(one) for one in shown] if isinstance(shown, tuple) else (type(shown), np.asarray(shown).dtype)


def _check_foragers(one: Any, other: Any) -> None:
    assert _public(one) == _public(other)
    for attribute in OF_FORAGER.split():
        assert getattr(other, attribute) == getattr(one, attribute), attribute
    # Only labels of tracks differ: on pymunk the marker has the first one.
    assert other.food._replace(links=[]) == one.food._replace(links=[])
    for behaviour in Behaviour:
        assert other.motors_for(behaviour) == pytest.approx(one.motors_for(behaviour))


def _check_views(one: Any, other: Any) -> None:
    assert {region.holes for region in one.regions} == {0, 1}
    assert other._replace(regions=(), robots=(), foods=()) == one._replace(regions=(), robots=(), foods=())
    assert [region[1:6] for region in other.regions] == [
        pytest.approx(region[1:6]) for region in sorted(one.regions, key=lambda region: -region.holes)
    ]
    (robot,), (other_robot,) = one.robots, other.robots
    assert other_robot._replace(pose=robot.pose) == robot
    assert other_robot.pose == pytest.approx(robot.pose)
    for food, other_food in zip(one.foods, other.foods, strict=True):
        assert other_food[:2] == pytest.approx(food[:2])
        assert other_food[2:] == food[2:]
