"""Each entrance is compiled once: whatever differs between worlds, rollouts and trainings is read at run time."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium as gym
import numba
import numpy as np
from numba.core import event

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions
from khepera_forage.envs.compiled.one_world import _step_one
from khepera_forage.envs.compiled.rounds import step_all
from khepera_forage.noise import Noise
from khepera_forage.policies.nearest_neighbour.memories import memories_of
from khepera_forage.rollouts.compiled.recalls import run_recalls, run_teacher
from khepera_forage.rollouts.compiled.rollout_kernel import run_all
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.compiled.training_kernel import train_all

ENTRANCES: tuple[Any, ...] = (step_all, _step_one, run_all, train_all)
OTHER = Decisions(next_to_food=17, round_duration=0.2, equal_distance="farther state", recall_marker=1)


class _Compilations(event.Listener):
    """Counts the functions that numba compiles."""

    def __init__(self) -> None:
        self.count = 0

    def on_start(self, event: Any) -> None:
        self.count += 1

    def on_end(self, event: Any) -> None:
        pass


@contextmanager
def _nothing_compiled() -> Iterator[None]:
    """Neither numba compiles nor an entrance gets another signature, which may be loaded from disk."""
    listener, before = _Compilations(), [len(entrance.signatures) for entrance in ENTRANCES]
    with event.install_listener("numba:compile", listener):
        yield
    assert listener.count == 0
    assert [len(entrance.signatures) for entrance in ENTRANCES] == before


def _play(env: Any) -> None:
    env.reset(seed=0)
    env.step(env.action_space.sample())
    env.reset()
    env.close()


def _play_both(name: str, num_envs: int = 3, **kwargs: Any) -> None:
    """A single compiled environment and a vector environment."""
    _play(gym.make(f"khepera_forage/{name}-v1", backend="compiled", **kwargs))
    _play(gym.make_vec(f"khepera_forage/{name}-v1", num_envs=num_envs, **kwargs))


def test_other_decisions_compile_nothing() -> None:
    _play_both("Corridor")
    with _nothing_compiled():
        _play_both("Corridor", decisions=OTHER)
        _play_both("RectangleWheels", decisions=OTHER)


def test_other_environments_compile_nothing() -> None:
    """Arenas, numbers of worlds and food objects, noise, limits and kinds of action."""
    _play_both("Corridor")
    with _nothing_compiled():
        for name in ("Rectangle", "CorridorWheels", "RectangleWheels"):
            _play_both(name, 600, noise=Noise.none(), limit=9, food_types="PUSHABLE")
        _play_both("Rectangle", foods=5, render_mode=None)


def test_other_rollouts_compile_nothing() -> None:
    run_teacher("corridor", 3)
    train_learners(1)
    with _nothing_compiled():
        memories = memories_of([([(0, 50, 0, 215, 40)], [1])])
        arguments: Any = {
            "foods": 4,
            "limit": 20,
            "noise": Noise.none(),
            "wheel_speed": 0.9,
            "decisions": OTHER,
        }
        run_recalls("rectangle", memories, np.zeros(300, np.int64), np.arange(300), **arguments)
        train_learners(3, episodes=2, noise=Noise.none(), patience=50, food_types="POISONOUS")
        train_learners(1, options={"foods": [(300, 115)]}, decisions=Decisions(separation=20))


def test_threads_do_not_matter_for_compilation() -> None:
    run_teacher("corridor", 3)
    threads = numba.get_num_threads()
    with _nothing_compiled():
        numba.set_num_threads(1)
        run_teacher("corridor", 300)
        numba.set_num_threads(threads)


def test_entrances_have_one_signature() -> None:
    """In whatever way they were called before: one for a single arena, and one for several."""
    _play_both("Corridor")
    run_teacher("corridor", 3)
    train_learners(1)
    for entrance in ENTRANCES:
        several = ["Near(" in str(signature) for signature in entrance.signatures]
        assert len(several) == len(set(several)), entrance
