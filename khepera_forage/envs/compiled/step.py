"""One round of one compiled world at its task.

A round is `drive` with the motors of a behaviour or an action, then `carry_out`. `begin` starts an episode, whose first
frame is taken by the first round.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.compilation import register, rule
from khepera_forage.envs.compiled.arenas import ArenaRecords, ground_of, map_of
from khepera_forage.geometry import paths
from khepera_forage.geometry.paths import ChosenWaypoint
from khepera_forage.records import dtype_of
from khepera_forage.robots import footprint
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, Motors, applicable
from khepera_forage.sim.compiled.world import advance, detection_dtype, food_dtype, robot_dtype, track_dtype
from khepera_forage.sim.driving import put_down, set_motors
from khepera_forage.sim.records import Enclosure
from khepera_forage.sim.sensing import forget_tracks
from khepera_forage.task import arena_map, behaviours, episode, food_tracking, pairing, perception, placement, states
from khepera_forage.task.arena_map import ArenaMap
from khepera_forage.task.behaviours import command, path_home_for
from khepera_forage.task.episode import ForagerState, begin_episode, end_step
from khepera_forage.task.food_tracking import FoodObject, FoodTracker, KnownFood, Link, can_explore
from khepera_forage.task.perception import Marker, RawData, perceive
from khepera_forage.task.placement import draw_food_types, draw_layout, food_type_key, layout_key
from khepera_forage.vision.scene import MM_PER_PIXEL

register(paths, footprint)
register(arena_map, behaviours, episode, food_tracking, pairing, perception, placement, states)


forager_dtype, raw_dtype, tracker_dtype, object_dtype, link_dtype, chosen_dtype = map(
    dtype_of, (ForagerState, RawData, FoodTracker, FoodObject, Link, ChosenWaypoint)
)


class WorldRecords(NamedTuple):
    """The records of one world; or of many, with one row a world.

    Attributes:
        robots: `RobotState`, its one robot.
        foragers: `ForagerState`, that robot at its task.
        raw: `RawData`, what it perceives.
        foods: `FoodState` records.
        trackers: `FoodTracker`, the one of its arena.
        objects: `FoodObject` records: what is known of the food.
        detections: `FoodDetection` records, which hold nothing between rounds.
        tracks: `Track` records, twice as many as food objects.
        links: `Link` records, as many as tracks.
        chosen: `ChosenWaypoint` records: on the way home, and to each food object.
    """

    robots: Any
    foragers: Any
    raw: Any
    foods: Any
    trackers: Any
    objects: Any
    detections: Any
    tracks: Any
    links: Any
    chosen: Any


def new_worlds(count: int, foods: int) -> WorldRecords:
    """Worlds without an episode, with room for this many food objects."""
    return WorldRecords(
        np.zeros((count, 1), robot_dtype),
        np.zeros((count, 1), forager_dtype),
        np.zeros((count, 1), raw_dtype),
        np.zeros((count, foods), food_dtype),
        np.zeros((count, 1), tracker_dtype),
        np.zeros((count, foods), object_dtype),
        np.zeros((count, foods), detection_dtype),
        np.zeros((count, 2 * foods), track_dtype),
        np.zeros((count, 2 * foods), link_dtype),
        np.zeros((count, 1 + foods), chosen_dtype),
    )


@rule
def world_of(worlds: WorldRecords, i: int) -> WorldRecords:
    """The records of one world."""
    return WorldRecords(
        worlds.robots[i],
        worlds.foragers[i],
        worlds.raw[i],
        worlds.foods[i],
        worlds.trackers[i],
        worlds.objects[i],
        worlds.detections[i],
        worlds.tracks[i],
        worlds.links[i],
        worlds.chosen[i],
    )


@rule
def begin(world: WorldRecords, arena: ArenaRecords, settings: Any, start_given: bool, places_given: bool) -> bool:
    """Begin an episode, whose first frame is taken in the coming round; returns whether there was room.

    The robot starts at a random place, unless its start is given, and stays where it is; food likewise.
    """
    forager, key = world.foragers[0], world.robots[0].key
    free = draw_layout(
        world.robots[0],
        world.foods,
        layout_key(key, forager.number),
        ground_of(arena),
        map_of(arena),
        settings.decisions,
        start_given,
        places_given,
    )
    stand_ready(world, settings)
    draw_food_types(world.objects, food_type_key(key, forager.number), settings.odds)
    forager.number += 1
    return bool(free)


@rule
def stand_ready(world: WorldRecords, settings: Any) -> None:
    """Put the robot down where it is, and forget what was known of the food."""
    robot, tracker = world.robots[0], world.trackers[0]
    robot.holes = settings.holes
    put_down(robot, settings.constants)
    forget_tracks(world.foods, world.tracks)
    tracker.held = -1
    tracker.type_in_gripper = tracker.delivered = tracker.poison_home = 0
    tracker.deliverable = len(world.foods)
    tracker.last_distance = -1.0
    for k in range(len(world.foods)):
        food, known = world.foods[k], world.objects[k]
        known.x, known.y = food.x / MM_PER_PIXEL, food.y / MM_PER_PIXEL
        known.known = known.side = 0
        known.delivered = known.carried = False
    for k in range(len(world.links)):
        world.links[k].label = -1
    for k in range(len(world.chosen)):
        world.chosen[k].x = world.chosen[k].y = math.inf


@rule
def motors_of(world: WorldRecords, arena: ArenaMap, settings: Any, behaviour: int) -> Motors:
    """What a behaviour commands now."""
    raw, decisions = world.raw[0], settings.decisions
    food = KnownFood(world.trackers[0], world.objects, world.links, world.chosen)
    if not world.robots[0].first_frame:  # before, nothing is perceived
        raw.home_bearing, raw.home_path = path_home_for(behaviour, raw, food, arena, decisions)
    return command(behaviour, raw, decisions)


@rule
def drive(world: WorldRecords, motors: Motors, behaviour: int) -> None:
    """Give the robot its motors, which amount to a behaviour; before its first frame it stands as it was put down."""
    robot = world.robots[0]
    world.foragers[0].behaviour = behaviour
    robot.left = robot.right = 0.0
    robot.arm_target, robot.jaw_target = ARM_RAISED, JAW_OPEN
    if not robot.first_frame:
        set_motors(robot, applicable(motors))


@rule
def carry_out(world: WorldRecords, arena: ArenaRecords, settings: Any) -> None:
    """One round, once the motors are commanded; and what it is worth."""
    robot, forager, tracker, numbers = world.robots[0], world.foragers[0], world.trackers[0], arena.numbers[0]
    correct, begins = forager.behaviour == forager.state, robot.first_frame
    exploring = can_explore(robot.senses) and robot.left == 0.0 and robot.right == 0.0
    everything = Enclosure(world.robots, world.foods, world.tracks, world.detections, arena.walls, arena.corners)
    advance(everything, numbers.anchor_x, numbers.anchor_y, settings.constants)
    food = KnownFood(tracker, world.objects, world.links, world.chosen)
    own = Marker(robot.marker_x, robot.marker_y, int(robot.marker_heading), robot.marker_found)
    raw, vector, state = perceive(food, own, world.tracks, robot.senses, exploring, map_of(arena), settings.decisions)
    _write_raw(world.raw[0], raw)
    shown, written = forager.own, forager.vector
    shown.x, shown.y, shown.orientation, shown.found = own.x, own.y, own.orientation, own.found
    written.object_presence, written.robot_home_distance = vector.object_presence, vector.robot_home_distance
    written.food_type, written.arms_height = vector.food_type, vector.arms_height
    written.robot_food_distance = vector.robot_food_distance
    forager.state = state.value
    if begins:
        begin_episode(forager.episode, tracker)
    else:
        end_step(forager.episode, tracker, correct, settings.limit)


@rule
def _write_raw(record: Any, raw: RawData) -> None:
    """Write raw data into their record."""
    for k in range(6):
        record.proximity[k] = raw.proximity[k]
    record.arm, record.jaw, record.object_presence = raw.arm, raw.jaw, raw.object_presence
    record.x, record.y, record.orientation, record.tracked = raw.x, raw.y, raw.orientation, raw.tracked
    record.food_seen, record.food_x, record.food_y = raw.food_seen, raw.food_x, raw.food_y
    record.food_type = int(raw.food_type)
    record.home_x, record.home_y, record.home_radius = raw.home_x, raw.home_y, raw.home_radius
    record.home_opening = raw.home_opening
    record.wall_distance, record.wall_bearing = raw.wall_distance, raw.wall_bearing
    record.home_distance, record.home_bearing = raw.home_distance, raw.home_bearing
    record.home_path = raw.home_path
    record.food_distance, record.food_bearing = raw.food_distance, raw.food_bearing
    record.food_path = raw.food_path
    record.food_waypoint_x, record.food_waypoint_y = raw.food_waypoint_x, raw.food_waypoint_y
