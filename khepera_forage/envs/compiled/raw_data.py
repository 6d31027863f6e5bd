"""The raw data of one world of a block, as it is perceived and from its records."""

from typing import Any

from khepera_forage.compilation.decorators import inline
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.robots.khepera import Senses
from khepera_forage.task.arena_map import ArenaMap
from khepera_forage.task.perception import RawData, raw_data


@inline
def senses_in(present: float, arm: float, jaw: float) -> Senses:
    """The senses that rules of the task need, without infra-reds and encoders."""
    return Senses((0, 0, 0, 0, 0, 0, 0, 0), 0, 0, int(arm), int(jaw), int(present))


@inline
def perceived(worlds: Worlds, i: int, arena: ArenaMap) -> RawData:
    """The raw data of one lane, once its ways, its nearest wall and its food are found; without infra-reds."""
    robot, task = worlds.bodies.robots, worlds.tasks
    return raw_data(
        senses_in(robot.object_presence[i], robot.arm_reading[i], robot.jaw_reading[i]),
        robot.marker_x[i],
        robot.marker_y[i],
        int(robot.marker_heading[i]),
        robot.marker_found[i] != 0.0,
        task.food_seen[i] != 0.0,
        task.food_x[i],
        task.food_y[i],
        int(task.food_type[i]),
        task.wall_x[i],
        task.wall_y[i],
        (task.home_way_x[i], task.home_way_y[i], task.home_path[i]),
        (task.food_way_x[i], task.food_way_y[i], task.food_path[i]),
        arena,
    )


@inline
def raw_data_in(robot: Any, task: Any, i: int, arena: ArenaMap) -> RawData:
    """The raw data of the last round in one lane."""
    return RawData(
        (
            int(robot.proximity[0, i]),
            int(robot.proximity[1, i]),
            int(robot.proximity[2, i]),
            int(robot.proximity[3, i]),
            int(robot.proximity[4, i]),
            int(robot.proximity[5, i]),
        ),
        int(robot.arm_reading[i]),
        int(robot.jaw_reading[i]),
        int(robot.object_presence[i]),
        robot.marker_x[i],
        robot.marker_y[i],
        int(robot.marker_heading[i]),
        robot.marker_found[i] != 0.0,
        task.food_seen[i] != 0.0,
        task.food_x[i],
        task.food_y[i],
        int(task.food_type[i]),
        arena.home_x,
        arena.home_y,
        arena.home_radius,
        arena.home_opening,
        task.wall_distance[i],
        task.wall_bearing[i],
        task.home_distance[i],
        task.home_bearing[i],
        task.home_path[i],
        task.food_distance[i],
        task.food_bearing[i],
        task.food_path[i],
        task.food_way_x[i],
        task.food_way_y[i],
    )
