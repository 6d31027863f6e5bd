"""One seed, one episode: start, food places and food types are the same on both backends, also in vector environments.

World i of a vector environment with seed S has the episodes of a single environment with seed S + i.
"""

from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.world import Layout
from tests.arenas import BLOCKS

pytest.importorskip("numba")

NAMES = ("Corridor", "RectangleWheels")
SEED, WORLDS, EPISODES, LIMIT = 7, 5, 3, 2
ODDS = {"pickable": 2, "pushable": 1, "poisonous": 1}


class Begun(NamedTuple):
    """How an episode begins."""

    layout: Layout
    types: list[int]


def _make(name: str, **kwargs: Any) -> Any:
    return gym.make(f"khepera_forage/{name}-v1", limit=LIMIT, food_types=ODDS, **kwargs).unwrapped


def _make_vec(name: str, **kwargs: Any) -> Any:
    env_id = f"khepera_forage/{name}-v1"
    return gym.make_vec(env_id, num_envs=WORLDS, limit=LIMIT, food_types=ODDS, **kwargs)


def _begun(env: Any) -> Begun:
    return Begun(env.layout, [int(food.type) for food in env.forager.tracker.foods])


def _begun_in(env: Any) -> list[Begun]:
    """One for each world of a vector environment, directly after its reset."""
    if isinstance(env, gym.vector.SyncVectorEnv):
        return [_begun(single.unwrapped) for single in env.envs]
    worlds = env.batch.worlds
    begun = []
    for i in range(WORLDS):
        start = Pose(*(float(worlds.robots[name][i, 0]) for name in ("x", "y", "heading")))
        places = tuple(Point(float(food["x"]), float(food["y"])) for food in worlds.foods[i])
        begun.append(Begun(Layout((start,), places), worlds.objects[i]["type"].tolist()))
    return begun


def _still(env: Any) -> Any:
    """The action of EXPLORE FOOD or of wheels at rest: nothing moves, so that every episode reaches its limit."""
    shape = env.action_space.shape
    return np.full(shape, 3) if env.action_space.dtype == np.int64 else np.zeros(shape)


def _expected(name: str, **kwargs: Any) -> list[list[Begun]]:
    """The first episodes of single environments on pymunk, one list a world."""
    env = _make(name, **kwargs)
    worlds: list[list[Begun]] = []
    for seed in range(SEED, SEED + WORLDS):
        worlds.append([])
        for episode in range(EPISODES):
            env.reset(seed=seed if episode == 0 else None)
            worlds[-1].append(_begun(env))
    return worlds


def test_seeds_and_episodes_differ_and_food_types_vary() -> None:
    expected = _expected("Rectangle")
    assert len({begun.layout for world in expected for begun in world}) == WORLDS * EPISODES
    assert {food_type for world in expected for begun in world for food_type in begun.types} == {1, 2, 3}


@pytest.mark.parametrize("name", NAMES)
def test_single_environments_begin_alike(name: str) -> None:
    env = _make(name, backend="compiled")
    for seed, world in enumerate(_expected(name), SEED):
        for episode, expected in enumerate(world):
            env.reset(seed=seed if episode == 0 else None)
            assert _begun(env) == expected
            for _ in range(episode):  # an episode may be left before its end
                env.step(_still(env))


@pytest.mark.parametrize("mode", ["vector_entry_point", "sync"])
@pytest.mark.parametrize("name", NAMES)
def test_worlds_of_vector_environments_begin_alike(name: str, mode: str) -> None:
    env = _make_vec(name, vectorization_mode=mode)
    expected = _expected(name)
    for episode in range(EPISODES):
        env.reset(seed=SEED if episode == 0 else None)
        assert _begun_in(env) == [world[episode] for world in expected]
    seeds = [SEED + i for i in (3, 0, 4, 1, 2)]
    env.reset(seed=seeds)
    assert _begun_in(env) == [expected[seed - SEED][0] for seed in seeds]
    env.close()


