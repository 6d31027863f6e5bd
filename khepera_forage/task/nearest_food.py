"""The nearest candidate food: which regions may be it, and whether lost food is seen (4.2.2, 4.3).

The functions take the records of `food_tracking`.
"""

import math
from typing import Any

from khepera_forage.robots.khepera import ARM_ON_FLOOR
from khepera_forage.task.arena_map import ArenaMap, is_within
from khepera_forage.task.decisions import (
    HIDES_ALL_FOOD,
    IN_GRIPPER,
    NO_CANDIDATE,
    SEEN_AT_LAST_PLACE,
    UNSEEN_UNTIL_ARM_DOWN,
    DecisionValues,
)
from khepera_forage.task.food_links import link_of
from khepera_forage.task.states import FoodType
from khepera_forage.task.way_finding import WayMemory, drivable, way_to_food

_POISONOUS = FoodType.POISONOUS.value
_NO_PATH = 1e6
"""Pixels that stand for the path to food that cannot be reached: any other food is nearer."""


def find_nearest(
    tracker: Any,
    foods: Any,
    memory: WayMemory,
    links: Any,
    tracks: Any,
    arena: ArenaMap,
    x: float,
    y: float,
    arm: int,
    decisions: DecisionValues,
) -> None:
    """Find the nearest candidate: a region without holes that shows neither delivered nor known poisonous food.

    Nearest is what has the shortest path: a robot that went round a wall for the food beyond it could otherwise find
    other food nearer on its way, and the first one again on its way there.

    Args:
        tracker: The `FoodTracker` record; changed in place.
        foods: Its `FoodObject` records.
        memory: What the robot remembers of its ways; changed in place.
        links: Its `Link` records.
        tracks: Regions or tracks of the camera.
        arena: The arena of this robot.
        x: Of the robot, pixels.
        y: Of the robot, pixels.
        arm: Position of its arm.
        decisions: `DecisionValues`.
    """
    seen, nearest, food_x, food_y = False, -1, 0.0, 0.0
    way_x = way_y = path = 0.0
    held, excluded, looks = tracker.held, -1, True
    if held >= 0:
        held_food = decisions.held_food
        looks = held_food != HIDES_ALL_FOOD and held_food != IN_GRIPPER
        if held_food == IN_GRIPPER:
            seen, food_x, food_y = True, foods[held].x, foods[held].y
            way_x, way_y = food_x, food_y
        if held_food == NO_CANDIDATE:
            excluded = held
    best, at_last_place = math.inf, decisions.food_beside_robot == SEEN_AT_LAST_PLACE
    for track in tracks:
        if track.holes != 0 or track.label < 0 or not looks:
            continue
        dx, dy = track.x - x, track.y - y
        squared = dx * dx + dy * dy
        if squared < best and is_within(track.x, track.y, arena):
            k, number = link_of(track.label, links), -1
            to_x, to_y, length = track.x, track.y, 0.0
            if k >= 0:
                number = links[k].food
                if number == excluded or not is_candidate(foods[number], number == held):
                    continue
                if len(arena.ways.corners) > 0:
                    to_x, to_y, length = way_to_food(
                        x, y, track.x, track.y, foods[number], number, memory, arena
                    )
                    squared = min(length, _NO_PATH) ** 2
                    if squared >= best:
                        continue
            if track.found or at_last_place or _is_still_seen(links, k, arm, decisions):
                best, way_x, way_y, path = squared, to_x, to_y, length
                seen, nearest, food_x, food_y = True, number, track.x, track.y
    if path > 0.0:
        way_x, way_y, path = drivable((way_x, way_y, path), food_x, food_y)
    tracker.food_seen, tracker.nearest, tracker.food_x, tracker.food_y = seen, nearest, food_x, food_y
    tracker.food_way_x, tracker.food_way_y, tracker.food_path = way_x, way_y, path


def is_candidate(food: Any, held: bool) -> bool:
    """Whether food may be the nearest food: not delivered, and not known to be poisonous unless it is held."""
    return not food.delivered and (food.known != _POISONOUS or held)


def _is_still_seen(links: Any, k: int, arm: int, decisions: DecisionValues) -> bool:
    """Whether lost food that becomes unseen is still seen at its last place (4.2.2); `k` is its link, -1 without."""
    if decisions.food_beside_robot == UNSEEN_UNTIL_ARM_DOWN and arm >= ARM_ON_FLOOR:
        return True
    return k < 0 or links[k].lost_rounds * decisions.round_duration <= decisions.redetection_time
