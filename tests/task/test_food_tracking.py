"""The food tracker, in a simulated world, and with made-up scenes for events that are rare there."""

import math
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.layouts import arena_map_of, known_food
from khepera_forage.robots.khepera import Senses
from khepera_forage.sim.arena import Point
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_tracking import (
    FoodObject,
    KnownFood,
    can_explore,
    is_collected,
    is_finished,
    share_identified,
)
from khepera_forage.task.perception import perceive
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region
from tests.version_0_1 import RECTANGLE, V0_1, changed_to

B = Behaviour
Check = Callable[[Any], None]


def forage(name: str, seed: int = 0, **kwargs: Any) -> Any:
    """An environment on pymunk after its reset."""
    kwargs.setdefault("decisions", V0_1)
    env: Any = gym.make(f"khepera_forage/{name}-v1", limit=2000, **kwargs).unwrapped
    env.reset(seed=seed)
    return env


def until(env: Any, over: Callable[[Any], bool], limit: int = 700, check: Check = lambda _: None) -> None:
    """The correct behaviour until something has happened."""
    for _ in range(limit):
        if over(env):
            return
        env.step(int(env.forager.correct_behaviour))
        check(env)
    raise AssertionError(f"not over after {limit} rounds, in state {env.forager.state!r}")


def held(env: Any) -> int | None:
    """The food object that is really in the gripper."""
    if not env.forager.senses.object_presence:
        return None
    x, y, heading = env.world.poses()[0]
    gripper = x + 55 * math.cos(heading), y + 55 * math.sin(heading)
    places = env.world.food_places()
    return min(range(len(places)), key=lambda k: (not places[k].lifted, math.dist(places[k][:2], gripper)))


def linked_food(known: KnownFood, label: int) -> int | None:
    """Number of the food object that a track shows; None without a link."""
    foods = [link.food for link in known.links if link.label == label]
    assert len(foods) <= 1, "a track shows one food object"
    return foods[0] if foods else None


def check_links(env: Any) -> None:
    """Every region in view is linked to the food object that really lies there; so is food in the gripper."""
    food = env.forager.food
    for region in env.world.camera.look().regions:
        k = None if region.holes or not region.found else linked_food(food, region.label)
        if k is not None:
            place = env.world.food_places()[k]
            assert math.dist(place[:2], (region.x * MM_PER_PIXEL, region.y * MM_PER_PIXEL)) < 10
    number = held(env)
    known = FoodType.UNKNOWN if number is None else food.objects[number].known
    assert number is None or food.tracker.type_in_gripper == known
    assert env.forager.raw.food_type == known


def check_deliveries(env: Any) -> None:
    """What counts as delivered lies at home, within a pixel, and is not what the gripper holds."""
    for k, food in enumerate(env.world.food_places()):
        if env.forager.food.objects[k].delivered:
            assert held(env) != k
            assert not food.lifted
            assert math.dist(food[:2], env.arena.home) <= env.arena.home_radius + MM_PER_PIXEL


@pytest.mark.parametrize("decisions", [V0_1, Decisions()], ids=["v0.1", "default"])
@pytest.mark.parametrize("seed", range(12))
def test_two_food_objects_keep_their_types_under_laboratory_noise(seed: int, decisions: Decisions) -> None:
    odds = {"PICKABLE": 0.4, "PUSHABLE": 0.4, "POISONOUS": 0.2}
    env = forage("Rectangle", seed, food_types=odds, decisions=decisions)

    def check(env: Any) -> None:
        check_links(env)
        check_deliveries(env)

    until(env, lambda env: is_finished(env.forager.tracker), limit=1200, check=check)
    foods = env.forager.food.objects
    assert [food.known for food in foods] == [food.type for food in foods]
    assert [is_collected(food) for food in foods] == [food.type != FoodType.POISONOUS for food in foods]


def test_food_is_identified_once_the_wheels_rest() -> None:
    env = forage("CorridorWheels", noise="none")
    env.reset(seed=0, options={"start": (200, 115, 0), "foods": [(257, 115)]})
    for left, right in ((0.05, 0), (0, 0.05), (-0.05, 0), (0, -0.05)) * 6:
        env.step(np.array((left, right, -1, -1)))
    assert (env.forager.senses.arm, env.forager.senses.object_presence) == (255, 255)
    assert env.forager.raw.food_type == FoodType.UNKNOWN
    env.step(np.array((0, 0, -1, -1)))
    assert env.forager.raw.food_type == FoodType.PICKABLE


# ---------------------------------------------------------------- made-up scenes

