"""The teacher in arenas with walls and obstacles, and what a robot perceives of its way there."""

import math
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.task.decisions import Decisions
from khepera_forage.vision.scene import MM_PER_PIXEL
from tests.sim.test_ways import CLOSED, DOOR, HALL, L_ROOM, WINDING

BACKENDS = ["pymunk", "compiled"]
BOTH_SIDES = replace(DOOR, name="both_sides", foods=(Point(600, 150), Point(200, 700)))


def make(arena: Arena, backend: str = "pymunk", **kwargs: Any) -> Any:
    arguments = {"limit": 1500, "foods": 1} | kwargs
    return gym.make("khepera_forage/Corridor-v1", arena=arena, backend=backend, **arguments)


def delivered(env: Any, seed: int) -> int:
    _, info = env.reset(seed=seed)
    over = False
    while not over:
        _, _, terminated, truncated, info = env.step(info["correct_behaviour"])
        over = terminated or truncated
    return int(info["delivered"])


@pytest.mark.parametrize("arena", WINDING, ids=lambda arena: arena.name)
@pytest.mark.parametrize("food_type", ["PICKABLE", "PUSHABLE"])
def test_teacher_delivers_around_corners_in_compiled_worlds(arena: Arena, food_type: str) -> None:
    recalls = run_teacher(arena, 500, seed=1, limit=1500, food_types=food_type)
    assert np.count_nonzero(recalls.delivered) >= 0.98 * 500


@pytest.mark.parametrize("arena", WINDING, ids=lambda arena: arena.name)
@pytest.mark.parametrize("food_type", ["PICKABLE", "PUSHABLE"])
def test_teacher_delivers_around_corners_on_pymunk(arena: Arena, food_type: str) -> None:
    env = make(arena, food_types=food_type)
    assert sum(delivered(env, seed) for seed in range(12)) >= 11


def test_teacher_delivers_to_a_home_in_the_middle_of_a_hall() -> None:
    recalls = run_teacher(HALL, 500, seed=1, foods=4, limit=2400)
    assert recalls.delivered.sum() >= 0.985 * 2000


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("start", "food"), [((250, 1075), (60, 1025)), ((250, 925), (58, 990))])
def test_teacher_delivers_food_between_the_home_and_a_wall(
    backend: str, start: tuple[float, float], food: tuple[float, float]
) -> None:
    env = make(replace(HALL, home=Point(170, 1000)), backend, limit=800)
    _, info = env.reset(seed=0, options={"start": (*start, 90), "foods": [food]})
    over = False
    while not over:
        _, _, terminated, truncated, info = env.step(info["correct_behaviour"])
        over = terminated or truncated
    assert info["delivered"] == 1


@pytest.mark.parametrize("backend", BACKENDS)
def test_distances_along_the_path_are_those_of_the_state_vector(backend: str) -> None:
    places = {"start": (150, 125, 0), "foods": [(575, 600)]}
    distances = []
    for decisions in (Decisions(), Decisions(distances="along the path")):
        env = make(L_ROOM, backend, decisions=decisions)
        observation, _ = env.reset(seed=0, options=places)
        raw = env.unwrapped.forager.raw
        expected = raw.food_distance if decisions == Decisions() else raw.food_path
        assert observation["robot_food_distance"][0] == int(expected + 0.5)
        distances.append(expected)
    assert distances[0] < distances[1] - 10.0


@pytest.mark.parametrize("backend", BACKENDS)
def test_nearest_food_is_the_one_with_the_shortest_path(backend: str) -> None:
    """The food behind the wall is nearer by air."""
    env = make(BOTH_SIDES, backend, foods=2)
    behind, beside = (500, 650), (100, 450)
    env.reset(seed=0, options={"start": (300, 650, 90), "foods": [behind, beside]})
    raw = env.unwrapped.forager.raw
    assert math.dist((300, 650), behind) < math.dist((300, 650), beside)
    assert (raw.food_x * MM_PER_PIXEL, raw.food_y * MM_PER_PIXEL) == pytest.approx(beside, abs=15.0)


def test_random_food_and_starts_can_be_reached_where_a_part_of_the_floor_cannot() -> None:
    env = make(replace(CLOSED, start=CLOSED.start._replace(x=200), foods=(Point(200, 400),)))
    for seed in range(20):
        env.reset(seed=seed)
        layout = env.unwrapped.layout
        assert layout.starts[0].x < 390
        assert layout.foods[0].x < 390


@pytest.mark.parametrize("backend", BACKENDS)
def test_arena_without_a_way_is_refused(backend: str) -> None:
    with pytest.raises(ValueError, match="closed: there is no way between the start"):
        make(CLOSED, backend)
