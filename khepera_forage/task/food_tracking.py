"""The food tracker: which food object each track shows, what is delivered, and which food is nearest (4.2.2, 4.2.3).

The camera knows regions, not objects. A region that was carried away is dropped, and what is set down elsewhere is a
new one. The food tracker links the tracks to the food objects of an arena, through the gripper.

The functions take *records*: objects with the fields of `FoodTracker`, `FoodObject`, `Link`, and `vision.scene.Region`.
In Python these are slotted dataclasses and named tuples, in compiled code records of numpy arrays. Arguments in common:
`known` food, which is changed in place; `tracks` or regions of the camera, of any number of holes, where slots with
label -1 are free; the robot's `own` marker and its `senses`; its `arena`.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from khepera_forage.geometry.paths import next_waypoint
from khepera_forage.geometry.plane import heading_of, length
from khepera_forage.robots.khepera import ARM_DOWN, ARM_ON_FLOOR, BARRIER, JAW_OPEN, Senses
from khepera_forage.task.arena_map import ArenaMap, drivable, is_within
from khepera_forage.task.decisions import (
    HIDES_ALL_FOOD,
    IN_GRIPPER,
    LAST_DISTANCE,
    NO_CANDIDATE,
    SEEN_AT_LAST_PLACE,
    UNSEEN_UNTIL_ARM_DOWN,
    DecisionValues,
)
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL


@dataclass(slots=True)
class Link:
    """Which food object a track shows.

    Attributes:
        label: Of the track; -1 in a free slot.
        food: Number of the food object.
        lost_rounds: For how many rounds the track has been lost; counted if lost food becomes unseen.
    """

    label: int = -1
    food: int = -1
    lost_rounds: int = 0


def link_of(label: int, links: Any) -> int:
    """Number of the link of a track; -1 if it is not linked."""
    for k in range(len(links)):
        if links[k].label == label:
            return k
    return -1


def link_track(track: Any, foods: Any, held: int, links: Any, tracks: Any, arena: ArenaMap) -> int:
    """Link a new track to the nearest food object that no other track shows, or that was carried since.

    Food in the gripper is hidden under the robot's marker: what turns up beside it is other food.
    """
    for link in links:
        if link.label >= 0 and not _is_watched(link.label, tracks, arena):
            link.label = -1
    nearest, best = -1, math.inf
    for k in range(len(foods)):
        food = foods[k]
        free = True
        for link in links:
            if link.label >= 0 and link.food == k:
                free = False
        dx, dy = food.x - track.x, food.y - track.y
        squared = dx * dx + dy * dy
        if k != held and (free or food.carried) and squared < best:
            nearest, best = k, squared
    if nearest >= 0:
        for link in links:
            if link.label < 0:
                link.label, link.food, link.lost_rounds = track.label, nearest, 0
                break
    return nearest


def is_shown(number: int, links: Any, tracks: Any) -> bool:
    """Whether the camera sees a food object in this frame, by its number."""
    for track in tracks:
        if track.found and track.label >= 0 and track.holes == 0:
            k = link_of(track.label, links)
            if k >= 0 and links[k].food == number:
                return True
    return False


def count_lost_rounds(links: Any, tracks: Any) -> None:
    """Count for how many rounds each linked track has been lost."""
    for track in tracks:
        k = link_of(track.label, links) if track.label >= 0 else -1
        if k >= 0:
            links[k].lost_rounds = 0 if track.found else links[k].lost_rounds + 1


def _is_watched(label: int, tracks: Any, arena: ArenaMap) -> bool:
    """Whether there still is a track with this label in the arena."""
    for track in tracks:
        if track.label == label:
            return is_within(track.x, track.y, arena)
    return False


_GRIPPER = (BARRIER + 5.0) / MM_PER_PIXEL
"""Pixels from a robot's centre to food in its gripper."""
_SEEN = 1e8
"""Squared pixels by which food that the camera sees counts as further from the gripper."""
_UNKNOWN, _POISONOUS = FoodType.UNKNOWN.value, FoodType.POISONOUS.value


@dataclass(slots=True)
class FoodObject:
    """One food object of an arena.

    Attributes:
        x: Last known place in pixels.
        y: Last known place in pixels.
        type: A `FoodType`, drawn at the start of the episode.
        known: The type as far as it is identified, otherwise UNKNOWN.
        delivered: Whether it has been brought home.
        carried: Whether it has been in the gripper since it was last seen: it may turn up as another track.
        may_be_poisonous: Whether there can be poison in this episode.
        side: Where a robot that takes other food home passes it, see `past_poison`; 0 while it is not in the way.
    """

    x: float
    y: float
    type: int = 0
    known: int = 0
    delivered: bool = False
    carried: bool = False
    may_be_poisonous: bool = False
    side: int = 0