ARENA = arena_map_of(RECTANGLE)
FIRST, SECOND = (74.0, 40.0), (74.0, 80.0)
EMPTY = Senses((0,) * 8, 0, 0, 255, 200, 0)
PRESENT = EMPTY._replace(object_presence=255)
GRIPPED = PRESENT._replace(arm=215, jaw=126)


def region(label: int, place: tuple[float, float], found: bool = True, holes: int = 0) -> Region:
    return Region(label, *place, holes, 0, found, False, *place, 1.0, 1.0)


LOST = region(1, FIRST, found=False)


def known_types(known: KnownFood) -> list[int]:
    return [food.known for food in known.objects]


class Story:
    """Rounds as camera and robot would report them; the robot looks along the x axis."""

    def __init__(self, food_type: FoodType = FoodType.PICKABLE, **decisions: Any) -> None:
        self.decisions = changed_to(**decisions)
        self.food = known_food([Point(x * MM_PER_PIXEL, y * MM_PER_PIXEL) for x, y in (FIRST, SECOND)])
        self.tracker = self.food.tracker
        for food in self.food.objects:
            food.type = food_type
        self.senses = EMPTY
        self.round((20, 60), EMPTY, region(1, FIRST), region(2, SECOND))

    def round(self, robot: tuple[float, float], senses: Senses, *foods: Region) -> None:
        own = region(0, robot, holes=2)
        perceive(self.food, own, (own, *foods), senses, can_explore(self.senses), ARENA, self.decisions)
        self.senses = senses

    def explore_first(self) -> None:
        """Two rounds in which the first object stays in the barrier; it is hidden by the marker."""
        for _ in range(2):
            self.round((63, 40), PRESENT, LOST, region(2, SECOND))


def nearest_of(story: Story) -> tuple[float, float] | None:
    """The nearest candidate."""
    tracker = story.tracker
    return (tracker.food_x, tracker.food_y) if tracker.food_seen else None


def test_nearest_food_is_a_candidate_of_the_own_arena() -> None:
    story = Story()
    beyond = (40.0, ARENA.top + 20)
    regions = region(3, beyond), region(4, (41.0, 60.0), holes=1), region(2, SECOND), region(1, FIRST)
    story.round((40, 50), EMPTY, *regions)
    assert nearest_of(story) == FIRST
    story.food.objects[0].delivered = True
    story.round((40, 50), EMPTY, *regions)
    assert nearest_of(story) == SECOND
    story.food.objects[1].known = FoodType.POISONOUS
    story.round((40, 50), EMPTY, *regions)
    assert nearest_of(story) is None
    assert (story.tracker.food_x, story.tracker.food_y) == (0.0, 0.0)


def test_nearest_food_may_be_a_lost_region_or_one_that_shows_no_food_object() -> None:
    story = Story()
    story.round((40, 50), EMPTY, LOST, region(2, SECOND))
    assert nearest_of(story) == FIRST
    story.round((40, 50), EMPTY, region(1, FIRST), region(2, SECOND), region(9, (42.0, 52.0)))
    assert linked_food(story.food, 9) is None
    assert nearest_of(story) == (42.0, 52.0)


def test_what_turns_up_beside_the_gripper_is_not_the_food_in_it() -> None:
    """A robot shoves food out of its track: what it holds is nearer to the new one, but is hidden by the marker."""
    story = Story()
    story.explore_first()
    shoved = (72.0, 52.0)
    story.round((63, 40), PRESENT, LOST, region(8, shoved))
    assert linked_food(story.food, 8) == 1
    assert known_types(story.food) == [FoodType.PICKABLE, FoodType.UNKNOWN]
    first, second = story.food.objects
    assert (second.x, second.y) == shoved
    assert math.hypot(first.x - shoved[0], first.y - shoved[1]) < math.dist(SECOND, shoved)


RAISED = EMPTY._replace(arm=215)


def test_lost_food_may_be_seen_while_the_arm_is_down() -> None:
    story = Story(food_beside_robot="unseen until the arm is down")
    story.round((40, 50), RAISED, LOST, region(2, SECOND))
    assert nearest_of(story) == SECOND
    story.round((40, 50), EMPTY, LOST, region(2, SECOND))
    assert nearest_of(story) == FIRST


def test_lost_food_is_seen_until_it_is_redetected() -> None:
    story = Story(food_beside_robot="unseen", redetection_time=0.25)
    seen = []
    for found in (False, False, False, True, False, False, False):
        story.round((40, 50), RAISED, region(1, FIRST, found=found), region(2, SECOND))
        seen.append(nearest_of(story) == FIRST)
    assert seen == [True, True, False, True, True, True, False]


