"""Scene and Senses to raw data (4.2.2), and raw data to the state vector (4.3)."""

import math
from typing import Any, NamedTuple

from khepera_forage.geometry.plane import bearing_of, length, to_nearest_wall, turn_to
from khepera_forage.robots.khepera import Senses
from khepera_forage.task.arena_map import ArenaMap, NextWaypoint, is_within, path_home
from khepera_forage.task.decisions import ALONG_PATH, LAST_DISTANCE, DecisionValues
from khepera_forage.task.food_tracking import KnownFood, can_explore, update_food
from khepera_forage.task.states import FoodType, State, StateVector, classify
from khepera_forage.vision.scene import Region, Scene


class RawData(NamedTuple):
    """The raw data of 4.2.2, one robot's; places in pixels, angles in degrees.

    Attributes:
        proximity: The six front infra-reds, 0..1023, from the left.
        arm: 255 (down) to 215 (raised).
        jaw: 200 (open) to 0 (closed).
        object_presence: 0 or 255.
        x: Of the robot.
        y: Of the robot.
        orientation: Whole degrees 0..359.
        tracked: Whether the camera sees the robot now; otherwise the pose is the last one seen (3.5).
        food_seen: Whether there is a candidate food at all.
        food_x: Nearest candidate food; 0 without one.
        food_y: Nearest candidate food; 0 without one.
        food_type: A `FoodType`; UNKNOWN unless a known object is in the gripper.
        home_x: Centre of its home.
        home_y: Centre of its home.
        home_radius: Of its home.
        home_opening: Degrees from the home to its open side, or `EVERY_SIDE`, see `ArenaMap`.
        wall_distance: To the nearest wall, which the robot is kept off by the camera (3.4).
        wall_bearing: Of the nearest point of that wall from the heading, -180..180, left positive.
        home_distance: To the centre of its home.
        home_bearing: Of the way home from the heading: of that centre, or of where to drive next to get around walls,
            or past poison with food in the gripper.
        home_path: Length of the way home.
        food_distance: To the nearest candidate food; 0 without one.
        food_bearing: Of the way to that food from the heading; 0 without one.
        food_path: Length of the way to that food; 0 without one.
        food_waypoint_x: The next waypoint to that food: the food itself where the way is clear; 0 without one.
        food_waypoint_y: Likewise.
    """

    proximity: tuple[int, int, int, int, int, int]
    arm: int
    jaw: int
    object_presence: int
    x: float
    y: float
    orientation: int
    tracked: bool
    food_seen: bool
    food_x: float
    food_y: float
    food_type: int
    home_x: float
    home_y: float
    home_radius: int
    home_opening: float
    wall_distance: float
    wall_bearing: float
    home_distance: float
    home_bearing: float
    home_path: float
    food_distance: float
    food_bearing: float
    food_path: float
    food_waypoint_x: float
    food_waypoint_y: float


class Marker(NamedTuple):
    """What perception needs of the region of a robot's marker, see `vision.scene.Region`."""

    x: float
    y: float
    orientation: int
    found: bool


def own_region(scene: Scene, arena: ArenaMap, holes: int) -> Region | None:
    """The robot's own marker: the region with as many holes in its own enclosure; None before it was ever seen."""
    for region in scene.regions:
        if region.holes == holes and is_within(region.x, region.y, arena):
            return region
    return None


def perceive(
    known: KnownFood,
    own: Any,
    regions: Any,
    senses: Senses,
    exploring: bool,
    arena: ArenaMap,
    decisions: DecisionValues,
) -> tuple[RawData, StateVector, State]:
    """What one robot perceives at the end of a round, after which its food is accounted for.

    The way home counts as straight until a behaviour uses it, see `behaviours.path_home_for`.

    Args:
        known: Of the food of its arena; changed in place.
        own: Its `Marker`, or the whole region.
        regions: Tracked regions, of which those without holes are food.
        senses: What the robot reports now.
        exploring: Whether the robot could explore food a round ago (`can_explore`), and has stood still since.
        arena: Its arena.
        decisions: `DecisionValues`.
    """
    update_food(known, regions, own, senses, exploring and can_explore(senses), arena, decisions)
    way = arena.home_x, arena.home_y, 0.0
    if perceives_paths(decisions) and paths_home_can_bend(known, arena):
        way = path_home(own.x, own.y, known, arena)
    raw = raw_data(senses, own, known.tracker, way, arena)
    vector = state_vector(raw, known.tracker.last_distance, arena.diagonal, decisions)
    return raw, vector, classify(vector, arena.home_radius, decisions)


def paths_home_can_bend(known: KnownFood, arena: ArenaMap) -> bool:
    """Whether a way home may lead around walls or past poison."""
    return len(arena.paths.corners) > 0 or bool(known.objects[0].may_be_poisonous)


def raw_data(senses: Senses, own: Any, tracker: Any, to_home: NextWaypoint, arena: ArenaMap) -> RawData:
    """Raw data of one robot, after the food tracker has accounted for the round; arguments as for `perceive`."""
    x, y, orientation = own.x, own.y, own.orientation
    near = senses.proximity
    home_waypoint_x, home_waypoint_y, home_path = to_home
    wall_x, wall_y = to_nearest_wall(x, y, arena.walls)
    home_distance = length(arena.home_x - x, arena.home_y - y)
    food_distance = length(tracker.food_x - x, tracker.food_y - y)
    food_bearing = turn_to(bearing_of(tracker.food_waypoint_x - x, tracker.food_waypoint_y - y), orientation)
    food_path = tracker.food_path if tracker.food_path > food_distance else food_distance
    return RawData(
        (near[0], near[1], near[2], near[3], near[4], near[5]),
        senses.arm,
        senses.jaw,
        senses.object_presence,
        x,
        y,
        orientation,
        own.found,
        tracker.food_seen,
        tracker.food_x,
        tracker.food_y,
        tracker.type_in_gripper if senses.object_presence else FoodType.UNKNOWN,
        arena.home_x,
        arena.home_y,
        arena.home_radius,
        arena.home_opening,
        math.sqrt(wall_x * wall_x + wall_y * wall_y),
        turn_to(bearing_of(wall_x, wall_y), orientation),
        home_distance,
        turn_to(bearing_of(home_waypoint_x - x, home_waypoint_y - y), orientation),
        home_path if home_path > home_distance else home_distance,
        food_distance if tracker.food_seen else 0.0,
        food_bearing if tracker.food_seen else 0.0,
        food_path if tracker.food_seen else 0.0,
        tracker.food_waypoint_x,
        tracker.food_waypoint_y,
    )


def state_vector(raw: RawData, last_distance: float, diagonal: int, decisions: DecisionValues) -> StateVector:
    """The five attributes of section 4.3, distances rounded to whole pixels and not above the arena's diagonal.

    The diagonal is the food distance where there is no candidate, and no `last_distance` (`FoodTracker`) is remembered.
    """
    by_path = perceives_paths(decisions)
    home = raw.home_path if by_path else raw.home_distance
    food = raw.food_path if by_path else raw.food_distance
    if not raw.food_seen:
        remembers = decisions.no_food_distance == LAST_DISTANCE and last_distance >= 0.0
        food = last_distance if remembers else float(diagonal)
    return StateVector(
        1 if raw.object_presence else 0,
        min(int(home + 0.5), diagonal),
        raw.food_type,
        raw.arm,
        min(int(food + 0.5), diagonal),
    )


def perceives_paths(decisions: DecisionValues) -> bool:
    """Whether the distances of the state vector are lengths of paths around walls."""
    along: bool = decisions.distances == ALONG_PATH
    return along
