"""Which food object each track of the camera shows (4.2.2). The functions take the records of `food_tracking`."""

import math
from dataclasses import dataclass
from typing import Any

from khepera_forage.task.arena_map import ArenaMap, is_within


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
