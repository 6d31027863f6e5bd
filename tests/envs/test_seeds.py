"""One seed, one episode: start, food places and food types are the same on both backends, whatever the noise.

Worlds of `make_vec` have the episodes of single environments: `tests/compiled/test_vector_env.py`.
"""

from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from khepera_forage import Decisions
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.sim.world import Layout
from tests.arenas import BLOCKS

pytest.importorskip("numba")

ODDS = {"pickable": 2, "pushable": 1, "poisonous": 1}
OTHER = Decisions(food_to_walls=80, food_spacing=150, close_to_food=40, home_radius=80)
START, FOODS = (200, 300, 90), [(150, 450), (480, 150)]

Begun = tuple[Layout, str, list[int]]


def make(name: str, **kwargs: Any) -> Any:
    return gym.make(f"khepera_forage/{name}-v1", limit=2, food_types=ODDS, **kwargs).unwrapped


def begun(env: Any, seed: int | None = None, options: Any = None) -> Begun:
    env.reset(seed=seed, options=options)
    return env.layout, env.arena.name, [int(food.type) for food in env.forager.food.objects]


@pytest.mark.parametrize(
    ("name", "kwargs", "options"),
    [
        ("Corridor", {}, None),
        ("Rectangle", {"decisions": OTHER}, None),
        ("Rectangle", {"foods": 16, "decisions": Decisions(food_spacing=40)}, None),
        ("Rectangle", {"arena": BLOCKS, "foods": 3}, None),
        ("Corridor", {"arena": ProceduralArenas("easy", "test", num_levels=30)}, None),
        ("Rectangle", {}, {"start": START}),
        ("Rectangle", {}, {"foods": FOODS}),
        ("Rectangle", {}, {"start": START, "foods": FOODS}),
    ],
    ids=str,
)  # fmt: skip
def test_episodes_begin_alike_on_both_backends(name: str, kwargs: dict[str, Any], options: Any) -> None:
    """The first ones of a seed, and those that follow; options hold for one episode only.

    Neither noise nor the kind of action plays a part.
    """
    one = make(name, **kwargs)
    other = make(f"{name}Wheels", backend="compiled", noise="none", **kwargs)
    for env in (one, other):
        with pytest.raises(ResetNeeded):
            _ = env.layout
    seen: list[Begun] = []
    for seed in (*range(7, 12), 2**63, 2**64 - 1, 2**200 + 3):
        for episode, given in enumerate((options, None, options)):
            seen.append(begun(one, None if episode else seed, given))
            assert begun(other, None if episode else seed, given) == seen[-1]
            for _ in range(episode):  # an episode may be left before its end
                other.step(np.zeros(4))
    assert {(len(layout.foods), len(types)) for layout, _, types in seen} == {(one.foods, one.foods)}
    free = seen if options is None else seen[1::3]
    assert len({layout for layout, *_ in free}) == len(free)
    assert {food_type for *_, types in seen for food_type in types} == {1, 2, 3}
    assert begun(one, 7, options) == begun(other, 7, options) == seen[0]


@pytest.mark.parametrize(
    "form",
    [
        BehavioursEnv,
        partial(BehavioursEnv, backend="compiled"),
        TrainingEnv,
        partial(gym.make_vec, "khepera_forage/Corridor-v1", num_envs=2),
    ],
)
def test_generator_that_was_set_decides_the_episodes_that_follow(form: Any) -> None:
    env, episodes = form(), []
    env.reset()
    for seed in (1, 2, 1):
        env.np_random = np.random.default_rng(seed)
        episodes.append([str(env.reset() or env.world.poses()) for _ in range(2)])
    one, other, again = episodes
    assert one == again != other
    assert one[0] != one[1]
