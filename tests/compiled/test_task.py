"""The compiled task against the task: the same functions, the same register, the same episodes."""

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.batch import TaskBatch, _by_row
from khepera_forage.envs.forager import site_of
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS, Motors, Senses, applicable
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.sim.arena import RECTANGLE, Point
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.behaviours import command
from khepera_forage.task.food_tracking import FoodRegister, FoodTypes
from khepera_forage.task.perception import nearest_food, perceive, state_vector
from khepera_forage.task.states import FoodType, classify
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}


def _senses(batch: Any, i: Any) -> Any:
    def get(row: Any) -> Any:
        return int(batch.body(row)[i])

    proximity = tuple(get(body.PROXIMITY + n) for n in range(8))
    return Senses(proximity, 0, 0, get(body.ARM_READ), get(body.JAW_READ), get(body.PRESENT))


def _scene(batch: Any, i: Any) -> Any:
    """What the camera of a world reports, as the single environments have it."""
    x, y, degrees, found = (
        batch.body(row)[i] for row in (body.OWN_X, body.OWN_Y, body.OWN_DEGREES, body.OWN_FOUND)
    )
    own = Region(10**6, float(x), float(y), 2, int(degrees), bool(found), False, 0, 0, 1, 1, 1)
    food = batch.worlds.bodies.food.reshape(-1, batch.foods, body.FOOD_ROWS, LANES)[
        i // LANES, :, :, i % LANES
    ]
    regions = [own]
    for rows in food.tolist():
        if rows[body.TRACK] >= 0:
            seen = bool(rows[body.TRACK_FOUND])
            regions.append(
                Region(
                    int(rows[body.TRACK]),
                    rows[body.TRACK_X],
                    rows[body.TRACK_Y],
                    0,
                    0,
                    seen,
                    False,
                    0,
                    0,
                    1,
                    1,
                    1,
                )
            )
        if rows[body.GHOST] >= 0:
            regions.append(
                Region(
                    int(rows[body.GHOST]),
                    rows[body.GHOST_X],
                    rows[body.GHOST_Y],
                    0,
                    0,
                    False,
                    False,
                    0,
                    0,
                    1,
                    1,
                    1,
                )
            )
    return Scene(tuple(sorted(regions, key=lambda r: r.label))), own


