"""Compiled worlds in several arenas: the same arenas, layouts and episodes as in one arena after the other."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.compiled.arenas import PreparedArenas
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.procedural import ProceduralArenas, procedural_arena
from khepera_forage.task.decisions import Decisions
from tests.arenas import HALL, POOL


def _one(backend: str, arena: Any = POOL, **kwargs: Any) -> Any:
    return gym.make("khepera_forage/Corridor-v1", backend=backend, arena=arena, **kwargs).unwrapped


def _many(num_envs: int, arena: Any = POOL, **kwargs: Any) -> Any:
    return gym.make_vec("khepera_forage/Corridor-v1", num_envs=num_envs, arena=arena, **kwargs)


def test_forgotten_arenas_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arenas of ended episodes are prepared again when a world enters them again."""
    every, forgetful = (_many(4, arena=ProceduralArenas("easy", num_levels=12), limit=15) for _ in range(2))
    (_, infos), (_, known) = every.reset(seed=2), forgetful.reset(seed=2)
    for _ in range(200):
        with monkeypatch.context() as patch:
            patch.setattr(PreparedArenas, "_MOST_BYTES", 1)
            known = forgetful.step(known["correct_behaviour"])[4]
        infos = every.step(infos["correct_behaviour"])[4]
        np.testing.assert_equal(known, infos)
        assert forgetful.unwrapped.batch.arenas == every.unwrapped.batch.arenas


def test_teacher_forages_in_kernels_as_in_environments() -> None:
    """Whatever the number of worlds: kernels and environments share them out to threads in other ways."""
    seed = 2**64 - 20  # also beyond 64 bits
    episodes, env, over = run_teacher(POOL, 200, seed=seed), _many(200), np.zeros(200, np.bool_)
    _, infos = env.reset(seed=seed)
    for _ in range(500):
        _, _, ends, cuts, infos = env.step(infos["correct_behaviour"])
        done = ~over & (ends | cuts)
        for name in ("steps", "score", "delivered"):
            np.testing.assert_array_equal(infos[name][done], getattr(episodes, name)[done])
        over |= done
        if over.all():
            break
    assert over.all()
    assert episodes.delivered.mean() > 0.9


def test_places_are_checked_in_the_arena_of_the_episode() -> None:
    """(520, 380) is free in the hall, outside the L-room, and in a block of the third arena."""
    for env in (_one("pymunk"), _one("compiled"), _many(1)):
        results = set()
        for seed in range(12):
            try:
                env.reset(seed=seed, options={"foods": [(520, 200)], "start": (200, 200, 0)})
                results.add("free")
                env.reset(seed=seed, options={"foods": [(520, 380)]})
            except ValueError as error:
                results.add(str(error).partition(":")[0])
        assert results == {"free", "blocks", "L-room"}


def test_names_in_a_pool_have_the_places_of_the_decisions() -> None:
    names: list[Arena | str] = ["corridor", HALL, "t_maze"]
    decisions = Decisions(home_to_wall=100.0)
    arenas = [checked_arena(given, decisions) for given in names]
    singles = [_one(backend, arena=names, decisions=decisions) for backend in ("pymunk", "compiled")]
    for env in (*singles, TrainingEnv(arena=names, decisions=decisions)):
        met = []
        for seed in range(9):
            env.reset(seed=seed)
            met.append(env.world.arenas[0])
        assert set(met) == set(arenas)
    env = _many(9, arena=names, decisions=decisions)
    env.reset(seed=0)
    assert set(env.get_attr("arena")) == set(arenas)
    teachers = [run_teacher(given, 9, limit=200, decisions=decisions) for given in (names, arenas)]
    np.testing.assert_equal(teachers[0]._asdict(), teachers[1]._asdict())


def test_a_million_levels_are_drawn_when_they_are_used() -> None:
    levels = ProceduralArenas("easy", num_levels=10**6)
    procedural_arena.cache_clear()
    for env in (_one("pymunk", arena=levels), _one("compiled", arena=levels), _many(2, arena=levels)):
        env.reset(seed=8)
    assert run_teacher(levels, 2, seed=8, limit=5).steps.tolist() == [5, 5]
    assert procedural_arena.cache_info().misses == 3, "the first level, and those of two seeds"