@dataclass(slots=True)
class FoodTracker:
    """What becomes of the food of one arena, and of the one robot that forages there.

    Attributes:
        held: Number of the food object in the gripper; -1 without one.
        type_in_gripper: Its type as far as it is identified; UNKNOWN without one.
        delivered: Food objects brought home that are not poisonous.
        poison_home: Poisonous food objects brought home.
        deliverable: Food objects that are not known to be poisonous.
        food_seen: Whether there is a candidate food.
        food_x: Its place in pixels; 0 without one.
        food_y: Its place in pixels; 0 without one.
        food_waypoint_x: Of the next waypoint on the way to it, pixels: the food itself where the way is clear.
        food_waypoint_y: Likewise.
        food_path: Length of the path, pixels; 0 if the way is straight.
        last_distance: From the robot to the nearest candidate when there last was one, pixels; -1 before. Kept if
            RobotFoodDistance is then the last one known.
    """

    held: int = -1
    type_in_gripper: int = 0
    delivered: int = 0
    poison_home: int = 0
    deliverable: int = 0
    food_seen: bool = False
    food_x: float = 0.0
    food_y: float = 0.0
    food_waypoint_x: float = 0.0
    food_waypoint_y: float = 0.0
    food_path: float = 0.0
    last_distance: float = -1.0


class KnownFood(NamedTuple):
    """What is known of the food of one arena.

    Attributes:
        tracker: The `FoodTracker` record.
        objects: `FoodObject` records.
        links: `Link` records: twice as many slots as food objects.
        chosen: `ChosenWaypoint` records: on the way home, then on the way to each food object.
    """

    tracker: Any
    objects: Any
    links: Any
    chosen: Any


def update_food(
    known: KnownFood, tracks: Any, own: Any, senses: Senses, explored: bool, arena: ArenaMap, decisions: DecisionValues
) -> None:
    """Account for one round: gripped, identified and delivered food, and the nearest candidate.

    Food in the gripper is identified if it has been `explored` in this round (see `can_explore`).
    """
    tracker, foods = known.tracker, known.objects
    if senses.object_presence:
        cosine, sine = heading_of(own.orientation)
        _follow_gripper(known, tracks, own.x + _GRIPPER * cosine, own.y + _GRIPPER * sine, explored)
    else:
        tracker.held = -1
    _follow_tracks(known, tracks, arena)
    if decisions.food_beside_robot != SEEN_AT_LAST_PLACE:
        count_lost_rounds(known.links, tracks)
    find_nearest(known, tracks, own.x, own.y, senses.arm, arena, decisions)
    _count(tracker, foods)
    if decisions.no_food_distance == LAST_DISTANCE:
        if tracker.food_seen:
            tracker.last_distance = length(tracker.food_x - own.x, tracker.food_y - own.y)
        elif tracker.deliverable < len(foods):
            tracker.last_distance = -1.0  # or a robot would orient with poison that it has just left


def share_identified(foods: Any, others: Any) -> None:
    """Make known what has been identified in a corresponding arena: corresponding food is of one type (4.5)."""
    for k in range(len(foods)):
        if foods[k].known != _UNKNOWN:
            others[k].known = foods[k].known


def is_finished(tracker: Any) -> bool:
    """Whether every food object is delivered or known to be poisonous."""
    finished: bool = tracker.delivered == tracker.deliverable
    return finished


def is_collected(food: Any) -> bool:
    """Whether food has been brought home and is not poisonous."""
    return bool(food.delivered and food.known != _POISONOUS)


def _follow_gripper(known: KnownFood, tracks: Any, x: float, y: float, explored: bool) -> None:
    """Food in the gripper is where the gripper is, and has been identified once it is explored."""
    tracker, foods = known.tracker, known.objects
    if tracker.held < 0:
        nearest, best = 0, math.inf
        for k in range(len(foods)):
            foods[k].side = 0
            dx, dy = foods[k].x - x, foods[k].y - y
            # The marker hides what is gripped: food that the camera sees is something else, also if it is nearer to
            # where a gripper would be in a frame with the heading reversed.
            squared = dx * dx + dy * dy + (_SEEN if is_shown(k, known.links, tracks) else 0.0)
            if squared < best:
                nearest, best = k, squared
        tracker.held = nearest
    held = foods[tracker.held]
    held.x, held.y, held.carried = x, y, True
    if explored and held.known == _UNKNOWN:
        held.known = held.type


