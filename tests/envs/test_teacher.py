"""The teacher forages with every robot and type of food, also around walls, on both backends."""

import math
from dataclasses import replace
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from khepera_forage import Teacher
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.rollouts.recall import recall, recall_env, recall_wheels_env
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL
from tests.arenas import L_ROOM
from tests.sim.test_waypoints import ACROSS, CLOSED, DOOR, HALL, WINDING

pytest.importorskip("numba")

BOTH_SIDES = replace(DOOR, name="both_sides", foods=(Point(600, 150), Point(200, 700)))
MIXED = {"PUSHABLE": 0.5, "POISONOUS": 0.5}
CARRIED = {"PICKABLE": 0.5, "PUSHABLE": 0.5}
ROBOTS = ("toio", "e-puck2")
on_both_backends = pytest.mark.parametrize("backend", ["pymunk", "compiled"])


def in_arena(arena: Arena, backend: str = "pymunk", **kwargs: Any) -> Any:
    return recall_env(arena, backend=backend, **({"limit": 1500, "foods": 1} | kwargs))


@on_both_backends
@pytest.mark.parametrize(
    ("arena", "robot", "food_types"),
    [
        ("corridor", "khepera", "PICKABLE"),
        ("rectangle", "khepera", "PICKABLE"),
        *product(["rectangle"], ("khepera", *ROBOTS), ("PUSHABLE", "POISONOUS", MIXED)),
    ],
    ids=str,
)
def test_teacher_delivers_food_and_leaves_poison(robot: str, arena: str, food_types: Any, backend: str) -> None:
    env = recall_env(arena, limit=1500, backend=backend, robot=robot, food_types=food_types)
    rows = [recall(env, Teacher(), seed) for seed in range(3)]
    assert sum(row.steps < row.limit for row in rows) >= 2
    assert sum(row.poison_home for row in rows) == 0
    assert min(row.score for row in rows) >= 80
    if isinstance(food_types, str):
        delivered = sum(row.delivered for row in rows)
        assert delivered == 0 if food_types == "POISONOUS" else delivered >= 2 * env.foods
    if robot in ROBOTS:
        assert not env.view().robots[0].has_gripper
        senses = env.world.robots[0].sense()
        assert (senses.arm, senses.jaw) == (255, 200), "the arm counts as lowered, the jaw as open"


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("name", ["Corridor", "Rectangle"])
def test_teacher_without_a_gripper_pushes_nearly_all_food_home(robot: str, name: str) -> None:
    worlds: Any = gym.make_vec(f"khepera_forage/{name}-v1", num_envs=100, robot=robot, limit=1500)
    _, infos = worlds.reset(seed=0)
    delivered, over = np.zeros(100, np.int64), np.zeros(100, np.bool_)
    for _ in range(1500):
        _, _, terminated, truncated, infos = worlds.step(infos["correct_behaviour"])
        ends = (terminated | truncated) & ~over
        delivered[ends] = infos["delivered"][ends]
        over |= ends
    assert delivered.sum() >= 0.95 * 100 * worlds.get_attr("foods")[0]


@on_both_backends
@pytest.mark.parametrize("name", ["MixedFoods", "Procedural"])
def test_what_an_arena_has_to_pick_up_is_pushed_by_robots_without_a_gripper(name: str, backend: str) -> None:
    types = set()
    for robot in ("khepera", "toio"):
        env: Any = gym.make(f"khepera_forage/{name}-v1", robot=robot, backend=backend)
        for seed in range(8):
            env.reset(seed=seed)
            types |= {(robot, FoodType(food.type)) for food in env.unwrapped.forager.food.objects}
    assert ("khepera", FoodType.PICKABLE) in types
    assert ("toio", FoodType.PUSHABLE) in types
    assert ("toio", FoodType.PICKABLE) not in types
    assert (("toio", FoodType.POISONOUS) in types) == (name == "MixedFoods")


@on_both_backends
def test_speeds_are_limited_to_what_the_robot_can_do(backend: str) -> None:
    env = recall_wheels_env("corridor", backend=backend, robot="e-puck2")
    env.reset(seed=0)
    pulses = []
    for _ in range(2):
        env.step(np.ones(4, np.float32))
        pulses.append(env.world.robots[0].sense().left_pulses)
    assert pulses[1] - pulses[0] == 130, "an e-puck2 drives at most 13 speed units"


