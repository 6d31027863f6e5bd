"""Compiled worlds in several arenas: the same arenas, layouts and episodes as in one arena after the other."""

import copy
import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.counter_rng import key_of, keys_of
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.compiled.arenas import PreparedArenas
from khepera_forage.rollouts.compiled.recalls import TEACHER, Recalls, run_teacher
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.procedural import ProceduralArenas, procedural_arena
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import arena_number
from tests.arenas import BLOCKS, HALL, L_ROOM, POOL

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}


def _one(backend: str, name: str = "Corridor", **kwargs: Any) -> Any:
    kwargs = {"arena": POOL} | kwargs
    return gym.make(f"khepera_forage/{name}-v1", backend=backend, **kwargs).unwrapped


def _many(num_envs: int, name: str = "Corridor", **kwargs: Any) -> Any:
    return gym.make_vec(f"khepera_forage/{name}-v1", num_envs=num_envs, **({"arena": POOL} | kwargs))


def _same(one: Any, two: Any) -> bool:
    return set(one) == set(two) and all(np.array_equal(one[key], two[key]) for key in one)


def test_arena_numbers_are_the_same_for_one_world_and_for_many() -> None:
    seeds, episodes = np.arange(200, dtype=np.uint64), np.arange(200, dtype=np.uint64) % 7
    numbers = arena_number(keys_of(seeds), episodes, 3)
    assert numbers.tolist() == [arena_number(key_of(s), s % 7, 3) for s in range(200)]
    assert np.bincount(numbers.astype(int)).min() > 40


def test_seed_has_the_same_arenas_and_layouts_on_both_backends() -> None:
    one, other = _one("pymunk", foods=2), _one("compiled", foods=2)
    seen = set()
    for seed in range(6):
        for begin in ({"seed": seed}, {}, {}):
            one.reset(**begin)
            other.reset(**begin)
            assert one.arena == other.arena
            assert (one.diagonal, one.home_radius) == (other.diagonal, other.home_radius)
            np.testing.assert_allclose(one.layout.starts, other.layout.starts, atol=1e-9)
            np.testing.assert_allclose(one.layout.foods, other.layout.foods, atol=1e-9)
            assert one.world.arenas == other.world.arenas == (one.arena,)
            seen.add(one.arena.name)
    assert seen == {"hall", "L-room", "blocks"}


@pytest.mark.parametrize("name", ["Corridor", "CorridorWheels"])
def test_batch_has_the_episodes_of_single_worlds_bit_for_bit(name: str) -> None:
    """Kernels with lists of near walls in 128 lanes, and those of one arena in one lane."""
    kwargs: Any = {"limit": 120, "food_types": MIXED, "foods": 2}
    many, ones = _many(5, name, **kwargs), [_one("compiled", name, **kwargs) for _ in range(5)]
    many.action_space.seed(0)
    observations, infos = many.reset(seed=3)
    begun = [env.reset(seed=3 + i) for i, env in enumerate(ones)]
    over, seen = [False] * 5, set()
    for _ in range(400):
        for i, (observation, info) in enumerate(begun):
            assert _same(observation, {key: values[i] for key, values in observations.items()})
            assert _same(info, {key: infos[key][i] for key in info})
        assert many.unwrapped.batch.arenas == [env.arena for env in ones]
        seen |= {env.arena.name for env in ones}
        actions = many.action_space.sample() if name == "CorridorWheels" else infos["correct_behaviour"]
        observations, rewards, ends, cuts, infos = many.step(actions)
        for i, env in enumerate(ones):
            if over[i]:
                begun[i], over[i] = env.reset(), False
            else:
                observation, reward, end, cut, info = env.step(actions[i])
                assert (reward, end, cut) == (rewards[i], ends[i], cuts[i])
                begun[i], over[i] = (observation, info), end or cut
    assert seen == {"hall", "L-room", "blocks"}


