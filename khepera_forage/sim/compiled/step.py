"""One round of all bodies of a world: `advance`."""

from typing import Any

import numpy as np

from khepera_forage.compilation import rule
from khepera_forage.sim.compiled.camera import look
from khepera_forage.sim.compiled.moving import move
from khepera_forage.sim.compiled.sensing import sense

_ONE = np.uint64(1)


@rule
def advance(
    robots: Any,
    foods: Any,
    tracks: Any,
    detections: Any,
    walls: Any,
    corners: Any,
    anchor_x: float,
    anchor_y: float,
    constants: Any,
) -> None:
    """Move everything, sense, and take a frame; motor commands are given.

    Args:
        robots: `RobotState` records, one or more robots in one arena.
        foods: `FoodState` records.
        tracks: `Track` records, twice as many as food objects.
        detections: As many `FoodDetection` records as food objects; they hold nothing between rounds.
        walls: `Wall` records in mm.
        corners: The corners that point into the floor, mm.
        anchor_x: The point from which the robots' cables hang, mm.
        anchor_y: Likewise.
        constants: The `Constants` record.
    """
    for i in range(len(robots)):
        robots[i].round += _ONE
        move(robots, i, foods, walls, corners, constants)
    for i in range(len(robots)):
        sense(robots, i, foods, walls, constants)
    look(robots, foods, tracks, detections, anchor_x, anchor_y, constants)
