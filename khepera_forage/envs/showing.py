"""From robots at their task to what a picture shows of them."""

import math
from collections.abc import Sequence

from khepera_forage.envs.forager import Forager
from khepera_forage.envs.rendering import FoodView, RobotView
from khepera_forage.foraging.states import Behaviour
from khepera_forage.worlds.world import World


def robot_shown(
    name: str,
    forager: Forager,
    world: World,
    index: int,
    heard: Behaviour | None = None,
    executed: Behaviour | None = None,
    confidence: tuple[float, ...] | None = None,
    separated: bool = False,
) -> RobotView:
    """One robot's part of a picture.

    Args:
        name: Written above its panel.
        forager: The robot at its task.
        world: Where it lives.
        index: Its number there.
        heard: What it heard, if anybody speaks.
        executed: What it did last.
        confidence: Confidence level of each behaviour, if it is an imitator.
        separated: Whether it is apart from its teacher.
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


def foods_shown(world: World, foragers: Sequence[Forager]) -> tuple[FoodView, ...]:
    """All food, with what its own arena's robot knows of it.

    Args:
        world: Where it lies, arena by arena in the order of the foragers.
        foragers: One an arena.
    """
    known = [
        (food_type, delivered)
        for forager in foragers
        for food_type, delivered in zip(forager.register.known, forager.register.delivered, strict=True)
    ]
    return tuple(
        FoodView(x=place.x, y=place.y, food_type=food_type, lifted=place.lifted, delivered=delivered)
        for place, (food_type, delivered) in zip(world.food_places(), known, strict=True)
        if math.isfinite(place.x)
    )
