"""One seed, one episode: the same rollout again, in copies and in another process, and the same start on both backends.

Worlds of `make_vec` have the episodes of single environments: `tests/compiled/test_vector_env.py`.
"""

import copy
import json
import pickle
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions
from khepera_forage.envs import paired_corridors_v1, paired_corridors_wheels_v1
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.sim.world import Layout
from tests.arenas import BLOCKS

pytest.importorskip("numba")

MIXED = {"pickable": 2, "pushable": 1, "poisonous": 1}
FORMS: dict[str, Callable[[], Any]] = {
    "paired wheels": partial(paired_corridors_wheels_v1.parallel_env, num_learners=2),
    "vector": partial(gym.make_vec, "khepera_forage/Rectangle-v1", num_envs=3, food_types=MIXED),
    "pairs": partial(paired_corridors_v1.vector_env, 3, food_types=MIXED),
}
for backend, name in product(("pymunk", "compiled"), ("Rectangle", "CorridorWheels")):
    FORMS[f"{name} {backend}"] = partial(gym.make, f"khepera_forage/{name}-v1", backend=backend)
    FORMS[f"paired {backend}"] = partial(paired_corridors_v1.parallel_env, backend=backend, food_types=MIXED)


def rollout(env: Any, seed: int | None, steps: int = 80, spoil: bool = False) -> list[str]:
    """Everything that an environment returns until an episode ends: mostly the correct behaviours, which touch food.

    Without a seed, the episode goes on. What was returned may be overwritten.
    """
    rng, given, kept = np.random.default_rng(steps), list[Any](), list[str]()
    shown: Any = (None, {}) if seed is None else env.reset(seed=seed)
    for _ in range(steps):
        given.append(shown)
        kept.append(text_of(shown))
        if any(np.any(list(ends.values()) if isinstance(ends, dict) else ends) for ends in shown[2:4]):
            break
        action = chosen(env, shown[-1], rng)
        for array in shown[0].values() if spoil else ():
            if isinstance(array, np.ndarray):
                array[...] = 0
        shown = env.step(action)
    assert spoil or [text_of(one) for one in given] == kept, "what was returned stays as it was"
    return kept


def text_of(shown: Any) -> str:
    return json.dumps(shown, default=lambda value: np.array(value).tolist())


def chosen(env: Any, info: Any, rng: np.random.Generator) -> Any:
    def one(space: Any, correct: Any) -> Any:
        if hasattr(env, "num_envs"):
            return np.where(rng.random(env.num_envs) < 0.8, correct, rng.integers(10, size=env.num_envs))
        if rng.random() < 0.8 and isinstance(space, gym.spaces.Discrete):
            return int(correct)
        space.seed(int(rng.integers(2**31)))
        return space.sample()

    agents = getattr(env, "possible_agents", None)
    if agents is None:
        return one(env.action_space, info.get("correct_behaviour", 0))
    return {agent: one(env.action_space(agent), info.get(agent, {}).get("correct_behaviour", 0)) for agent in agents}


@pytest.mark.parametrize("form", FORMS)
def test_same_seed_gives_the_same_rollout_also_in_copies(form: str) -> None:
    env, new = FORMS[form](), FORMS[form]()
    run = rollout(env, 5)
    assert rollout(new, 5) == run == rollout(env, 5, spoil=True)
    assert rollout(new, 6) != run
    rollout(env, 5, 100)
    twins = [copy.deepcopy(env), pickle.loads(pickle.dumps(env)), env]
    one, two, three = (rollout(twin, None, 40) for twin in twins)
    assert one == two == three


def rollouts() -> list[list[str]]:
    return [rollout(FORMS[form](), 9) for form in ("vector", "paired wheels", "Rectangle pymunk")]


def test_same_seed_gives_the_same_rollout_in_another_process() -> None:
    code = "import json; from tests.envs.test_rollouts import rollouts; print(json.dumps(rollouts()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == rollouts()


# ---------------------------------------------------------------- starts, food places and food types

OTHER = Decisions(food_to_walls=80, food_spacing=150, close_to_food=40, home_radius=80)
START, FOODS = (200, 300, 90), [(150, 450), (480, 150)]

Begun = tuple[Layout, str, list[int]]


def make(name: str, **kwargs: Any) -> Any:
    return gym.make(f"khepera_forage/{name}-v1", limit=2, food_types=MIXED, **kwargs).unwrapped


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
