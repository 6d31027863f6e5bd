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

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}


def _one(backend: str, name: str = "Corridor", **kwargs: Any) -> Any:
    kwargs = {"arena": POOL} | kwargs
    return gym.make(f"khepera_forage/{name}-v1", backend=backend, **kwargs).unwrapped


def _many(num_envs: int, name: str = "Corridor", **kwargs: Any) -> Any:
    return gym.make_vec(f"khepera_forage/{name}-v1", num_envs=num_envs, **({"arena": POOL} | kwargs))


def _same(one: Any, two: Any) -> bool:
    return set(one) == set(two) and all(np.array_equal(one[key], two[key]) for key in one)


def test_forgotten_arenas_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arenas of ended episodes are prepared again when a world enters them again."""
    every, forgetful = (_many(4, arena=ProceduralArenas("easy", num_levels=12), limit=15) for _ in range(2))
    (_, infos), (_, known) = every.reset(seed=2), forgetful.reset(seed=2)
    for _ in range(200):
        with monkeypatch.context() as patch:
            patch.setattr(PreparedArenas, "_MOST_BYTES", 1)
            known = forgetful.step(known["correct_behaviour"])[4]
        infos = every.step(infos["correct_behaviour"])[4]
        assert _same(known, infos)
        assert forgetful.unwrapped.batch.arenas == every.unwrapped.batch.arenas


def test_teacher_forages_in_kernels_as_in_environments() -> None:
    seed = 2**64 - 20  # also beyond 64 bits
    episodes = run_teacher(POOL, 40, seed=seed)
    env = _many(40)
    _, infos = env.reset(seed=seed)
    over = np.zeros(40, np.bool_)
    for _ in range(500):
        _, _, ends, cuts, infos = env.step(infos["correct_behaviour"])
        done = ~over & (ends | cuts)
        assert np.array_equal(infos["steps"][done], episodes.steps[done])
        assert np.array_equal(infos["score"][done], episodes.score[done])
        over |= ends | cuts
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


def test_names_and_arenas_make_the_same_pool() -> None:
    """A name has the places of the decisions, as in an environment of this arena alone."""
    names: list[Arena | str] = ["corridor", HALL, "t_maze"]
    decisions = Decisions(home_to_wall=100.0)
    arenas = [checked_arena(given, decisions) for given in names]
    paired = [TrainingEnv(arena=given, decisions=decisions) for given in (names, arenas)]
    many = [_many(9, arena=given, decisions=decisions) for given in (names, arenas)]
    for pair in (
        [_one("pymunk", arena=given, decisions=decisions) for given in (names, arenas)],
        [_one("compiled", arena=given, decisions=decisions) for given in (names, arenas)],
        many,
    ):
        assert pair[0].observation_space == pair[1].observation_space
        for seed in range(5):
            assert _same(*(env.reset(seed=seed)[0] for env in pair))
    assert {arena.name for arena in many[0].unwrapped.batch.arenas} == {"corridor", "hall", "t_maze"}
    for seed in range(5):
        for env in paired:
            env.reset(seed=seed)
        assert paired[0].arenas == paired[1].arenas
        assert paired[0].arena_of(seed) == paired[0].arenas[0]
    teachers = [run_teacher(given, 9, limit=200, decisions=decisions) for given in (names, arenas)]
    assert np.array_equal(teachers[0].start, teachers[1].start)
    assert np.array_equal(teachers[0].score, teachers[1].score)


def test_a_million_levels_are_drawn_when_they_are_used() -> None:
    levels = ProceduralArenas("easy", num_levels=10**6)
    procedural_arena.cache_clear()
    for env in (_one("pymunk", arena=levels), _one("compiled", arena=levels), _many(2, arena=levels)):
        env.reset(seed=8)
    assert run_teacher(levels, 2, seed=8, limit=5).steps.tolist() == [5, 5]
    assert procedural_arena.cache_info().misses == 3, "the first level, and those of two seeds"
