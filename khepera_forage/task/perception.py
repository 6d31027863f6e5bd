"""Scene and Senses to raw data (4.2.2), and raw data to the state vector (4.3)."""

import math
from collections.abc import Container
from typing import NamedTuple

from khepera_forage.geometry.angles import bearing_of, length, turn_to
from khepera_forage.robots.khepera import Senses
from khepera_forage.task.states import FoodType, StateVector
from khepera_forage.vision.scene import Region, Scene

_OUTSIDE = 4.0
"""Pixels by which a region may seem to lie outside its enclosure and still belong to it."""


class Site(NamedTuple):
    """What a robot knows of its own arena from the beginning, in pixels.

    Attributes:
        home_x: Centre of its home.
        home_y: Centre of its home.
        home_radius: Whole pixels.
        home_opening: Degrees from the home to the middle of the floor: the side on which it can be passed.
        diagonal: Of the arena, whole pixels: the largest distance of 4.6.1.
        bounds: Smallest x and y, largest x and y.
        walls: For each wall one end, the way to the other, and the square of its length.
    """

    home_x: float
    home_y: float
    home_radius: int
    home_opening: float
    diagonal: int
    bounds: tuple[float, float, float, float]
    walls: tuple[tuple[float, float, float, float, float], ...]


def wall_of(x1: float, y1: float, x2: float, y2: float) -> tuple[float, float, float, float, float]:
    """A wall between two points as `Site.walls` keeps it."""
    ex, ey = x2 - x1, y2 - y1
    return x1, y1, ex, ey, ex * ex + ey * ey


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
        home_opening: Degrees from the home to the middle of the floor.
        wall_distance: To the nearest wall, which the robot is kept off by the camera (3.4).
        wall_bearing: Of the nearest point of that wall from the heading, -180..180, left positive.
        home_distance: To the centre of its home.
        home_bearing: Of that centre from the heading.
        food_distance: To the nearest candidate food; 0 without one.
        food_bearing: Of that food from the heading; 0 without one.
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
    food_distance: float
    food_bearing: float


def within(region: Region, site: Site) -> bool:
    """Whether a region lies in this enclosure."""
    x1, y1, x2, y2 = site.bounds
    return x1 - _OUTSIDE <= region.x <= x2 + _OUTSIDE and y1 - _OUTSIDE <= region.y <= y2 + _OUTSIDE


def own_region(scene: Scene, site: Site, holes: int) -> Region | None:
    """The robot's own marker: the region with as many holes in its own enclosure; None before it was ever seen."""
    for region in scene.regions:
        if region.holes == holes and within(region, site):
            return region
    return None


def nearest_food(scene: Scene, site: Site, x: float, y: float, settled: Container[int]) -> Region | None:
    """The nearest region without holes in the enclosure whose label is not settled; None without one.

    Args:
        scene: What the camera reports.
        site: The enclosure.
        x: Of the robot.
        y: Of the robot.
        settled: Labels that are no candidates: delivered or known to be poisonous.
    """
    nearest = None
    best = math.inf
    for region in scene.regions:
        if not region.holes and region.label not in settled and within(region, site):
            dx, dy = region.x - x, region.y - y
            squared = dx * dx + dy * dy
            if squared < best:
                nearest, best = region, squared
    return nearest


def perceive(senses: Senses, own: Region, food: Region | None, food_type: int, site: Site) -> RawData:
    """Raw data of one robot.

    Args:
        senses: What the robot reports of itself.
        own: Its marker's region.
        food: Region of the nearest candidate food, if any.
        food_type: Of the object in the gripper, as far as it is known.
        site: Its enclosure.
    """
    x, y = own.x, own.y
    nearest = math.inf
    wall_x = wall_y = 0.0
    for x1, y1, ex, ey, long in site.walls:
        # `way_to_wall`, written out: four calls would take one part in sixty of a simulated step.
        t = ((x - x1) * ex + (y - y1) * ey) / long
        t = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
        dx, dy = x1 + t * ex - x, y1 + t * ey - y
        squared = dx * dx + dy * dy
        if squared < nearest:
            nearest, wall_x, wall_y = squared, dx, dy
    if food is None:
        return raw_data(
            senses, x, y, own.orientation, own.found, False, 0.0, 0.0, food_type, wall_x, wall_y, site
        )
    return raw_data(
        senses, x, y, own.orientation, own.found, True, food.x, food.y, food_type, wall_x, wall_y, site
    )


def way_to_wall(
    x: float, y: float, x1: float, y1: float, ex: float, ey: float, squared: float
) -> tuple[float, float]:
    """From a place to the nearest point of a wall as `Site.walls` keeps it."""
    t = ((x - x1) * ex + (y - y1) * ey) / squared
    t = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
    return x1 + t * ex - x, y1 + t * ey - y


def raw_data(
    senses: Senses,
    x: float,
    y: float,
    orientation: int,
    tracked: bool,
    food_seen: bool,
    food_x: float,
    food_y: float,
    food_type: int,
    wall_x: float,
    wall_y: float,
    site: Site,
) -> RawData:
    """Raw data of one robot, once its regions have been picked from the scene.

    Args:
        senses: What the robot reports of itself.
        x: Of its marker's region.
        y: Of its marker's region.
        orientation: Of its marker's region.
        tracked: Whether that region is tracked now.
        food_seen: Whether there is a candidate food.
        food_x: Of the nearest one; 0 without one.
        food_y: Of the nearest one; 0 without one.
        food_type: Of the object in the gripper, as far as it is known.
        wall_x: From the robot to the nearest point of a wall.
        wall_y: From the robot to the nearest point of a wall.
        site: Its enclosure.
    """
    a, b, c, d, e, f, _, _ = senses.proximity
    home_x, home_y = site.home_x - x, site.home_y - y
    to_x, to_y = food_x - x, food_y - y
    food_distance, food_bearing = length(to_x, to_y), turn_to(bearing_of(to_x, to_y), orientation)
    return RawData(
        (a, b, c, d, e, f),
        senses.arm,
        senses.jaw,
        senses.object_presence,
        x,
        y,
        orientation,
        tracked,
        food_seen,
        food_x,
        food_y,
        food_type if senses.object_presence else FoodType.UNKNOWN,
        site.home_x,
        site.home_y,
        site.home_radius,
        site.home_opening,
        math.sqrt(wall_x * wall_x + wall_y * wall_y),
        turn_to(bearing_of(wall_x, wall_y), orientation),
        length(home_x, home_y),
        turn_to(bearing_of(home_x, home_y), orientation),
        food_distance if food_seen else 0.0,
        food_bearing if food_seen else 0.0,
    )


def state_vector(raw: RawData, diagonal: int) -> StateVector:
    """The five attributes of section 4.3, distances rounded to whole pixels.

    Args:
        raw: What is perceived now.
        diagonal: Of the arena in pixels: the food distance where there is no candidate.
    """
    food = raw.food_distance if raw.food_seen else diagonal
    return StateVector(
        1 if raw.object_presence else 0,
        int(raw.home_distance + 0.5),
        raw.food_type,
        raw.arm,
        int(food + 0.5),
    )
