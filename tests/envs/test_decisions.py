"""Environments under other decisions, on both backends: versions, stored specs, set-up, rules and times."""

import pickle
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from khepera_forage import Decisions
from khepera_forage.envs import paired_corridors_v0, paired_corridors_v1
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, SPEED_UNIT
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import CORRIDOR, V0_1

pytest.importorskip("numba")

NAMES = ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")
OTHER = replace(V0_1, separation=20)
OF_VERSION = {"v0": V0_1, "v1": Decisions()}
QUIET: dict[str, Any] = {"noise": Noise.none()}
FREE = {"start": (200, 150, 0), "foods": [(100, 500), (300, 500)]}
"""Places in the rectangle where a robot can drive ahead for some rounds."""
FORWARD, LOWER, CLOSE = (0.5, 0.5, 1.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 0.0, 1.0, 1.0)
BACKENDS = ("pymunk", "compiled")
on_both_backends = pytest.mark.parametrize("backend", BACKENDS)
of_both_versions = pytest.mark.parametrize("version", OF_VERSION)


def made(make: Callable[..., Any], name: str, version: str = "v1", **kwargs: Any) -> Any:
    """An environment; v0 with Gymnasium's warning that there is a newer version, v1 without."""
    name = f"khepera_forage/{name}-{version}"
    if version == "v1":
        return make(name, **kwargs)
    with pytest.warns(DeprecationWarning, match=rf"{name} is out of date.*upgrading to version `v1`"):
        return make(name, **kwargs)


# ---------------------------------------------------------------- versions and specs

FORMS: dict[str, tuple[Callable[..., Any], str, dict[str, Any]]] = {
    "pymunk": (gym.make, "Corridor", {"backend": "pymunk"}),
    "compiled": (gym.make, "RectangleWheels", {"backend": "compiled"}),
    "sync": (gym.make_vec, "Corridor", {"num_envs": 2, "vectorization_mode": "sync"}),
    "vector": (gym.make_vec, "CorridorWheels", {"num_envs": 2}),
}


def decisions_of(env: Any) -> Decisions:
    if isinstance(env, gym.vector.VectorEnv):
        one, other = env.get_attr("decisions")  # type: ignore[attr-defined]
        assert one == other
        env.close()
        return one  # type: ignore[no-any-return]
    return env.unwrapped.decisions  # type: ignore[no-any-return]


@pytest.mark.parametrize("form", FORMS)
@of_both_versions
def test_version_has_its_decisions_unless_others_are_given_and_so_has_its_spec(form: str, version: str) -> None:
    assert Decisions() != V0_1
    make, name, kwargs = FORMS[form]
    for given, decisions in (({}, OF_VERSION[version]), ({"decisions": OTHER}, OTHER)):
        env = made(make, name, version, **kwargs, **given)
        spec = env.spec if make is gym.make else env.unwrapped.spec
        assert decisions_of(env) == decisions
        for again in (spec, pickle.loads(pickle.dumps(spec)), EnvSpec.from_json(spec.to_json())):
            remade: Any = make(again)  # by a spec, without a warning
            assert again.id == f"khepera_forage/{name}-{version}"
            assert decisions_of(remade) == decisions


def test_name_without_a_version_makes_the_newest_and_the_newest_without_a_warning() -> None:
    with pytest.warns(UserWarning, match=r"the latest versioned environment `khepera_forage/Corridor-v1`"):
        env: Any = gym.make("khepera_forage/Corridor")
    assert env.unwrapped.decisions == Decisions()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gym.make("khepera_forage/Corridor-v1")


def test_spec_stored_before_there_were_versions_has_the_decisions_of_version_0_1() -> None:
    for name, kind in (("Corridor", "behaviours"), ("CorridorWheels", "wheels")):
        spec = EnvSpec(f"khepera_forage/{name}-v0", f"khepera_forage.envs.backends:{kind}")
        assert gym.make(spec).unwrapped.decisions == V0_1  # type: ignore[attr-defined]


@pytest.mark.parametrize("make", ["env", "raw_env", "parallel_env"])
@pytest.mark.parametrize(("module", "version"), [(paired_corridors_v0, "v0"), (paired_corridors_v1, "v1")])
def test_paired_corridors_have_the_decisions_of_their_version(module: Any, version: str, make: str) -> None:
    for given, decisions in ((None, OF_VERSION[version]), (OTHER, OTHER)):
        env = getattr(module, make)(num_learners=2, decisions=given)
        env.reset(seed=1)
        raw = getattr(env.unwrapped, "aec_env", env).unwrapped
        assert raw.decisions == decisions
        assert all(forager.decisions.separation == decisions.separation for forager in raw.foragers)
        assert env.metadata["name"] == f"paired_corridors_{version}"


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


# ---------------------------------------------------------------- rules


@pytest.mark.parametrize("holes", [1, 2])
@on_both_backends
def test_recall_marker_is_that_of_the_robot(backend: str, holes: int) -> None:
    env = made(gym.make, "Corridor", backend=backend, decisions=Decisions(recall_marker=holes)).unwrapped
    env.reset(seed=1)
    assert env.forager.holes == holes
    assert {region.holes for region in env.world.camera.look().regions} == {0, holes}


# ---------------------------------------------------------------- times


def senses_after(backend: str, decisions: Decisions, action: Any, rounds: int) -> tuple[float, float, float]:
    """x in mm, arm and jaw after some rounds under one action."""
    env = made(gym.make, "RectangleWheels", backend=backend, decisions=decisions, **QUIET).unwrapped
    env.reset(seed=1, options=FREE)
    for _ in range(rounds):
        env.step(np.array(action))
    return env.forager.raw.x * 5.0, env.forager.senses.arm, env.forager.senses.jaw


@on_both_backends
@pytest.mark.parametrize("duration", [0.05, 0.1, 0.25])
def test_round_duration_is_how_long_an_action_lasts(backend: str, duration: float) -> None:
    x, _, _ = senses_after(backend, Decisions(round_duration=duration), FORWARD, 8)
    assert x - 200 == pytest.approx(10 * SPEED_UNIT * 8 * duration, abs=2.5)


@on_both_backends
@pytest.mark.parametrize(("duration", "travel"), [(0.1, 0.4), (0.1, 2.0), (0.2, 0.4), (0.2, 2.0)])
def test_travel_times_are_how_long_arm_and_jaw_take(backend: str, duration: float, travel: float) -> None:
    lowering = Decisions(round_duration=duration, arm_travel_time=travel)
    closing = Decisions(round_duration=duration, jaw_travel_time=travel)
    whole = round(travel / duration)
    for rounds in (1, whole - 1, whole, whole + 1):
        share = min(1.0, rounds * duration / travel)
        _, arm, _ = senses_after(backend, lowering, LOWER, rounds)
        assert arm == pytest.approx(ARM_RAISED + share * (ARM_DOWN - ARM_RAISED), abs=0.5)
        _, _, jaw = senses_after(backend, closing, CLOSE, rounds)
        assert jaw == pytest.approx(JAW_OPEN + share * (JAW_CLOSED - JAW_OPEN), abs=0.5)


def test_training_environments_run_at_the_decided_times() -> None:
    training = TrainingEnv(decisions=Decisions(round_duration=0.2, arm_travel_time=0.4), **QUIET)
    training.reset(seed=1)
    for _ in range(2 * len(training.possible_agents)):
        training.step(int(Behaviour.EXPLORE_FOOD))
    assert [forager.senses.arm for forager in training.foragers] == [ARM_DOWN, ARM_DOWN]