def test_episodes_are_those_of_an_environment_with_the_arena_alone() -> None:
    """Given the same layout and random numbers; the key of a world does not depend on its arena."""
    pool = _one("compiled")
    for seed in range(4):
        observation, _ = pool.reset(seed=seed)
        alone = _one("compiled", arena=pool.arena)
        expected, info = alone.reset(seed=seed)
        assert pool.layout == alone.layout
        for _ in range(60):
            assert _same(observation, expected)
            observation = pool.step(info["correct_behaviour"])[0]
            expected, _, end, cut, info = alone.step(info["correct_behaviour"])
            if end or cut:
                break


def test_forgotten_arenas_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arenas of ended episodes are prepared again when a world enters them again."""
    arenas = ProceduralArenas("easy", num_levels=12)
    every = _many(4, arena=arenas, limit=15)
    forgetful = _many(4, arena=arenas, limit=15)
    (_, infos), (_, known) = every.reset(seed=2), forgetful.reset(seed=2)
    most = 0
    for _ in range(200):
        monkeypatch.setattr(PreparedArenas, "_MOST_BYTES", 1)
        known = forgetful.step(known["correct_behaviour"])[4]
        monkeypatch.undo()
        infos = every.step(infos["correct_behaviour"])[4]
        assert _same(known, infos)
        assert forgetful.unwrapped.batch.arenas == every.unwrapped.batch.arenas
        most = max(most, len(forgetful.unwrapped.batch._arenas._place_of))
    assert most <= 9, "of one round, and of the round before"
    assert len(every.unwrapped.batch._arenas._place_of) == 12


def test_recalls_keep_their_arenas_and_do_not_depend_on_earlier_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    levels, teacher = ProceduralArenas("easy", num_levels=1000), np.full(9, TEACHER)
    alone = run_teacher(levels, 9, seed=3, limit=40)
    recalls, prepared, runs = Recalls(levels, limit=40), [], []
    for seed in (0, 0, 3):
        runs.append(recalls.run(None, teacher, seed))
        prepared.append(len(recalls._arenas._place_of))
    assert prepared[0] == prepared[1] <= 10, "those of one run, and the first one"
    assert prepared[1] < prepared[2] <= 19
    monkeypatch.setattr(PreparedArenas, "_MOST_BYTES", 1)
    runs.append(recalls.run(None, teacher, seed=3))
    assert len(recalls._arenas._place_of) <= 10, "those of earlier runs are forgotten"
    for again, expected in zip(runs, (runs[0], runs[0], alone, alone), strict=True):
        assert all(np.array_equal(ours, theirs) for ours, theirs in zip(again, expected, strict=True))


def test_worlds_do_not_depend_on_their_number() -> None:
    few, many = _many(3), _many(300)
    (_, infos), (_, all_infos) = few.reset(seed=9), many.reset(seed=9)
    for _ in range(200):
        assert _same(infos, {key: values[:3] for key, values in all_infos.items()})
        infos = few.step(infos["correct_behaviour"])[4]
        all_infos = many.step(all_infos["correct_behaviour"])[4]


def test_resets_of_some_worlds_leave_the_others() -> None:
    env = _many(40)
    _, infos = env.reset(seed=1)
    for _ in range(5):
        infos = env.step(infos["correct_behaviour"])[4]
    twin, mask = copy.deepcopy(env), np.arange(40) % 3 == 0
    arenas = env.unwrapped.batch.arenas
    env.reset(seed=50, options={"reset_mask": mask})
    fresh = _many(40)
    fresh.reset(seed=50)
    now, new = env.unwrapped.batch.arenas, fresh.unwrapped.batch.arenas
    assert now == [new[i] if mask[i] else arenas[i] for i in range(40)]
    actions = infos["correct_behaviour"]
    ours, others, remade = env.step(actions)[0], twin.step(actions)[0], fresh.step(actions)[0]
    for key in ours:
        assert np.array_equal(ours[key][~mask], others[key][~mask])
        assert np.array_equal(ours[key][mask], remade[key][mask])


def test_teacher_forages_in_kernels_as_in_environments() -> None:
    episodes = run_teacher(POOL, 40, seed=2)
    env = _many(40)
    _, infos = env.reset(seed=2)
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
    for backend in ("pymunk", "compiled"):
        one, other = (_one(backend, arena=given, decisions=decisions) for given in (names, arenas))
        assert one.observation_space == other.observation_space
        for seed in range(5):
            assert _same(one.reset(seed=seed)[0], other.reset(seed=seed)[0])
            assert one.arena == other.arena
    by_name, by_arena = (_many(9, arena=given, decisions=decisions) for given in (names, arenas))
    assert _same(by_name.reset(seed=0)[0], by_arena.reset(seed=0)[0])
    assert {arena.name for arena in by_name.unwrapped.batch.arenas} == {"corridor", "hall", "t_maze"}
    one, other = (
        run_teacher(names, 9, limit=200, decisions=decisions),
        run_teacher(arenas, 9, limit=200, decisions=decisions),
    )
    assert np.array_equal(one.start, other.start)
    assert np.array_equal(one.score, other.score)


def test_arenas_are_prepared_when_they_are_drawn() -> None:
    prepared: list[str] = []

    class Lazy(tuple[Arena, ...]):
        def __getitem__(self, number: Any) -> Any:
            arena = super().__getitem__(number)
            prepared.append(arena.name)
            return arena

    arenas = Lazy((HALL, L_ROOM, BLOCKS))
    arenas.diagonal = 2000.0  # type: ignore[attr-defined]
    for backend in ("pymunk", "compiled"):
        prepared.clear()
        env = _one(backend, arena=arenas)
        assert env.observation_space["robot_home_distance"].high == 400
        assert set(prepared) == {"hall"}
        seed = next(s for s in range(20) if arena_number(key_of(s), 0, 3) == 2)
        env.reset(seed=seed)
        assert set(prepared) == {"hall", "blocks"}


def test_a_million_levels_are_drawn_when_they_are_used() -> None:
    levels = ProceduralArenas("easy", num_levels=10**6)
    procedural_arena.cache_clear()
    for env in (_one("pymunk", arena=levels), _one("compiled", arena=levels), _many(2, arena=levels)):
        env.reset(seed=8)
    assert run_teacher(levels, 2, seed=8, limit=5).steps.tolist() == [5, 5]
    assert procedural_arena.cache_info().misses == 3, "the first level, and those of two seeds"


def test_worlds_change_to_arenas_with_more_walls() -> None:
    """The first arena has the fewest walls, corners and waypoints."""
    env = _many(2)
    seeds = [next(s for s in range(40) if arena_number(key_of(s), 0, 3) == number) for number in range(3)]
    env.reset(seed=[seeds[0], seeds[0]])
    env.reset(seed=[seeds[1], None], options={"reset_mask": np.array([True, False])})
    env.reset(seed=[seeds[2], None], options={"reset_mask": np.array([True, False])})
    batch = env.unwrapped.batch
    assert [arena.name for arena in batch.arenas] == ["blocks", "hall"]


@pytest.mark.parametrize("name", ["Corridor", "CorridorWheels"])
def test_gymnasium_checker_passes(name: str) -> None:
    for backend in ("pymunk", "compiled"):
        check_env(_one(backend, name))


def test_copies_go_on_alike() -> None:
    env = _one("compiled")
    env.reset(seed=2)
    twins = [pickle.loads(pickle.dumps(env)), copy.deepcopy(env)]
    for _ in range(3):
        expected, _ = env.reset()
        steps = [env.step(0)[0] for _ in range(5)]
        for twin in twins:
            assert _same(twin.reset()[0], expected)
            assert twin.arena == env.arena
            assert all(_same(twin.step(0)[0], step) for step in steps)


@pytest.mark.parametrize(
    ("arenas", "message"),
    [
        ((), "at least one arena"),
        ((HALL, "nowhere"), "arena 1 of a sequence is 'nowhere'; allowed: an Arena, or one of 'corridor'"),
        (["corridor", 3], "arena 1 of a sequence is 3; allowed: an Arena, or one of 'corridor'"),
        (7, "arena is 7; allowed: an Arena"),
    ],
)
def test_bad_pools_are_quoted(arenas: Any, message: str) -> None:
    for backend in ("pymunk", "compiled"):
        with pytest.raises(ValueError, match=message):
            _one(backend, arena=arenas)
    with pytest.raises(ValueError, match=message):
        _many(2, arena=arenas)
    with pytest.raises(ValueError, match=message):
        run_teacher(arenas, 1)