@pytest.mark.parametrize("mode", ["vector_entry_point", "sync"])
@pytest.mark.parametrize("autoreset", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("name", NAMES)
def test_worlds_begin_alike_after_autoreset(name: str, autoreset: AutoresetMode, mode: str) -> None:
    own: Any = {"autoreset_mode": autoreset}
    env = _make_vec(name, vectorization_mode=mode, **({"vector_kwargs": own} if mode == "sync" else own))
    expected = _expected(name)
    env.reset(seed=SEED)
    for episode in range(1, EPISODES):
        for _ in range(LIMIT + (autoreset == AutoresetMode.NEXT_STEP)):
            env.step(_still(env))
        assert _begun_in(env) == [world[episode] for world in expected]
    env.close()


def test_reset_mask_begins_the_next_episode_of_some_worlds() -> None:
    env = _make_vec("Rectangle", autoreset_mode="Disabled")
    expected = _expected("Rectangle")
    env.reset(seed=SEED)
    env.reset(options={"reset_mask": np.array([True, False, False, True, False])})
    assert _begun_in(env) == [
        world[episode] for world, episode in zip(expected, (1, 0, 0, 1, 0), strict=True)
    ]
    env.reset(seed=[None, 40, None, None, None])
    begun = _begun_in(env)
    assert [begun[0], begun[2], begun[3], begun[4]] == [
        expected[i][n] for i, n in ((0, 2), (2, 1), (3, 2), (4, 1))
    ]


@pytest.mark.parametrize(
    "kwargs",
    [
        {"decisions": Decisions(food_to_walls=80, food_spacing=150, close_to_food=40, home_radius=80)},
        {"noise": Noise.none()},
        {"foods": 5},
        {"arena": BLOCKS, "foods": 3},
    ],
    ids=("decisions", "noise", "foods", "arena"),
)
def test_episodes_begin_alike_with_other_arguments(kwargs: Any) -> None:
    expected = _expected("Rectangle", **kwargs)
    env = _make_vec("Rectangle", **kwargs)
    env.reset(seed=SEED)
    assert _begun_in(env) == [world[0] for world in expected]
    single = _make("Rectangle", backend="compiled", **kwargs)
    single.reset(seed=SEED)
    assert _begun(single) == expected[0][0]


@pytest.mark.parametrize(
    "options",
    [
        {"start": (200, 300, 90)},
        {"foods": [(150, 450), (480, 150)]},
        {"start": (200, 300, 90), "foods": [(150, 450), (480, 150)]},
    ],
    ids=("start", "foods", "both"),
)
def test_what_options_leave_open_is_drawn_alike(options: Any) -> None:
    env = _make("Rectangle")
    expected = []
    for seed in range(SEED, SEED + WORLDS):
        env.reset(seed=seed, options=options)
        expected.append(_begun(env))
    compiled = _make_vec("Rectangle")
    compiled.reset(seed=SEED, options=options)
    assert _begun_in(compiled) == expected
    env.reset(seed=SEED)
    compiled.reset(seed=SEED)
    for given in (options, None):  # options hold for one episode only
        env.reset(options=given)
        compiled.reset(options=given)
        assert _begun_in(compiled)[0] == _begun(env)


@pytest.mark.parametrize("seed", [0, 2**63 - 1, 2**63, 2**64 - 1, 2**64, 2**200 + 3])
def test_seeds_of_any_size_begin_alike(seed: int) -> None:
    env = _make("Rectangle")
    env.reset(seed=seed)
    compiled = _make("Rectangle", backend="compiled")
    compiled.reset(seed=seed)
    assert _begun(compiled) == _begun(env)
    many = _make_vec("Rectangle")
    many.reset(seed=[seed, *range(1, WORLDS)])
    assert _begun_in(many)[0] == _begun(env)
    many.reset(seed=seed)
    assert _begun_in(many)[0] == _begun(env)
    env.reset(seed=seed + 1)
    assert _begun_in(many)[1] == _begun(env)


@pytest.mark.parametrize(
    "make",
    [
        BehavioursEnv,
        lambda: BehavioursEnv(backend="compiled"),
        TrainingEnv,
        lambda: gym.make_vec("khepera_forage/Corridor-v1", num_envs=2),
    ],
)
def test_generator_that_was_set_decides_the_episodes_that_follow(make: Any) -> None:
    env = make()

    def places() -> list[Any]:
        if isinstance(env, gym.vector.VectorEnv):
            return env.reset()[1]["pose"].tolist()  # type: ignore[no-any-return]
        env.reset()
        return [(robot.x, robot.y) for robot in env.world.poses()]

    episodes = [places()]
    for seed in (1, 2, 1):
        env.np_random = np.random.default_rng(seed)
        episodes.append([places(), places()])
    _, one, other, again = episodes
    assert one == again
    assert one != other
    assert one[0] != one[1]


def test_seed_decides_the_episodes_of_all_kinds_of_environment_under_any_noise() -> None:
    def episodes(kind: type[RecallEnv[Any]], noise: str) -> list[Begun]:
        env = kind(arena="rectangle", foods=3, food_types=ODDS, noise=noise)
        seen = []
        for seed in (5, None, 5, None):
            env.reset(seed=seed)
            seen.append(_begun(env))
        return seen

    runs = [episodes(kind, noise) for kind in (BehavioursEnv, WheelsEnv) for noise in ("none", "laboratory")]
    assert all(run == runs[0] for run in runs)
    first, second, again, after = runs[0]
    assert (again, after) == (first, second)
    assert first.layout != second.layout


def test_training_seed_decides_this_episode_and_those_that_follow() -> None:
    runs = []
    for _ in range(2):
        env = TrainingEnv(food_types=ODDS)
        episodes = []
        for seed in (5, None, None):
            env.reset(seed=seed)
            types = [[food.type for food in forager.tracker.foods] for forager in env.foragers]
            assert types[0] == types[1], "corresponding food"
            episodes.append((env.world.poses(), env.world.food_places(), types[0]))
        runs.append(episodes)
    assert runs[0] == runs[1]
    assert len({poses for poses, _, _ in runs[0]}) == 3
