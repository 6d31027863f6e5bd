"""Views of the robots and the food in an environment, for its pictures."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from khepera_forage.envs.rendering.view import FoodView, RobotView, View
from khepera_forage.envs.training_episode import TrainingEpisode
from khepera_forage.robots.khepera import Senses
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.world import World
from khepera_forage.task.food_tracking import FoodTracker
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector


class ForagingRobot(Protocol):
    """What a picture shows of a robot at its task, on either backend."""

    holes: int
    senses: Senses
    raw: RawData
    vector: StateVector
    state: State
    tracker: FoodTracker


def robot_view(
    name: str,
    forager: ForagingRobot,
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
        tracked=forager.raw.tracked,
    )


def food_views(world: World, foragers: Sequence[ForagingRobot]) -> tuple[FoodView, ...]:
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


def recall_view(
    arena: Arena,
    world: World,
    forager: ForagingRobot,
    info: Mapping[str, Any],
    limit: int,
    executed: Behaviour | None,
    confidence: tuple[float, ...] | None,
) -> View:
    """What a picture of a recall shows.

    Args:
        arena: Where the robot forages.
        world: Its bodies, and the camera.
        forager: The robot at its task.
        info: The environment's info.
        limit: Steps of an episode, at most.
        executed: The last behaviour executed.
        confidence: Confidence level of each behaviour, if the robot is an imitator.
    """
    return View(
        arenas=(arena,),
        robots=(robot_view("robot", forager, world, 0, None, executed, confidence),),
        foods=food_views(world, (forager,)),
        regions=world.camera.look().regions,
        step=info["steps"],
        limit=limit,
        score=info["score"],
        delivered=info["delivered"],
        title=f"Recall in the {_spoken(arena)}",
    )


def training_view(
    arenas: Sequence[Arena], world: World, attempt: TrainingEpisode, agents: Sequence[str], limit: int
) -> View:
    """What a picture of a training episode shows.

    Args:
        arenas: One for each robot.
        world: Its bodies, and the camera.
        attempt: The robots at their tasks, and what they do.
        agents: Their names in the environment, the teacher's first.
        limit: Rounds of an episode, at most.
    """
    foragers, actions = attempt.foragers, attempt.actions
    started = attempt.steps > 0
    robots = tuple(
        robot_view(
            "teacher" if i == 0 else agent.replace("_", " ") if len(agents) > 2 else agent.replace("_0", ""),
            foragers[i],
            world,
            i,
            heard=Behaviour(actions[0]) if i and started else None,
            executed=Behaviour(actions[i]) if started else None,
            separated=attempt.pairings[i].separated,
        )
        for i, agent in enumerate(agents)
    )
    return View(
        arenas=tuple(arenas),
        robots=robots,
        foods=food_views(world, foragers),
        regions=world.camera.look().regions,
        step=attempt.steps,
        limit=limit,
        delivered=sum(forager.tracker.delivered for forager in foragers),
        title=f"Training in the {_spoken(arenas[0])}",
    )


def _spoken(arena: Arena) -> str:
    """The name of an arena as it is read in a title: `t_maze` is "t maze"."""
    return arena.name.replace("_", " ")