def test_register_perception_and_commands_are_those_of_the_single_environment() -> None:
    """Every round of 24 worlds, scenes and senses given to `FoodRegister`, `perceive`, `classify` and `command`."""
    worlds, foods = 24, 3
    batch = TaskBatch(worlds, "rectangle", foods, 10_000, Noise(loss_rate_food=0.01), MIXED)
    batch.seed(3, np.arange(worlds))
    batch.restart(np.arange(worlds))
    site = site_of(RECTANGLE)
    registers = []
    for i in range(worlds):
        rows = batch.worlds.registers.reshape(-1, foods, at.TASK_FOOD_ROWS, LANES)[
            i // LANES, :, :, i % LANES
        ]
        places = (
            batch.worlds.bodies.food.reshape(-1, foods, body.FOOD_ROWS, LANES)[i // LANES, :, :2, i % LANES]
            / MM_PER_PIXEL
        )
        types = FoodTypes(foods, (1.0, 0.0, 0.0), np.random.default_rng(0))
        types._types = [FoodType(int(t)) for t in rows[:, at.TYPE]]
        registers.append(FoodRegister(site, [tuple(p) for p in places.tolist()], types))
    before = [_senses(batch, i)._replace(object_presence=0) for i in range(worlds)]
    applied = [Motors(0, 0, 215, 200)] * worlds
    rng = np.random.default_rng(0)
    delivered = 0
    for _ in range(350):
        states = batch.task(at.STATE).astype(int)
        choices = np.where(rng.random(worlds) < 0.1, rng.integers(0, 10, worlds), states)
        commanded = []
        for i in range(worlds):
            scene, own = _scene(batch, i)
            after = _senses(batch, i)
            register = registers[i]
            register.update(scene, own, before[i], after, applied[i])
            food = nearest_food(scene, site, own.x, own.y, register.settled)
            raw = perceive(after, own, food, register.type_in_gripper, site)
            vector = state_vector(raw, site.diagonal)
            assert vector == tuple(batch.task(at.VECTOR + n)[i] for n in range(5))
            assert classify(vector, site.home_radius) == states[i]
            assert register.delivered_food == batch.task(at.DELIVERED)[i]
            assert register.poison_home == batch.task(at.POISON_HOME)[i]
            assert register.deliverable == batch.task(at.DELIVERABLE)[i]
            before[i] = after
            commanded.append(applicable(command(int(choices[i]), raw)))
        batch.step(choices.astype(float), np.zeros(worlds, np.bool_))
        told = [batch.body(row) for row in (body.LEFT, body.RIGHT, body.ARM_TO, body.JAW_TO)]
        for i in range(worlds):
            assert commanded[i] == tuple(row[i] for row in told)
            applied[i] = commanded[i]
        delivered = sum(register.delivered_food for register in registers)
    assert delivered > worlds / 2


def test_random_layouts_have_the_distribution_of_the_single_environment() -> None:
    worlds = 1500
    batch = TaskBatch(worlds, "rectangle", 2, noise=Noise.none())
    batch.seed(0, np.arange(worlds))
    batch.restart(np.arange(worlds))
    env = BehavioursEnv(arena="rectangle", foods=2)
    single = []
    for seed in range(500):
        env.reset(seed=seed)
        (x, y, heading), (one, two) = env.layout.starts[0], env.layout.foods
        single.append((x, y, heading, *one, *two))
    many = (
        _by_row(batch.worlds.bodies.robots)[:, (body.X, body.Y, body.HEADING)]
        .transpose(0, 2, 1)
        .reshape(-1, 3)[:worlds]
    )
    food = (
        batch.worlds.bodies.food.reshape(-1, 2, body.FOOD_ROWS, LANES)[:, :, :2]
        .transpose(0, 3, 1, 2)
        .reshape(-1, 4)[:worlds]
    )
    for column, values in enumerate(np.column_stack((many, food)).T):
        assert stats.ks_2samp(values, np.array(single)[:, column]).pvalue > 1e-3
    for x, y in food.reshape(-1, 2)[:200].tolist():
        assert RECTANGLE.clearance(Point(x, y)) > 49.9 > FOOD_RADIUS


def _pymunk_steps(episodes: Any) -> Any:
    env = BehavioursEnv()
    steps = []
    for seed in range(episodes):
        _, info = env.reset(seed=seed)
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step(info["correct_behaviour"])
            over = terminated or truncated
        steps.append(info["steps"])
    return np.array(steps)


def test_the_teacher_takes_as_many_steps_as_in_pymunk() -> None:
    """Some hundred episodes here; thousands, with all scores, in benchmarks."""
    single = _pymunk_steps(250)
    batch = run_teacher("corridor", 4000, 7)
    assert stats.ks_2samp(single, batch.steps).pvalue > 1e-3
    assert abs(single.mean() - batch.steps.mean()) < 4 * single.std() / math.sqrt(250)
    assert batch.delivered.mean() > 0.998
    assert batch.score.mean() > 99.9


def test_wheels_two_percent_slow_would_be_noticed() -> None:
    quick, same, slow = (
        run_teacher("corridor", 6000, seed, wheel_speed=v) for seed, v in ((1, 1.0), (2, 1.0), (3, 0.98))
    )
    assert stats.ttest_ind(quick.steps, same.steps).pvalue > 0.01
    assert stats.ttest_ind(quick.steps, slow.steps).pvalue < 0.001


def test_nothing_is_lost_between_rounds() -> None:
    """The rows that threads work in hold nothing that the next round needs: whole episodes keep them."""
    kwargs: Any = {"foods": 3, "limit": 400, "food_types": MIXED}
    whole = run_teacher("rectangle", 300, 8, **kwargs)
    batch = TaskBatch(300, "rectangle", **kwargs)
    batch.seed(8, np.arange(300))
    batch.restart(np.arange(300))
    under_way, steps, delivered = np.ones(300, bool), np.zeros(300), np.zeros(300)
    for _ in range(400):
        batch.worlds.bodies.work[:] = np.nan
        batch.step(batch.task(at.STATE), np.zeros(300, bool))
        over = under_way & ((batch.task(at.TERMINATED) != 0) | (batch.task(at.TRUNCATED) != 0))
        steps[over], delivered[over] = batch.task(at.STEPS)[over], batch.task(at.DELIVERED)[over]
        under_way &= ~over
    assert not under_way.any()
    assert (steps == whole.steps).all()
    assert (delivered == whole.delivered).all()


def test_an_episode_is_the_same_however_many_there_are() -> None:
    few = run_teacher("rectangle", 40, 5, foods=2, limit=700, food_types=MIXED)
    many = run_teacher("rectangle", 700, 5, foods=2, limit=700, food_types=MIXED)
    for a, b in zip(few, many, strict=True):
        assert (a == b[:40]).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"foods": 17}, "foods is 17"),
        ({"limit": 0}, "limit is 0"),
        ({"episodes": 0}, "episodes is 0"),
        ({"arena": "moon"}, "arena is 'moon'"),
    ],
)
def test_bad_arguments_are_quoted(arguments: Any, message: Any) -> None:
    with pytest.raises(ValueError, match=message):
        run_teacher(**arguments)
