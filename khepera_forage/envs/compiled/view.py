"""What a picture shows of one world of a batch."""

from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.one_world import OneWorld
from khepera_forage.envs.recall import MARKER
from khepera_forage.envs.rendering import FoodView, RobotView, View
from khepera_forage.robots.khepera import ARM_ON_FLOOR
from khepera_forage.sim.arena import Arena, Pose
from khepera_forage.sim.compiled import rows as body
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector
from khepera_forage.vision.scene import Region


def view_of(
    world: OneWorld, arena: Arena, executed: Behaviour | None, confidence: tuple[float, ...] | None
) -> View:
    """Bodies as they truly are, and what the camera and the robot make of them.

    Args:
        world: Whose.
        arena: Where it lives.
        executed: What the robot did last.
        confidence: Confidence level of each behaviour, if it is an imitator.
    """
    robot, task = world.worlds.bodies.robots.tolist(), world.worlds.tasks.tolist()
    foods = world.worlds.bodies.food.reshape(-1, body.FOOD_ROWS).tolist()
    registers = world.worlds.registers.reshape(-1, at.TASK_FOOD_ROWS).tolist()
    own = _region(
        -1, robot[body.OWN_X], robot[body.OWN_Y], MARKER, robot[body.OWN_DEGREES], robot[body.OWN_FOUND]
    )
    regions = [own]
    for food in foods:
        if food[body.TRACK] >= 0:
            regions.append(
                _region(
                    food[body.TRACK], food[body.TRACK_X], food[body.TRACK_Y], 0, 0, food[body.TRACK_FOUND]
                )
            )
        if food[body.GHOST] >= 0:
            regions.append(_region(food[body.GHOST], food[body.GHOST_X], food[body.GHOST_Y], 0, 0, 0))
    shown = RobotView(
        pose=Pose(robot[body.X], robot[body.Y], robot[body.HEADING]),
        holes=MARKER,
        arm=robot[body.ARM_READ],
        jaw=robot[body.JAW_READ],
        proximity=tuple(int(reading) for reading in robot[body.PROXIMITY : body.PROXIMITY + 8]),
        name="robot",
        vector=StateVector(*(int(value) for value in task[at.VECTOR : at.VECTOR + 5])),
        state=State(int(task[at.STATE])),
        executed=executed,
        confidence=confidence,
        tracked=own.found,
    )
    raised = robot[body.ARM] < ARM_ON_FLOOR
    return View(
        arenas=(arena,),
        robots=(shown,),
        foods=tuple(
            FoodView(
                food[body.FOOD_X],
                food[body.FOOD_Y],
                FoodType(int(register[at.KNOWN])),
                raised and robot[body.HELD] == number,
                register[at.HOME] != 0,
            )
            for number, (food, register) in enumerate(zip(foods, registers, strict=True))
        ),
        regions=tuple(regions),
        title=f"Recall in the {arena.name}",
    )


def _region(label: float, x: float, y: float, holes: int, degrees: float, found: float) -> Region:
    """A region of which only the centre matters: outline and size are those of a point."""
    return Region(int(label), x, y, holes, int(degrees), found != 0, False, x, y, 1.0, 1.0, 1.0)
