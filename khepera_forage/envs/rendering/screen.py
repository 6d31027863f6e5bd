"""From robots at their task to what a picture shows of them, and the screen that shows it."""

import math
from collections.abc import Callable, Sequence

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.forager import Forager
from khepera_forage.envs.rendering import FoodView, Renderer, RobotView, View
from khepera_forage.sim.world import World
from khepera_forage.task.states import Behaviour, FoodType

RENDER_MODES = ("human", "rgb_array")


class Screen:
    """Where an environment shows itself; the window, if any, opens with the first picture.

    Args:
        mode: One of `RENDER_MODES`, or None.

    Raises:
        ValueError: Another mode.
    """

    def __init__(self, mode: str | None) -> None:
        if mode is not None and mode not in RENDER_MODES:
            raise ValueError(f"render_mode is {mode!r}; allowed: None, {', '.join(map(repr, RENDER_MODES))}")
        self._mode = mode
        self._renderer: Renderer | None = None

    def show(self, view: Callable[[], View]) -> NDArray[np.uint8] | None:
        """A picture as an array in mode `rgb_array`, in the window in mode `human`.

        Args:
            view: Called for what to show.
        """
        if self._mode is None:
            gym.logger.warn(
                "render() without a render_mode; make the environment with render_mode='rgb_array'"
            )
            return None
        if self._renderer is None:
            self._renderer = Renderer(self._mode)
        return self._renderer.draw(view())

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


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
    known = [(FoodType(food.known), food.delivered) for forager in foragers for food in forager.tracker.foods]
    return tuple(
        FoodView(x=place.x, y=place.y, food_type=food_type, lifted=place.lifted, delivered=delivered)
        for place, (food_type, delivered) in zip(world.food_places(), known, strict=True)
        if math.isfinite(place.x)
    )