@on_both_backends
@pytest.mark.parametrize(
    ("first", "second", "width", "passed"),
    [
        ("PICKABLE", "POISONOUS", 600, True),
        ("PUSHABLE", "POISONOUS", 600, True),
        ("PICKABLE", "PUSHABLE", 600, False),
        ("PICKABLE", "POISONOUS", 180, False),  # there is no room beside it
    ],
)
def test_teacher_takes_food_home_past_what_may_be_poison(
    first: str, second: str, width: int, passed: bool, backend: str
) -> None:
    """The second object lies on the way from the first one to the home, and is shoved where it is not passed."""
    middle, walls = width / 2, (Point(0, 0), Point(1000, 0), Point(1000, width), Point(0, width))
    hall = Arena("hall", walls, Point(900, middle), 70, Pose(100, middle, 0.0), (Point(500, middle),))
    env = in_arena(hall, backend, foods=2, food_types={first: 1, second: 1})
    teacher = Teacher.of(env)
    for pixels in (-8, 0, 1) if passed else (0, 1):
        place = 600, middle + 5 * pixels
        for seed in range(20):
            options = {"start": (100, middle, 0), "foods": [(300, middle), place]}
            observation, info = env.reset(seed=seed, options=options)
            if [FoodType(food.type).name for food in env.forager.food.objects] == [first, second]:
                break
        while not info["delivered"]:
            observation, *_, info = env.step(teacher.act(observation))
        shoved = math.dist(env.world.food_places()[1][:2], place)
        assert shoved < 3.5 if passed else shoved > 3.5


# ---------------------------------------------------------------- walls and obstacles


@pytest.mark.parametrize(
    ("arena", "foods", "given", "least"),
    [
        *((arena, 1, {"limit": 1500, "food_types": food}, 0.98) for arena in WINDING for food in CARRIED),
        (HALL, 4, {"limit": 2400}, 0.985),  # whose home is in the middle
        (ACROSS, 1, {"limit": 900}, 0.99),  # whose home reaches from wall to wall
        ("many_foods", 5, {"limit": 2400}, 0.998),  # not stuck beside the home, nor before released food
        ("rectangle", 2, {"limit": 700, "noise": "none"}, 1),  # gets out of a hover without noise
    ],
    ids=str,
)
def test_teacher_delivers_nearly_all_food(arena: Any, foods: int, given: dict[str, Any], least: float) -> None:
    recalls = run_teacher(arena, 500, seed=1, foods=foods, **given)
    assert recalls.delivered.sum() >= least * 500 * foods


@pytest.mark.parametrize("arena", WINDING, ids=lambda arena: arena.name)
def test_teacher_delivers_around_corners_on_pymunk(arena: Arena) -> None:
    env = in_arena(arena, food_types=CARRIED)
    assert sum(recall(env, Teacher(), seed).delivered for seed in range(8)) >= 6


@on_both_backends
@pytest.mark.parametrize(("start", "food"), [((250, 1075), (60, 1025)), ((250, 925), (58, 990))])
def test_teacher_delivers_food_between_the_home_and_a_wall(
    start: tuple[float, float], food: tuple[float, float], backend: str
) -> None:
    env = in_arena(replace(HALL, home=Point(170, 1000)), backend, limit=800)
    observation, info = env.reset(seed=0, options={"start": (*start, 90), "foods": [food]})
    while not info["delivered"]:  # at the end of the episode this is an error
        observation, *_, info = env.step(Teacher.of(env).act(observation))


@on_both_backends
def test_distances_along_the_path_are_those_of_the_state_vector(backend: str) -> None:
    places = {"start": (640, 270, 0), "foods": [(280, 700)]}
    distances = []
    for decisions in (Decisions(), Decisions(distances="along the path")):
        env = in_arena(L_ROOM, backend, decisions=decisions)
        observation, _ = env.reset(seed=0, options=places)
        raw = env.forager.raw
        distances.append(raw.food_distance if decisions == Decisions() else raw.food_path)
        assert observation["robot_food_distance"][0] == int(distances[-1] + 0.5)
    assert distances[0] < distances[1] - 10.0


@on_both_backends
def test_nearest_food_is_the_one_with_the_shortest_path(backend: str) -> None:
    """The food behind the wall is nearer by air."""
    env = in_arena(BOTH_SIDES, backend, foods=2)
    behind, beside = (500, 650), (100, 450)
    env.reset(seed=0, options={"start": (300, 650, 90), "foods": [behind, beside]})
    raw = env.forager.raw
    assert math.dist((300, 650), behind) < math.dist((300, 650), beside)
    assert (raw.food_x * MM_PER_PIXEL, raw.food_y * MM_PER_PIXEL) == pytest.approx(beside, abs=15.0)


def test_random_food_and_starts_can_be_reached_where_a_part_of_the_floor_cannot() -> None:
    env = in_arena(replace(CLOSED, start=CLOSED.start._replace(x=200), foods=(Point(200, 400),)))
    for seed in range(20):
        env.reset(seed=seed)
        assert env.layout.starts[0].x < 390
        assert env.layout.foods[0].x < 390
