"""What PettingZoo and its users expect of the training environment."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from khepera_forage.envs import paired_corridors_v0, paired_corridors_v1, paired_corridors_wheels_v1

with warnings.catch_warnings():
    # PettingZoo's own test module imports one of its deprecated environments.
    warnings.simplefilter("ignore", DeprecationWarning)
    from pettingzoo.test import api_test, max_cycles_test, parallel_api_test, parallel_seed_test, render_test, seed_test


@pytest.mark.parametrize(
    ("module", "kwargs"),
    [
        (paired_corridors_v0, {}),
        (paired_corridors_v1, {}),
        (paired_corridors_v1, {"num_learners": 3}),
        (paired_corridors_v1, {"backend": "compiled"}),
        (paired_corridors_wheels_v1, {"num_learners": 2}),
    ],
)
def test_api_and_parallel_tests_pass(module: Any, kwargs: dict[str, Any]) -> None:
    api_test(module.env(max_cycles=30, **kwargs), num_cycles=100)
    parallel_api_test(module.parallel_env(max_cycles=30, **kwargs), num_cycles=60)
    parallel_seed_test(lambda: module.parallel_env(max_cycles=20, **kwargs), num_cycles=20)


def test_seed_test_passes() -> None:
    seed_test(lambda: paired_corridors_v1.env(max_cycles=50), num_cycles=60)


@pytest.mark.parametrize("module", [paired_corridors_v0, paired_corridors_v1])
def test_max_cycles_test_passes(module: Any) -> None:
    max_cycles_test(module)


def test_render_test_passes() -> None:
    def make(**kwargs: Any) -> Any:
        return paired_corridors_v1.env(max_cycles=30, **kwargs)

    modes: dict[str, Callable[[Any], bool]] = {"rgb_array": lambda frame: frame.shape[2] == 3, "human": lambda _: True}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SDL_VIDEODRIVER", "dummy")
        render_test(make, modes)


@pytest.mark.parametrize("module", [paired_corridors_v1, paired_corridors_wheels_v1])
@pytest.mark.parametrize("form", ["env", "parallel_env"])
def test_state_is_what_all_agents_observe(module: Any, form: str) -> None:
    env = getattr(module, form)(num_learners=2)
    env.reset(seed=1)
    own = env.unwrapped
    np.testing.assert_array_equal(env.state(), np.concatenate([own.observe(a) for a in own.possible_agents]))
    assert env.state_space == own.state_space
    assert env.state_space.contains(env.state())


def test_parallel_learner_hears_the_last_round() -> None:
    env = paired_corridors_v1.parallel_env(max_cycles=50)
    env.reset(seed=2)
    for heard in (3, 7, 10):
        observations, *_ = env.step({"teacher_0": heard, "learner_0": 10})
        assert observations["learner_0"][5] == heard