@pytest.mark.parametrize(
    ("held_food", "nearest"),
    [
        ("candidate at its last place", FIRST),
        ("no candidate", SECOND),
        ("candidate in the gripper", (63 + 58 / 5, 40)),
        ("hides all food", None),
    ],
)
def test_held_food_counts_as_decided(held_food: str, nearest: tuple[float, float] | None) -> None:
    story = Story(held_food=held_food)
    story.explore_first()
    assert nearest_of(story) == (None if nearest is None else pytest.approx(nearest))
    story.round((63, 40), EMPTY, region(1, FIRST), region(2, SECOND))
    assert nearest_of(story) == FIRST, "once it is not held"


def test_last_distance_is_forgotten_once_poison_is_known() -> None:
    """Otherwise a robot that has backed off poison would count as next to food, and orient again, for ever."""
    story = Story(no_food_distance="last one known")
    story.round((44, 40), EMPTY, region(1, FIRST), region(2, SECOND))
    story.food.objects[0].known = FoodType.POISONOUS
    story.round((44, 40), EMPTY, region(1, FIRST), region(2, SECOND))
    assert story.tracker.last_distance == pytest.approx(math.dist((44, 40), SECOND)), "the other one is a candidate"
    story.food.objects[1].delivered = True
    story.round((20, 40), EMPTY, region(1, FIRST), region(2, SECOND))
    assert story.tracker.last_distance == -1


def test_identified_types_are_shared_with_the_corresponding_food() -> None:
    foods = [FoodObject(10, 10, type=FoodType.PUSHABLE), FoodObject(20, 10, type=FoodType.PICKABLE)]
    others = [FoodObject(10, 80, type=FoodType.PUSHABLE), FoodObject(20, 80, type=FoodType.PICKABLE)]
    foods[0].known = FoodType.PUSHABLE
    share_identified(foods, others)
    assert [food.known for food in others] == [FoodType.PUSHABLE, FoodType.UNKNOWN]
    share_identified(others, foods)
    assert [food.known for food in foods] == [FoodType.PUSHABLE, FoodType.UNKNOWN]


@pytest.mark.parametrize("other", [EMPTY, PRESENT._replace(arm=215), PRESENT._replace(jaw=126)])
def test_food_is_identified_only_in_a_round_with_arm_down_and_jaw_open(other: Senses) -> None:
    for rounds in ((other, PRESENT), (PRESENT, other)):
        story = Story()
        for senses in rounds:
            story.round((63, 40), senses, LOST, region(2, SECOND))
        assert known_types(story.food) == [FoodType.UNKNOWN] * 2


def test_carried_food_is_recognised_while_its_old_track_remains() -> None:
    """The marker still hides the place where the food lay, so its track stays there, lost."""
    story = Story(FoodType.PUSHABLE)
    story.explore_first()
    story.round((63, 55), GRIPPED, LOST, region(2, SECOND))
    story.round((50, 55), EMPTY, LOST, region(2, SECOND), region(3, (74, 55)))
    assert linked_food(story.food, 3) == 0
    assert linked_food(story.food, 2) == 1


def test_carried_food_is_recognised_where_it_was_set_down() -> None:
    story = Story(FoodType.PUSHABLE)
    story.explore_first()
    # Carried close to the second food object, whose track is dropped meanwhile.
    drop = (SECOND[0] + 2, SECOND[1] - 8)
    story.round((drop[0] - 11.6, drop[1]), GRIPPED)
    story.round((drop[0] - 25, drop[1]), EMPTY, region(3, drop))
    assert linked_food(story.food, 3) == 0
    story.round((drop[0] - 25, drop[1]), EMPTY, region(3, drop), region(4, SECOND))
    assert linked_food(story.food, 4) == 1


def test_poison_that_was_lost_for_a_while_stays_poison() -> None:
    story = Story(FoodType.POISONOUS)
    story.explore_first()
    assert nearest_of(story) == FIRST, "poison in the gripper stays the nearest food"
    assert story.tracker.type_in_gripper == FoodType.POISONOUS
    story.round((40, 40), EMPTY, region(1, FIRST), region(2, SECOND))
    assert nearest_of(story) == SECOND, "poison, and no longer held"
    story.round((40, 40), EMPTY, region(2, SECOND))
    story.round((40, 40), EMPTY, region(2, SECOND), region(5, FIRST))
    assert nearest_of(story) == SECOND
    assert story.tracker.deliverable == 1