def _follow_tracks(known: KnownFood, tracks: Any, arena: ArenaMap) -> None:
    """Link new tracks to food objects, and see where these are."""
    foods, links, held = known.objects, known.links, known.tracker.held
    for track in tracks:
        if track.found and track.label >= 0 and track.holes == 0 and is_within(track.x, track.y, arena):
            k = link_of(track.label, links)
            number = links[k].food if k >= 0 else link_track(track, foods, held, links, tracks, arena)
            if number >= 0 and number != held:
                _see(foods[number], track, arena)


def _see(food: Any, track: Any, arena: ArenaMap) -> None:
    """Food is where its track is; it is delivered, and its type known, once that is at home."""
    food.x, food.y, food.carried = track.x, track.y, False
    if not food.delivered and at_home(food.x, food.y, arena):
        food.delivered = True
        food.known = food.type


def _count(tracker: Any, foods: Any) -> None:
    """Count delivered, poisonous and deliverable food."""
    delivered, poison_home, deliverable = 0, 0, 0
    for food in foods:
        if food.known == _POISONOUS:
            poison_home += 1 if food.delivered else 0
        else:
            deliverable += 1
            delivered += 1 if food.delivered else 0
    tracker.delivered, tracker.poison_home, tracker.deliverable = delivered, poison_home, deliverable
    tracker.type_in_gripper = foods[tracker.held].known if tracker.held >= 0 else _UNKNOWN


_NO_PATH = 1e6
"""Pixels that stand for the path to food that cannot be reached: any other food is nearer."""


def find_nearest(
    known: KnownFood, tracks: Any, x: float, y: float, arm: int, arena: ArenaMap, decisions: DecisionValues
) -> None:
    """Find the nearest candidate: a region without holes that shows neither delivered nor known poisonous food.

    Nearest is what has the shortest path: a robot that went round a wall for the food beyond it could otherwise find
    other food nearer on its way, and the first one again on its way there. The robot is at (x, y), in pixels.
    """
    tracker, foods, links = known.tracker, known.objects, known.links
    seen, food_x, food_y = False, 0.0, 0.0
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
            k = link_of(track.label, links)
            to_x, to_y, far = track.x, track.y, 0.0
            if k >= 0:
                number = links[k].food
                if number == excluded or not is_candidate(foods[number], number == held):
                    continue
                if len(arena.paths.corners) > 0:
                    to_x, to_y, far = next_waypoint(
                        x, y, track.x, track.y, True, known.chosen[1 + number], arena.walls, arena.paths
                    )
                    squared = min(far, _NO_PATH) ** 2
                    if squared >= best:
                        continue
            if track.found or at_last_place or _is_still_seen(links, k, arm, decisions):
                best, way_x, way_y, path = squared, to_x, to_y, far
                seen, food_x, food_y = True, track.x, track.y
    if path > 0.0:
        way_x, way_y, path = drivable((way_x, way_y, path), food_x, food_y)
    tracker.food_seen, tracker.food_x, tracker.food_y = seen, food_x, food_y
    tracker.food_waypoint_x, tracker.food_waypoint_y, tracker.food_path = way_x, way_y, path


def is_candidate(food: Any, held: bool) -> bool:
    """Whether food may be the nearest food: not delivered, and not known to be poisonous unless it is held."""
    return not food.delivered and (food.known != _POISONOUS or held)


def _is_still_seen(links: Any, k: int, arm: int, decisions: DecisionValues) -> bool:
    """Whether lost food that becomes unseen is still seen at its last place (4.2.2); `k` is its link, -1 without."""
    if decisions.food_beside_robot == UNSEEN_UNTIL_ARM_DOWN and arm >= ARM_ON_FLOOR:
        return True
    return k < 0 or links[k].lost_rounds * decisions.round_duration <= decisions.redetection_time


_DOWN = ARM_DOWN - 3
_OPEN = JAW_OPEN - 5


def can_explore(senses: Senses) -> bool:
    """Whether food is in the barrier, arm down and jaw open: a whole round of this explores it, if the wheels rest."""
    return senses.object_presence != 0 and senses.arm >= _DOWN and senses.jaw >= _OPEN


def drawn_type(draw: float, odds: Any) -> int:
    """The type of food that a uniform draw stands for (3.7, 4.2.3).

    Args:
        draw: Uniform in [0, 1).
        odds: Of each `FoodType` but UNKNOWN, in their order; adding up to 1.
    """
    left = draw
    for k in range(len(odds)):
        left -= odds[k]
        if left < 0.0:
            return k + 1
    return len(odds)


def at_home(x: float, y: float, arena: ArenaMap) -> bool:
    """Whether a food object's centre, in pixels, is inside the home."""
    dx, dy = x - arena.home_x, y - arena.home_y
    return dx * dx + dy * dy <= arena.home_radius * arena.home_radius
