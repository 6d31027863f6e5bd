"""Choosing a backend: errors, and what environments offer on either backend."""

import sys
from importlib.util import find_spec
from typing import Any

import gymnasium as gym
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions
from khepera_forage.task.states import Behaviour

NAMES = ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")
OF_ENVIRONMENT = ("arena", "decisions", "foods", "limit", "home_radius", "diagonal", "confidence", "metadata")
OF_FORAGER = ("arena", "holes", "decisions", "senses", "vector", "state", "correct_behaviour")
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="needs numba")


def _id(name: str) -> str:
    return f"khepera_forage/{name}-v1"


@pytest.mark.parametrize("backend", ["pymunk", pytest.param("compiled", marks=needs_numba)])
def test_sixteen_foods_are_possible_on_every_backend(backend: str) -> None:
    decisions = Decisions(food_spacing=40)
    env: Any = gym.make(_id("Rectangle"), backend=backend, foods=16, decisions=decisions)
    env.reset(seed=0)
    assert len(env.unwrapped.layout.foods) == len(env.unwrapped.forager.food.objects) == 16


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
@pytest.mark.parametrize("name", NAMES)
def test_compiled_environment_offers_what_that_on_pymunk_offers(name: str) -> None:
    """The same public names, and the same values at the start of every episode."""
    kwargs: Any = {"decisions": Decisions(next_to_food=17, recall_marker=1)}
    pymunk: Any = gym.make(_id(name), **kwargs).unwrapped
    compiled: Any = gym.make(_id(name), backend="compiled", **kwargs).unwrapped
    assert (pymunk.backend, compiled.backend) == ("pymunk", "compiled")
    assert _public(pymunk) == _public(compiled)
    for attribute in OF_ENVIRONMENT:
        assert getattr(compiled, attribute) == getattr(pymunk, attribute), attribute
    for seed in range(4):
        pymunk.reset(seed=seed)
        compiled.reset(seed=seed)
        one, other = pymunk.forager, compiled.forager
        assert _public(one) == _public(other)
        for attribute in OF_FORAGER:
            assert getattr(other, attribute) == getattr(one, attribute), attribute
        # Only labels of tracks differ: on pymunk the marker has the first one.
        assert other.food._replace(links=[]) == one.food._replace(links=[])
        assert other.raw == one.raw
        for behaviour in Behaviour:
            assert other.motors_for(behaviour) == pytest.approx(one.motors_for(behaviour))
        _check_views(pymunk.view(), compiled.view())


def _public(thing: Any) -> set[str]:
    return {name for name in dir(thing) if not name.startswith("_")}


def _check_views(one: Any, other: Any) -> None:
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
