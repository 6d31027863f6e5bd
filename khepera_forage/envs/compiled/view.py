"""What a picture of a compiled world shows."""

from typing import Any

from khepera_forage.envs.compiled.forager import CompiledForager
from khepera_forage.envs.compiled.one_world import OneWorld
from khepera_forage.envs.rendering import FoodView, RobotView, View
from khepera_forage.robots.khepera import ARM_ON_FLOOR
from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.vision.scene import Region


def view_of(
    world: OneWorld,
    arena: Arena,
    forager: CompiledForager,
    executed: Behaviour | None,
    confidence: tuple[float, ...] | None,
) -> View:
    """Bodies as they truly are, and what the camera and the robot make of them.

    Args:
        world: The world.
        arena: Its arena.
        forager: Its robot.
        executed: What the robot did last.
        confidence: Confidence level of each behaviour, if it is an imitator.
    """
    robot, foods = world.worlds.bodies.robots[0], world.worlds.bodies.foods[0]
    raw = forager.raw
    own = _region(-1, raw.x, raw.y, forager.holes, raw.orientation, raw.tracked)
    tracks = sorted(world.worlds.bodies.tracks[0, 0].tolist())
    regions = [own]
    for label, x, y, holes, found, _ in tracks:
        if label >= 0:
            regions.append(_region(label, x, y, holes, 0, found))
    shown = RobotView(
        pose=Pose(*(float(robot[name][0]) for name in ("x", "y", "heading"))),
        holes=forager.holes,
        arm=forager.senses.arm,
        jaw=forager.senses.jaw,
        proximity=forager.senses.proximity,
        name="robot",
        vector=forager.vector,
        state=forager.state,
        executed=executed,
        confidence=confidence,
        tracked=own.found,
    )
    raised = robot["arm"][0] < ARM_ON_FLOOR
    return View(
        arenas=(arena,),
        robots=(shown,),
        foods=tuple(
            FoodView(
                float(food["x"][0]),
                float(food["y"][0]),
                FoodType(known.known),
                bool(raised and robot["held"][0] == number),
                known.delivered,
            )
            for number, (food, known) in enumerate(zip(foods, forager.tracker.foods, strict=True))
        ),
        regions=tuple(regions),
        title=f"Recall in the {arena.name}",
    )


def _region(label: int, x: float, y: float, holes: int, degrees: int, found: Any) -> Region:
    """A region of which only the centre matters: outline and size are those of a point."""
    return Region(label, x, y, holes, degrees, bool(found), False, x, y, 1.0, 1.0, 1.0)
