"""When food is identified and delivered, and how its type is drawn (4.2.3, 5.3)."""

import pytest

from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.robots.khepera import Motors, Senses
from khepera_forage.task.food_tracking import at_home, drawn_type, explored
from khepera_forage.task.states import FoodType
from tests.version_0_1 import CORRIDOR


@pytest.mark.parametrize(
    ("draw", "odds", "food_type"),
    [
        (0.0, (1.0, 0.0), FoodType.PICKABLE),
        (0.999, (1.0, 0.0), FoodType.PICKABLE),
        (0.0, (0.0, 1.0), FoodType.PUSHABLE),
        (0.0, (0.0, 0.0), FoodType.POISONOUS),
        (0.49, (0.5, 0.25), FoodType.PICKABLE),
        (0.51, (0.5, 0.25), FoodType.PUSHABLE),
        (0.76, (0.5, 0.25), FoodType.POISONOUS),
    ],
)
def test_drawn_type_follows_the_odds(draw: float, odds: tuple[float, float], food_type: FoodType) -> None:
    assert drawn_type(draw, (*odds, 1 - sum(odds))) == food_type


def test_explored_needs_one_still_round_with_arm_down_and_jaw_open() -> None:
    in_place = Senses((0,) * 8, 0, 0, 255, 200, 255)
    still = Motors(0, 0, 255, 200)
    assert explored(in_place, in_place, still)
    assert not explored(in_place._replace(object_presence=0), in_place, still)
    assert not explored(in_place, in_place._replace(object_presence=0), still)
    assert not explored(in_place._replace(arm=215), in_place, still)
    assert not explored(in_place, in_place._replace(jaw=126), still)
    assert not explored(in_place, in_place._replace(arm=215), still)
    assert not explored(in_place._replace(jaw=126), in_place, still)
    assert not explored(in_place, in_place, still._replace(left=1))
    assert not explored(in_place, in_place, still._replace(right=-1))


def test_at_home_is_a_disc_with_its_rim() -> None:
    arena = arena_map_of(CORRIDOR)._replace(home_x=10.0, home_y=0.0, home_radius=20)
    assert at_home(10, 20, arena)
    assert at_home(-10, 0, arena)
    assert not at_home(10, 20.1, arena)
    assert not at_home(25, 15, arena)
