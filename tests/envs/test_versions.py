"""Versions of the environments: v0 has the decisions of version 0.1, v1 the default ones, unless others are given."""

import pickle
import warnings
from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import gymnasium as gym
import pytest
from gymnasium.envs.registration import EnvSpec

from khepera_forage import Decisions
from khepera_forage.envs import backends, paired_corridors_v0, paired_corridors_v1
from khepera_forage.envs.backends import COMPILED, PYMUNK, EntryPoint, VectorEntryPoint
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv

NAMES = [f"khepera_forage/{name}" for name in ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")]
V0_1 = Decisions.v0_1()
DEFAULTS = replace(V0_1, next_to_food=17, patience=7)
"""Stand for the defaults, so that these tests can tell the versions apart."""
OTHER = replace(V0_1, separation=20)
OF_VERSION = {"v0": V0_1, "v1": DEFAULTS}
BOTH = pytest.mark.parametrize("backend", [PYMUNK, COMPILED])


@pytest.fixture(autouse=True)
def other_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, kind in (("Behaviours", BehavioursEnv), ("Wheels", WheelsEnv)):
        entry_point = EntryPoint(kind, DEFAULTS)
        monkeypatch.setattr(backends, f"{name.lower()}_v1", entry_point)
        vector = VectorEntryPoint(f"{name}VectorEnv", DEFAULTS)
        monkeypatch.setattr(backends, f"{name.lower()}_vector_v1", vector)


def made(make: Callable[..., Any], name: str, version: str, **kwargs: Any) -> Any:
    """An environment; v0 with Gymnasium's warning that there is a newer version, v1 without."""
    if version == "v1":
        return make(f"{name}-{version}", **kwargs)
    with pytest.warns(DeprecationWarning, match=rf"{name}-v0 is out of date.*upgrading to version `v1`"):
        return make(f"{name}-{version}", **kwargs)


def without_numba_skip(backend: str) -> None:
    if backend == COMPILED:
        pytest.importorskip("numba")


@BOTH
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("version", OF_VERSION)
def test_version_has_its_decisions_unless_others_are_given(backend: str, name: str, version: str) -> None:
    without_numba_skip(backend)
    for given, decisions in ((None, OF_VERSION[version]), (OTHER, OTHER)):
        env = made(gym.make, name, version, backend=backend, decisions=given)
        assert env.unwrapped.decisions == decisions
        assert env.unwrapped.backend == backend
    assert made(gym.make, name, version, backend=backend).unwrapped.decisions == OF_VERSION[version]


@pytest.mark.parametrize("mode", ["sync", "async"])
@pytest.mark.parametrize("version", OF_VERSION)
def test_copies_of_make_vec_have_the_decisions_of_their_version(mode: str, version: str) -> None:
    for given, decisions in (({}, OF_VERSION[version]), ({"decisions": OTHER}, OTHER)):
        envs = made(gym.make_vec, NAMES[0], version, num_envs=2, vectorization_mode=mode, **given)
        assert envs.get_attr("decisions") == (decisions, decisions)
        envs.close()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("version", OF_VERSION)
def test_compiled_worlds_of_make_vec_have_the_decisions_of_their_version(name: str, version: str) -> None:
    pytest.importorskip("numba")
    for given, decisions in (({}, OF_VERSION[version]), ({"decisions": OTHER}, OTHER)):
        envs = made(gym.make_vec, name, version, num_envs=2, **given)
        single = gym.make(f"{name}-v1", backend=COMPILED, decisions=decisions)
        observations, _ = envs.reset(seed=3)
        alone, _ = single.reset(seed=4)
        for key, values in observations.items():
            assert values[1].tolist() == alone[key].tolist()
        assert envs.batch.decisions == decisions


def test_name_without_a_version_makes_the_newest() -> None:
    with pytest.warns(
        UserWarning, match=r"Using the latest versioned environment `khepera_forage/Corridor-v1`"
    ):
        env: Any = gym.make(NAMES[0])
    assert env.unwrapped.decisions == DEFAULTS


# ---------------------------------------------------------------- specs


@BOTH
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("version", OF_VERSION)
@pytest.mark.parametrize("decisions", [None, OTHER])
def test_spec_makes_the_same_environment_again(
    backend: str, name: str, version: str, decisions: Decisions | None
) -> None:
    without_numba_skip(backend)
    env = made(gym.make, name, version, backend=backend, decisions=decisions)
    for spec in (env.spec, pickle.loads(pickle.dumps(env.spec)), EnvSpec.from_json(env.spec.to_json())):
        again: Any = gym.make(spec)  # by a spec, without a warning
        assert again.spec.id == f"{name}-{version}"
        assert again.unwrapped.decisions == env.unwrapped.decisions
        assert again.unwrapped.backend == backend


@pytest.mark.parametrize("version", OF_VERSION)
def test_spec_of_compiled_worlds_makes_them_again(version: str) -> None:
    pytest.importorskip("numba")
    for given, decisions in (({}, OF_VERSION[version]), ({"decisions": OTHER}, OTHER)):
        envs = made(gym.make_vec, NAMES[1], version, num_envs=2, **given)
        for spec in (envs.spec, EnvSpec.from_json(envs.spec.to_json())):
            again: Any = gym.make_vec(spec)
            assert (again.num_envs, again.batch.decisions) == (2, decisions)


def test_spec_stored_before_there_were_versions_has_the_decisions_of_version_0_1() -> None:
    for name, kind in (("Corridor", "behaviours"), ("CorridorWheels", "wheels")):
        spec = EnvSpec(f"khepera_forage/{name}-v0", f"khepera_forage.envs.backends:{kind}")
        assert gym.make(spec).unwrapped.decisions == V0_1  # type: ignore[attr-defined]


@BOTH
@pytest.mark.parametrize("given", [{"next_to_food": 17}, {}, asdict(V0_1) | {"next_to_foot": 17}])
def test_mapping_without_exactly_all_fields_is_refused(backend: str, given: dict[str, Any]) -> None:
    without_numba_skip(backend)
    with pytest.raises(
        ValueError, match=r"decisions is \{.*\}; allowed: a khepera_forage\.Decisions, or None"
    ):
        gym.make("khepera_forage/Corridor-v1", backend=backend, decisions=given)


# ---------------------------------------------------------------- the paired corridors


@pytest.mark.parametrize("make", ["env", "raw_env", "parallel_env"])
@pytest.mark.parametrize(("module", "version"), [(paired_corridors_v0, "v0"), (paired_corridors_v1, "v1")])
def test_paired_corridors_have_the_decisions_of_their_version(
    module: Any, version: str, make: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(TrainingEnv, "default_decisions", DEFAULTS)
    for given, decisions in ((None, OF_VERSION[version]), (OTHER, OTHER)):
        env = getattr(module, make)(num_learners=2, decisions=given)
        raw = getattr(env.unwrapped, "aec_env", env).unwrapped
        assert raw.decisions == decisions
        assert len(raw.possible_agents) == 3
        assert env.metadata["name"] == f"paired_corridors_{version}"


def test_newest_version_has_the_default_decisions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in NAMES:
            env: Any = gym.make(f"{name}-v1")
            assert env.unwrapped.decisions == Decisions()
    assert paired_corridors_v1.raw_env().decisions == Decisions()
