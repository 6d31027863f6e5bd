"""The same seed gives the same rollout, in every form of environment: again, in copies, and in another process."""

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

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs import paired_corridors_v1, paired_corridors_wheels_v1

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
