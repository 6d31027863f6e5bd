"""Perception in every world of a block: the food tracker, raw data, state vector and state."""

from typing import Any

import numpy as np

from khepera_forage.compilation.decorators import inline, kernel, variant
from khepera_forage.envs.compiled import rules  # noqa: F401 (registers the rules)
from khepera_forage.envs.compiled.arena_maps import are_several, arena_maps, map_in
from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.envs.compiled.raw_data import perceived, senses_in
from khepera_forage.envs.compiled.ways_home import begin_ways_home, known_ways_in
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.geometry.nearest_wall import find_nearest_walls, is_among_four, is_nearer
from khepera_forage.geometry.walls import to_wall
from khepera_forage.robots.khepera import Motors
from khepera_forage.task.food_tracking import update_food
from khepera_forage.task.identification import explored
from khepera_forage.task.perception import state_vector, without_food
from khepera_forage.task.states import classify


@kernel
def remember_senses(robot: Any, task: Any) -> None:
    """Keep what the robots sense, before a round."""
    for i in range(robot.x.shape[0]):
        task.presence_before[i] = robot.object_presence[i]
        task.arm_before[i] = robot.arm_reading[i]
        task.jaw_before[i] = robot.jaw_reading[i]


@kernel
def track_food(worlds: Worlds, parameters: TaskParameters) -> None:
    """Account for what one round has brought, by the rule of `task.food_tracking`."""
    robot, task = worlds.bodies.robots, worlds.tasks
    maps, decisions = arena_maps(worlds.bodies.near, parameters), parameters.decisions[0]
    for i in range(robot.x.shape[0]):
        before = senses_in(task.presence_before[i], task.arm_before[i], task.jaw_before[i])
        after = senses_in(robot.object_presence[i], robot.arm_reading[i], robot.jaw_reading[i])
        present = robot.object_presence[i] != 0.0
        tracker = worlds.trackers[i]
        update_food(
            tracker,
            worlds.foods[i],
            known_ways_in(worlds, i),
            worlds.links[i],
            worlds.bodies.tracks[i],
            map_in(maps, task, i),
            robot.marker_x[i],
            robot.marker_y[i],
            robot.marker_heading[i],
            present,
            present and explored(before, after, Motors(robot.left[i], robot.right[i], 0, 0)),
            after.arm,
            decisions,
        )
        task.food_seen[i] = 1.0 if tracker.food_seen else 0.0
        task.food_x[i], task.food_y[i] = tracker.food_x, tracker.food_y
        task.food_way_x[i], task.food_way_y[i] = tracker.food_way_x, tracker.food_way_y
        task.food_path[i] = tracker.food_path
        task.food_type[i] = tracker.type_in_gripper


@inline  # with one caller in each entrance: its arguments, some hundred numbers, need not be handed over
def perceive_block(worlds: Worlds, parameters: TaskParameters) -> None:
    """Raw data, state vector and state, once food is tracked."""
    robot, task = worlds.bodies.robots, worlds.tasks
    maps, decisions = arena_maps(worlds.bodies.near, parameters), parameters.decisions[0]
    _find_nearest_walls(maps, worlds)
    begin_ways_home(worlds, maps, parameters)
    for i in range(robot.x.shape[0]):
        arena = map_in(maps, task, i)
        raw = perceived(worlds, i, arena)
        task.food_type[i] = raw.food_type
        task.wall_distance[i], task.wall_bearing[i] = raw.wall_distance, raw.wall_bearing
        task.home_distance[i], task.home_bearing[i] = raw.home_distance, raw.home_bearing
        task.home_path[i] = raw.home_path
        task.food_distance[i], task.food_bearing[i] = raw.food_distance, raw.food_bearing
        task.food_path[i] = raw.food_path
        vector = state_vector(raw, without_food(worlds.trackers[i], arena, decisions), decisions)
        task.object_presence[i] = vector.object_presence
        task.robot_home_distance[i] = vector.robot_home_distance
        task.vector_food_type[i] = vector.food_type
        task.arms_height[i] = vector.arms_height
        task.robot_food_distance[i] = vector.robot_food_distance
        task.state[i] = classify(vector, arena.home_radius, decisions).value


def _find_nearest_walls(maps: Any, worlds: Worlds) -> None:
    """From each robot to the nearest point of a wall: wall by wall, for many robots at once."""
    robot, task = worlds.bodies.robots, worlds.tasks
    for i in range(robot.x.shape[0]):
        task.wall_squared[i] = np.inf
    for k in range(maps.walls.shape[0]):
        wall = maps.walls[k]
        for i in range(robot.x.shape[0]):
            dx, dy = to_wall(
                robot.marker_x[i], robot.marker_y[i], wall.x1, wall.y1, wall.ex, wall.ey, wall.share
            )
            squared = dx * dx + dy * dy
            nearer = squared < task.wall_squared[i]
            task.wall_squared[i] = squared if nearer else task.wall_squared[i]
            task.wall_x[i] = dx if nearer else task.wall_x[i]
            task.wall_y[i] = dy if nearer else task.wall_y[i]


@variant(_find_nearest_walls, are_several)
def _find_nearest_walls_world_by_world(maps: Any, worlds: Worlds) -> None:
    robot, task = worlds.bodies.robots, worlds.tasks
    for i in range(robot.x.shape[0]):
        known, x, y = worlds.nearest_walls[i], robot.marker_x[i], robot.marker_y[i]
        if not is_among_four(known, x, y):
            walls = map_in(maps, task, i).walls
            find_nearest_walls(known, x, y, walls)
            _keep_wall(task, 0, i, walls[known.first])
            _keep_wall(task, 1, i, walls[known.second])
            _keep_wall(task, 2, i, walls[known.third])
            _keep_wall(task, 3, i, walls[known.fourth])
    for i in range(robot.x.shape[0]):
        one_x, one_y = _to_nearer_of_kept(robot, task, 0, i)
        other_x, other_y = _to_nearer_of_kept(robot, task, 2, i)
        nearer = is_nearer(one_x, one_y, other_x, other_y)
        task.wall_x[i], task.wall_y[i] = one_x if nearer else other_x, one_y if nearer else other_y


@inline
def _keep_wall(task: Any, k: int, i: int, wall: Any) -> None:
    task.nearest_x1[k, i], task.nearest_y1[k, i], task.nearest_share[k, i] = wall.x1, wall.y1, wall.share
    task.nearest_ex[k, i], task.nearest_ey[k, i] = wall.ex, wall.ey


@inline
def _to_nearer_of_kept(robot: Any, task: Any, k: int, i: int) -> tuple[float, float]:
    """From a robot to the nearer of kept walls k and k + 1."""
    one_x, one_y = _to_kept_wall(robot, task, k, i)
    other_x, other_y = _to_kept_wall(robot, task, k + 1, i)
    nearer = is_nearer(one_x, one_y, other_x, other_y)
    return one_x if nearer else other_x, one_y if nearer else other_y


@inline
def _to_kept_wall(robot: Any, task: Any, k: int, i: int) -> tuple[float, float]:
    x1, y1, share = task.nearest_x1[k, i], task.nearest_y1[k, i], task.nearest_share[k, i]
    ex, ey = task.nearest_ex[k, i], task.nearest_ey[k, i]
    return to_wall(robot.marker_x[i], robot.marker_y[i], x1, y1, ex, ey, share)
