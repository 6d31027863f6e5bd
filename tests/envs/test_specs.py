"""Names, versions and specs: every argument survives a spec that is stored as JSON, as Minari stores it."""

import pickle
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode, VectorEnv

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions, Noise
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.task.states import FoodType
from tests.arenas import BLOCKS, HALL
from tests.version_0_1 import V0_1

SMALL = replace(DIFFICULTIES["easy"], name="small", foods=1)
ARGUMENTS: list[dict[str, Any]] = [
    {"noise": Noise.only("wheels")},
    {"noise": Noise(wheel_slip=np.float32(0.1), loss_rounds=np.int64(3))},  # type: ignore[arg-type]
    {"noise": "none", "foods": 2, "limit": 30, "render_mode": "rgb_array"},
    {"decisions": Decisions(next_to_food=22), "food_types": FoodType.PUSHABLE},
    {"food_types": {FoodType.PUSHABLE: 1.0, "poisonous": 1.0}},
    {"arena": BLOCKS},
    {"robot": "toio", "food_types": "PUSHABLE"},
    {"arena": [BLOCKS, "corridor", HALL]},
    {"arena": ProceduralArenas("easy", "test", num_levels=3)},
    {"difficulty": SMALL, "split": "test", "num_levels": 3, "start_level": 1},
]
SAME_STEP = {"autoreset_mode": AutoresetMode.SAME_STEP}
FORMS: dict[str, tuple[Callable[..., Any], str, dict[str, Any]]] = {
    "pymunk": (gym.make, "", {"backend": "pymunk", "max_episode_steps": 40}),
    "compiled": (gym.make, "", {"backend": "compiled", "max_episode_steps": 40}),
    "sync": (gym.make_vec, "Wheels", {"num_envs": 2, "vectorization_mode": "sync"}),
    "vector": (gym.make_vec, "Wheels", {"num_envs": 2, "max_episode_steps": 40, **SAME_STEP}),
}
of_every_form = pytest.mark.parametrize(("make", "kind", "kwargs"), FORMS.values(), ids=FORMS)


def stored(env: Any) -> str:
    owner: Any = env.unwrapped if isinstance(env, VectorEnv) else env
    return str(owner.spec.to_json())


@of_every_form
@pytest.mark.parametrize("given", ARGUMENTS, ids=str)
def test_environment_of_a_stored_spec_is_the_same(
    given: dict[str, Any], make: Callable[..., Any], kind: str, kwargs: dict[str, Any]
) -> None:
    env = make(f"khepera_forage/{'Procedural' if 'difficulty' in given else 'Corridor'}{kind}-v1", **kwargs, **given)
    again = make(EnvSpec.from_json(stored(env)))
    assert again.metadata.get("autoreset_mode") == env.metadata.get("autoreset_mode")
    for seed in range(2):
        np.testing.assert_equal(again.reset(seed=seed), env.reset(seed=seed))
        for _ in range(3):
            action = env.action_space.sample()
            np.testing.assert_equal(again.step(action), env.step(action))


OTHER = replace(V0_1, separation=20)


@of_every_form
@pytest.mark.parametrize(("version", "default"), [("v0", V0_1), ("v1", Decisions())])
def test_version_has_its_decisions_unless_others_are_given_and_so_has_its_spec(
    version: str, default: Decisions, make: Callable[..., Any], kind: str, kwargs: dict[str, Any]
) -> None:
    name = f"khepera_forage/Corridor{kind}-{version}"
    for given, decisions in (({}, default), ({"decisions": OTHER}, OTHER)):
        out_of_date = pytest.warns(DeprecationWarning, match=rf"{name} is out of date.*upgrading to version `v1`")
        with out_of_date if version == "v0" else nullcontext():
            env = make(name, **kwargs, **given)
        spec = EnvSpec.from_json(stored(env))
        again: Any
        for again in (env, make(spec), make(pickle.loads(pickle.dumps(spec)))):  # by a spec, without a warning
            own = again.get_attr("decisions") if make is gym.make_vec else [again.unwrapped.decisions]
            assert set(own) == {decisions}
        assert spec.id == name


def test_spec_stored_before_there_were_versions_has_the_decisions_of_version_0_1() -> None:
    for name, kind in (("Corridor", "behaviours"), ("CorridorWheels", "wheels")):
        spec = EnvSpec(f"khepera_forage/{name}-v0", f"khepera_forage.envs.backends:{kind}")
        assert gym.make(spec).unwrapped.decisions == V0_1  # type: ignore[attr-defined]
