"""Views of the robots and the food in an environment, for its pictures."""

import math
from collections.abc import Sequence

from khepera_forage.envs.forager import Forager
from khepera_forage.envs.rendering.view import FoodView, RobotView
from khepera_forage.sim.world import World
from khepera_forage.task.states import Behaviour, FoodType


def robot_view(
    name: str,
    forager: Forager,
    world: World,
    index: int,
    heard: Behaviour | None = None,
    executed: Behaviour | None = None,
    confidence: tuple[float, ...] | None = None,
    separated: bool = False,
) -> RobotView:
    """The view of one robot.

    Args:
        name: Written on its panel.
        forager: The robot, with its state vector and state.
        world: The world that contains the robot.
        index: Number of the robot in the world.
        heard: The behaviour heard; None in a task without a teacher.
        executed: The last behaviour executed.
        confidence: Confidence level of each behaviour, if the robot is an imitator.
        separated: Whether the robot is separated from its teacher.
    """
    senses = forager.senses
    return RobotView(
        pose=world.poses()[index],
        holes=forager.holes,
        arm=senses.arm,
        jaw=senses.jaw,
        proximity=senses.proximity,
        name=name,
        vector=forager.vector,
        state=forager.state,
        heard=heard,
        executed=executed,
        confidence=confidence,
        separated=separated,
        tracked=forager.own.found,
    )


def food_views(world: World, foragers: Sequence[Forager]) -> tuple[FoodView, ...]:
    """The views of all food, with the type and delivery status in the food tracker of its arena's robot.

    Args:
        world: Gives the true places of food, arena by arena in the order of the foragers.
        foragers: One per arena.
    """
    known = [(FoodType(food.known), food.delivered) for forager in foragers for food in forager.tracker.foods]
    return tuple(
        FoodView(x=place.x, y=place.y, food_type=food_type, lifted=place.lifted, delivered=delivered)
        for place, (food_type, delivered) in zip(world.food_places(), known, strict=True)
        if math.isfinite(place.x)
    )
