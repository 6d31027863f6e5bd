"""The register of food with the real world: through pushing, carrying and setting down."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from khepera_forage.envs.forager import Forager, site_of
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import CORRIDOR, RECTANGLE, Arena, Point
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.task.food_tracking import FoodRegister, FoodTypes
from khepera_forage.task.perception import nearest_food
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL

ODDS = {
    FoodType.PICKABLE: (1.0, 0.0, 0.0),
    FoodType.PUSHABLE: (0.0, 1.0, 0.0),
    FoodType.POISONOUS: (0.0, 0.0, 1.0),
}
B = Behaviour
Check = Callable[["Forage"], None]


class Forage:
    """One robot, its world and its register, round by round."""

    def __init__(
        self,
        arena: Arena,
        odds: tuple[float, float, float],
        noise: Noise | None = None,
        seed: int = 0,
        foods: tuple[Point, ...] = (),
    ) -> None:
        self.arena = arena
        foods = foods or arena.foods
        self.world = PymunkWorld([arena], (2,), Noise.none() if noise is None else noise)
        self.world.reset(np.random.default_rng(seed), Layout((arena.start,), foods))
        self.types = FoodTypes(len(foods), odds, np.random.default_rng(seed))
        site = site_of(arena)
        places = [(f.x / MM_PER_PIXEL, f.y / MM_PER_PIXEL) for f in foods]
        self.register = FoodRegister(site, places, self.types)
        self.robot = Forager(self.world.robots[0], site, 2, self.register)
        self.robot.perceive(self.world.camera.look())

    def step(self, behaviour: int | None = None) -> None:
        robot = self.robot
        robot.drive(robot.motors_for(robot.correct_behaviour if behaviour is None else behaviour))
        self.world.advance()
        robot.perceive(self.world.camera.look())

    def until(self, over: Callable[["Forage"], bool], limit: int = 700, check: Check | None = None) -> None:
        for _ in range(limit):
            if over(self):
                return
            self.step()
            if check is not None:
                check(self)
        raise AssertionError(f"not over after {limit} rounds, in state {self.robot.state!r}")

    @property
    def held(self) -> int | None:
        """The food object that is really in the gripper."""
        if not self.robot.senses.object_presence:
            return None
        x, y, heading = self.world.poses()[0]
        gripper = x + 55 * math.cos(heading), y + 55 * math.sin(heading)
        places = self.world.food_places()
        return min(
            range(len(places)), key=lambda k: (not places[k].lifted, math.dist(places[k][:2], gripper))
        )


def ties_hold(forage: Forage) -> None:
    """Every region in view is tied to the object that really lies there, and so is what the gripper holds."""
    register = forage.register
    for region in forage.world.camera.look().regions:
        k = None if region.holes or not region.found else register.object_of(region.label)
        if k is not None:
            place = forage.world.food_places()[k]
            assert math.dist(place[:2], (region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL)) < 10
    if forage.held is not None:
        assert register.type_in_gripper == register.known[forage.held]
        assert forage.robot.raw.food_type == register.known[forage.held]
    else:
        assert forage.robot.raw.food_type == FoodType.UNKNOWN


def deliveries_hold(forage: Forage) -> None:
    """What counts as delivered lies at home, within a pixel, and is not what the gripper holds."""
    arena = forage.arena
    for k, food in enumerate(forage.world.food_places()):
        if forage.register.delivered[k]:
            assert forage.held != k
            assert not food.lifted
            assert math.dist(food[:2], arena.home) <= arena.home_radius + MM_PER_PIXEL


# ---------------------------------------------------------------- types


@pytest.mark.parametrize("kind", [FoodType.PICKABLE, FoodType.PUSHABLE])
def test_a_type_is_known_from_exploring_on_and_stays_through_the_way_home(kind: FoodType) -> None:
    forage = Forage(CORRIDOR, ODDS[kind])
    forage.until(lambda f: f.held is not None)
    assert forage.register.known == [FoodType.UNKNOWN]
    assert forage.robot.raw.food_type == FoodType.UNKNOWN
    forage.until(lambda f: f.register.known[0] != FoodType.UNKNOWN, limit=20)
    assert forage.robot.raw.food_type == kind
    moved = 0.0

    def check(forage: Forage) -> None:
        nonlocal moved
        assert forage.register.known == [kind]
        ties_hold(forage)
        deliveries_hold(forage)
        moved = max(moved, math.dist(forage.world.food_places()[0][:2], CORRIDOR.foods[0]))

    forage.until(lambda f: f.register.finished, check=check)
    assert moved > 80
    assert (forage.register.delivered_food, forage.register.poison_home) == (1, 0)


@pytest.mark.parametrize("seed", range(12))
def test_two_objects_keep_their_own_types_through_all_troubles(seed: int) -> None:
    forage = Forage(RECTANGLE, (0.4, 0.4, 0.2), Noise.laboratory(), seed)

    def check(forage: Forage) -> None:
        ties_hold(forage)
        deliveries_hold(forage)

    forage.until(lambda f: f.register.finished, limit=1200, check=check)
    register = forage.register
    assert FoodType.UNKNOWN not in register.known
    assert register.collected == [kind != FoodType.POISONOUS for kind in register.known]


def test_types_do_not_depend_on_which_is_identified_first() -> None:
    orders = []
    for order in ((0, 1, 2, 3), (3, 1, 0, 2)):
        types = FoodTypes(4, (0.4, 0.3, 0.3), np.random.default_rng(12))
        for index in order:
            assert types.known[index] == FoodType.UNKNOWN
            types.identify(index)
        orders.append(types.known)
    assert orders[0] == orders[1]


def test_types_come_with_their_odds() -> None:
    types = FoodTypes(4000, (0.5, 0.3, 0.2), np.random.default_rng(0))
    for index in range(4000):
        types.identify(index)
    shares = [types.known.count(kind) / 4000 for kind in ODDS]
    assert shares == pytest.approx([0.5, 0.3, 0.2], abs=0.03)  # four standard errors


def test_corresponding_food_shares_one_draw() -> None:
    types = FoodTypes(1, (0.5, 0.5, 0.0), np.random.default_rng(1))
    site = site_of(CORRIDOR)
    teacher, learner = (FoodRegister(site, [(74, 23)], types) for _ in range(2))
    types.identify(0)
    assert teacher.known == learner.known != [FoodType.UNKNOWN]


# ---------------------------------------------------------------- delivery


def test_food_is_delivered_when_set_down_at_home_and_clear_and_no_sooner() -> None:
    forage = Forage(CORRIDOR, ODDS[FoodType.PICKABLE])
    forage.until(lambda f: f.world.food_places()[0].lifted)
    # Into the home and about in it, without letting go.
    for behaviour, rounds in ((B.GO_HOME, 60), (B.WAIT, 10)):
        for _ in range(rounds):
            forage.step(behaviour)
            assert not forage.register.delivered[0]
            deliveries_hold(forage)
    food = forage.world.food_places()[0]
    assert math.dist(food[:2], CORRIDOR.home) < CORRIDOR.home_radius
    forage.until(lambda f: not f.world.food_places()[0].lifted, limit=60)
    assert not forage.register.delivered[0], "still in the gripper"
    forage.until(lambda f: f.register.delivered[0], limit=60, check=deliveries_hold)
    assert forage.robot.senses.object_presence == 0
    label = next(r.label for r in forage.world.camera.look().regions if r.holes == 0)
    assert label in forage.register.settled
    assert not forage.robot.raw.food_seen, "it is no candidate any more"
    assert forage.robot.vector.robot_food_distance == site_of(CORRIDOR).diagonal


def test_food_set_down_outside_home_is_found_again() -> None:
    forage = Forage(CORRIDOR, ODDS[FoodType.PICKABLE])
    forage.until(lambda f: f.world.food_places()[0].lifted)
    for _ in range(30):
        forage.step(B.RELEASE_FOOD if forage.robot.raw.jaw > 130 else B.SEARCH_FOR_FOOD)
    forage.until(lambda f: f.register.finished)
    assert forage.register.delivered_food == 1


# ---------------------------------------------------------------- poison


def test_poison_is_no_candidate_once_it_is_known() -> None:
    forage = Forage(RECTANGLE, ODDS[FoodType.POISONOUS])
    forage.until(lambda f: FoodType.POISONOUS in f.register.known)
    first = forage.register.known.index(FoodType.POISONOUS)
    assert forage.register.deliverable == 1
    assert not forage.register.finished

    def check(forage: Forage) -> None:
        ties_hold(forage)
        scene, own = forage.world.camera.look(), forage.robot.own
        food = nearest_food(scene, forage.robot.site, own.x, own.y, forage.register.settled)
        if food is not None and forage.held is None:
            assert forage.register.object_of(food.label) != first

    forage.until(lambda f: f.register.finished, check=check)
    register = forage.register
    assert (register.deliverable, register.delivered_food, register.poison_home) == (0, 0, 0)


def test_poison_brought_home_is_counted_apart() -> None:
    forage = Forage(CORRIDOR, ODDS[FoodType.POISONOUS])
    forage.until(lambda f: FoodType.POISONOUS in f.register.known)
    for _ in range(25):
        forage.step(B.PICK_UP_FOOD)
    assert forage.world.food_places()[0].lifted
    for _ in range(60):
        forage.step(B.GO_HOME)
    for _ in range(60):
        forage.step(B.RELEASE_FOOD)
    register = forage.register
    assert register.delivered == [True]
    assert (register.poison_home, register.delivered_food, register.deliverable) == (1, 0, 0)
    assert register.collected == [False]
    assert register.finished
