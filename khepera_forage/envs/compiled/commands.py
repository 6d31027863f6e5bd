"""What robots are commanded in every world of a block: the motors of behaviours, or given motors."""

from typing import Any

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.envs.compiled import rules  # noqa: F401 (registers the rules)
from khepera_forage.envs.compiled.arena_maps import arena_maps, map_in
from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.envs.compiled.raw_data import raw_data_in
from khepera_forage.envs.compiled.ways_home import find_ways_home
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, Motors, applicable
from khepera_forage.task.actions import decode_motors
from khepera_forage.task.behaviours import command
from khepera_forage.task.states import Behaviour

_WAIT = float(Behaviour.WAIT)


@inline
def drive(robot: Any, i: int, motors: Motors) -> None:
    """Give one robot its motors; before its first frame it stands as it was put down."""
    new = robot.first_frame[i] != 0.0
    robot.left[i] = 0.0 if new else motors.left
    robot.right[i] = 0.0 if new else motors.right
    robot.arm_target[i] = ARM_RAISED if new else motors.arm
    robot.jaw_target[i] = JAW_OPEN if new else motors.jaw


@kernel
def drive_behaviours(worlds: Worlds, parameters: TaskParameters) -> None:
    """Command what the behaviour decided on commands, in every lane."""
    robot, task = worlds.bodies.robots, worlds.tasks
    maps, decisions = arena_maps(worlds.bodies.near, parameters), parameters.decisions[0]
    find_ways_home(worlds, parameters, task.behaviour)
    for i in range(robot.x.shape[0]):
        motors = command(
            int(task.behaviour[i]), raw_data_in(robot, task, i, map_in(maps, task, i)), decisions
        )
        robot.left[i], robot.right[i] = motors.left, motors.right
        robot.arm_target[i], robot.jaw_target[i] = motors.arm, motors.jaw
    # In a loop of its own, because it does the same in every lane: one instruction then works on several.
    for i in range(robot.x.shape[0]):
        motors = Motors(robot.left[i], robot.right[i], robot.arm_target[i], robot.jaw_target[i])
        drive(robot, i, applicable(motors))


@kernel
def drive_actions(worlds: Worlds, actions: Any, parameters: TaskParameters) -> None:
    """Command the motors of actions, one row of four numbers in -1..1 a lane.

    The behaviour is then the state where they are what the teacher would command, and WAIT elsewhere.
    """
    robot, task = worlds.bodies.robots, worlds.tasks
    maps, decisions = arena_maps(worlds.bodies.near, parameters), parameters.decisions[0]
    find_ways_home(worlds, parameters, task.state)
    for i in range(robot.x.shape[0]):
        arena = map_in(maps, task, i)
        given = applicable(decode_motors(actions[i, 0], actions[i, 1], actions[i, 2], actions[i, 3]))
        right = applicable(command(int(task.state[i]), raw_data_in(robot, task, i, arena), decisions))
        same = (
            given.left == right.left
            and given.right == right.right
            and given.arm == right.arm
            and given.jaw == right.jaw
        )
        task.behaviour[i] = task.state[i] if same else _WAIT
        drive(robot, i, given)
