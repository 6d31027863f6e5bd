"""The register of food with scenes made up: what seldom happens in a run, and what must not confuse it."""

import numpy as np
import pytest

from khepera_forage.envs.forager import site_of
from khepera_forage.robots.khepera import Motors, Senses
from khepera_forage.sim.arena import RECTANGLE
from khepera_forage.task.food_tracking import FoodRegister, FoodTypes
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import Region, Scene

SITE = site_of(RECTANGLE)
FIRST, SECOND = (74.0, 40.0), (74.0, 80.0)
HOME = (SITE.home_x, SITE.home_y)
EMPTY = Senses((0,) * 8, 0, 0, 255, 200, 0)
PRESENT = EMPTY._replace(object_presence=255)
GRIPPED = PRESENT._replace(arm=215, jaw=126)
STILL = Motors(0, 0, 255, 200)


def region(label: int, place: tuple[float, float], found: bool = True, holes: int = 0) -> Region:
    return Region(label, *place, holes, 0, found, False, *place, 1.0, 1.0, 1.0)


class Story:
    """Rounds as camera and robot would report them; the robot looks along the x axis."""

    def __init__(self, odds: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> None:
        self.register = FoodRegister(SITE, [FIRST, SECOND], FoodTypes(2, odds, np.random.default_rng(0)))
        self.senses = EMPTY
        self.round((20, 60), EMPTY, region(1, FIRST), region(2, SECOND))

    def round(
        self, robot: tuple[float, float], senses: Senses, *foods: Region, motors: Motors = STILL
    ) -> FoodRegister:
        own = region(0, robot, holes=2)
        self.register.update(Scene((own, *foods)), own, self.senses, senses, motors)
        self.senses = senses
        return self.register

    def explore_first(self) -> None:
        """Two rounds in which the first object stays in the barrier; it is hidden by the marker."""
        for _ in range(2):
            self.round((63, 40), PRESENT, region(1, FIRST, found=False), region(2, SECOND))


def test_what_is_in_the_gripper_is_the_object_that_lay_there() -> None:
    story = Story((0.0, 1.0, 0.0))
    story.round((63, 40), PRESENT, region(1, FIRST, found=False), region(2, SECOND))
    types = [story.register.type_in_gripper]
    story.explore_first()
    types.append(story.register.type_in_gripper)
    assert story.register.known == [FoodType.PUSHABLE, FoodType.UNKNOWN]
    story.round((50, 40), EMPTY, region(1, FIRST), region(2, SECOND))
    types.append(story.register.type_in_gripper)
    assert types == [FoodType.UNKNOWN, FoodType.PUSHABLE, FoodType.UNKNOWN], "not before a whole round"


@pytest.mark.parametrize("motors", [STILL._replace(left=1), STILL._replace(right=-1)])
def test_nothing_is_identified_on_the_move(motors: Motors) -> None:
    story = Story()
    for _ in range(5):
        story.round((63, 40), PRESENT, region(1, FIRST, found=False), region(2, SECOND), motors=motors)
    assert story.register.known == [FoodType.UNKNOWN] * 2


def test_gripped_food_is_not_delivered_even_where_it_can_be_seen_at_home() -> None:
    story = Story()
    story.explore_first()
    at_home = (HOME[0] - 2, HOME[1])
    story.round((at_home[0] - 11, at_home[1]), GRIPPED, region(1, at_home), region(2, SECOND))
    assert story.register.delivered == [False, False]
    story.round((at_home[0] - 20, at_home[1]), EMPTY, region(1, at_home), region(2, SECOND))
    assert story.register.delivered == [True, False]
    assert story.register.settled == {1}
    assert not story.register.finished


def test_a_region_that_is_only_remembered_at_home_delivers_nothing() -> None:
    story = Story()
    story.round((20, 60), EMPTY, region(1, HOME, found=False), region(2, SECOND))
    assert story.register.delivered == [False, False]


def test_carried_food_is_known_again_while_its_old_track_lingers() -> None:
    """The place where it lay cannot be seen yet, so the camera still remembers it there."""
    story = Story((0.0, 1.0, 0.0))
    story.explore_first()
    lingering = region(1, FIRST, found=False)
    story.round((63, 55), GRIPPED, lingering, region(2, SECOND))
    story.round((50, 55), EMPTY, lingering, region(2, SECOND), region(3, (74, 55)))
    assert story.register.object_of(3) == 0
    assert story.register.object_of(2) == 1


def test_carried_food_is_known_again_where_it_was_set_down_and_not_where_it_lay() -> None:
    story = Story((0.0, 1.0, 0.0))
    story.explore_first()
    # Carried to near the second, of which every trace is lost meanwhile.
    drop = (SECOND[0] + 2, SECOND[1] - 8)
    story.round((drop[0] - 11.6, drop[1]), GRIPPED)
    story.round((drop[0] - 25, drop[1]), EMPTY, region(3, drop))
    assert story.register.object_of(3) == 0
    story.round((drop[0] - 25, drop[1]), EMPTY, region(3, drop), region(4, SECOND))
    assert story.register.object_of(4) == 1


def test_food_that_was_lost_for_a_while_stays_what_it_is() -> None:
    story = Story((0.0, 0.0, 1.0))
    story.explore_first()
    story.round((40, 40), EMPTY, region(1, FIRST), region(2, SECOND))
    assert story.register.settled == {1}, "poison, and no longer held"
    story.round((40, 40), EMPTY, region(2, SECOND))
    assert story.register.settled == set()
    story.round((40, 40), EMPTY, region(2, SECOND), region(5, FIRST))
    assert story.register.settled == {5}
    assert story.register.deliverable == 1


def test_poison_in_the_gripper_is_still_the_nearest_food() -> None:
    story = Story((0.0, 0.0, 1.0))
    story.explore_first()
    assert story.register.settled == set()
    assert story.register.type_in_gripper == FoodType.POISONOUS


def test_food_of_the_next_enclosure_is_none_of_its_business() -> None:
    story = Story()
    beyond = (HOME[0], SITE.bounds[3] + 20)
    story.round((20, 60), EMPTY, region(1, FIRST), region(2, SECOND), region(9, beyond))
    assert story.register.object_of(9) is None


def test_more_regions_than_objects_are_tied_to_none() -> None:
    """Such as a glare on the floor."""
    story = Story()
    story.round((20, 60), EMPTY, region(1, FIRST), region(2, SECOND), region(9, HOME))
    assert story.register.object_of(9) is None
    assert story.register.delivered == [False, False]
