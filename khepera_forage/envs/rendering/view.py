"""Content of a picture as plain values, and how environments fill them in, without drawing anything."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from khepera_forage.envs.forager import Forager
from khepera_forage.envs.training_episode import TrainingEpisode
from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.sim.world import World
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector
from khepera_forage.vision.scene import Region


class RobotView(NamedTuple):
    """One robot: its true pose, its senses, and its decision.

    Attributes:
        pose: True position (mm) and heading (radians). With values that are not finite only the panel is drawn.
        holes: Number of holes in its marker: 1 on the teacher, 2 on a learner.
        arm: 255 (down) to 215 (raised).
        jaw: 200 (open) to 0 (closed).
        proximity: The eight infra-red readings 0..1023, in the order of `Senses`.
        name: For example "teacher" or "learner 1".
        vector: The state vector that it perceives now; None if there is none yet.
        state: The state to which the vector belongs.
        heard: The behaviour heard, with WAIT for silence; None in a task without a teacher.
        executed: The behaviour executed in the last round; None before the first.
        correct: What the teacher would have executed in its place; None if that is not known.
        confidence: Confidence level of each behaviour, SEARCH FOR FOOD first; None if the robot is no imitator.
        separated: Whether the learner is separated from the teacher.
        tracked: Whether the camera tracks its marker now.
        has_gripper: Whether it has a gripper, and a marker that is larger than the robot.
    """

    pose: Pose
    holes: int
    arm: float
    jaw: float
    proximity: tuple[int, ...]
    name: str
    vector: StateVector | None = None
    state: State | None = None
    heard: Behaviour | None = None
    executed: Behaviour | None = None
    correct: Behaviour | None = None
    confidence: tuple[float, ...] | None = None
    separated: bool = False
    tracked: bool = True
    has_gripper: bool = True


class FoodView(NamedTuple):
    """One food object at its true position.

    Attributes:
        x: Centre in mm.
        y: Centre in mm.
        food_type: Its identified type; UNKNOWN before identification.
        lifted: Whether a gripper holds it above the floor.
        delivered: Whether it counts as delivered.
    """

    x: float
    y: float
    food_type: FoodType = FoodType.UNKNOWN
    lifted: bool = False
    delivered: bool = False


class View(NamedTuple):
    """Everything that one picture shows.

    The size of the picture depends only on the arenas and on the number of robots, so that all pictures of an episode
    have the same size.

    Attributes:
        arenas: At least one.
        robots: One panel each, in this order.
        foods: Every object on the floor or in a gripper.
        regions: Regions reported by the camera, in its pixels of 5 mm.
        step: Number of steps so far.
        limit: Greatest number of steps, if there is a limit.
        score: In percent, if the task has a score.
        delivered: Number of food objects delivered so far.
        title: Heading of the picture.
    """

    arenas: tuple[Arena, ...]
    robots: tuple[RobotView, ...] = ()
    foods: tuple[FoodView, ...] = ()
    regions: tuple[Region, ...] = ()
    step: int = 0
    limit: int | None = None
    score: float | None = None
    delivered: int = 0
    title: str = ""


def recall_view(arena: Arena, world: World, forager: Forager, limit: int, **robot: Any) -> View:
    """What a picture of a recall of at most `limit` steps shows; `robot` are further attributes of its `RobotView`."""
    return View(
        arenas=(arena,),
        robots=(_robot_view("robot", forager, world.poses()[0], **robot),),
        foods=_food_views(world, (forager,)),
        regions=world.camera.look().regions,
        step=forager.episode.steps,
        limit=limit,
        score=forager.episode.score,
        delivered=forager.tracker.delivered,
        title=f"Recall in the {arena.name.replace('_', ' ')}",
    )


def training_view(
    arenas: Sequence[Arena], world: World, attempt: TrainingEpisode, agents: Sequence[str], limit: int
) -> View:
    """What a picture of a training episode of at most `limit` rounds shows; `agents` are the environment's."""
    foragers, poses = attempt.foragers, world.poses()
    decided: Any = attempt.decided or [(None, None)] * len(agents)
    robots = []
    for i, agent in enumerate(agents):
        name = agent.replace("_", " ") if i > 0 and len(agents) > 2 else agent.replace("_0", "")
        shown = {"heard": decided[0][0] if i > 0 else None, "separated": attempt.pairings[i].separated}
        shown["executed"], shown["correct"] = decided[i]
        robots.append(_robot_view(name, foragers[i], poses[i], **shown))
    return View(
        arenas=tuple(arenas),
        robots=tuple(robots),
        foods=_food_views(world, foragers),
        regions=world.camera.look().regions,
        step=attempt.account.rounds,
        limit=limit,
        delivered=sum(forager.tracker.delivered for forager in foragers),
        title=f"Training in the {arenas[0].name.replace('_', ' ')}",
    )


def _robot_view(name: str, forager: Forager, pose: Pose, **shown: Any) -> RobotView:
    senses = forager.senses
    return RobotView(
        pose=pose,
        holes=forager.holes,
        arm=senses.arm,
        jaw=senses.jaw,
        proximity=senses.proximity,
        name=name,
        vector=forager.vector,
        state=forager.state,
        tracked=forager.raw.tracked,
        has_gripper=forager.robot.has_gripper,
        **shown,
    )


def _food_views(world: World, foragers: Sequence[Forager]) -> tuple[FoodView, ...]:
    """The views of all food, with the type and delivery status in the food tracker of its arena's robot."""
    known = [food for forager in foragers for food in forager.food.objects]
    return tuple(
        FoodView(place.x, place.y, FoodType(food.known), place.lifted, food.delivered)
        for place, food in zip(world.food_places(), known, strict=True)
        if math.isfinite(place.x)
    )
