"""The overhead camera: what each frame shows (see `vision.simulated_camera`), and the tracks of food.

Each robot has the only marker of its kind, so its track never ends. Food becomes tracks by the rule of
`vision.association`.
"""

import math
from typing import Any

import numpy as np

from khepera_forage.compilation import rule
from khepera_forage.counter_rng import random_bits
from khepera_forage.robots.khepera import FOOD_RADIUS
from khepera_forage.sim.compiled.random import (
    DRAW_FOOD,
    DRAW_MARKER,
    FOOD_DRAWS,
    draw,
    halves,
    lower,
    normal,
    upper,
)
from khepera_forage.vision import association
from khepera_forage.vision.association import match, may_vanish, start_tracks
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import (
    FOOD_RADIUS_PX,
    PICTURE_HEIGHT,
    PICTURE_WIDTH,
    Plate,
    shows_beside_lost_food,
    touches_plate,
    visible_clearance,
)

_DITHER = np.uint64(DRAW_MARKER + 2)

for _rule in (
    *(touches_plate, shows_beside_lost_food, visible_clearance),
    *(match, may_vanish, start_tracks, association.association_cost),
    *(association._match_obvious, association._match_by_cost, association._is_shown),
    *(association._reads_before, association._slot_for_new_track),
):
    rule(_rule)


@rule
def look(
    robots: Any,
    foods: Any,
    tracks: Any,
    detections: Any,
    anchor_x: float,
    anchor_y: float,
    constants: Any,
) -> None:
    """Take one frame, in which the first time after a reset nothing is lost, and continue the tracks.

    Args:
        robots: All robots of the world.
        foods: The food objects.
        tracks: Slots of `Track` records, twice as many as food objects.
        detections: Room for one `FoodDetection` record a food object; it holds nothing between rounds.
        anchor_x: The point from which the robots' cables hang, mm.
        anchor_y: Likewise.
        constants: `Constants`.
    """
    first_frame = robots[0].first_frame
    for i in range(len(robots)):
        _look_at_marker(robots[i], constants)
    count = 0
    for k in range(len(foods)):
        if _look_at_food(robots, foods[k], k, detections[count], anchor_x, anchor_y, first_frame, constants):
            count += 1
    new = match(tracks, detections, count, False)
    clearance = visible_clearance(constants.position_jitter)
    for k in range(len(tracks)):
        if may_vanish(tracks[k], False) and _is_visible(robots, foods, tracks[k], clearance):
            tracks[k].label = -1
    if new:
        robots[0].next_label = start_tracks(tracks, detections, count, robots[0].next_label)


@rule
def forget_tracks(foods: Any, tracks: Any) -> None:
    """Begin with nothing tracked and nothing lost."""
    for k in range(len(foods)):
        foods[k].lost = False
    for k in range(len(tracks)):
        track = tracks[k]
        track.label = track.detection = -1
        track.x = track.y = 0.0
        track.holes = 0
        track.found = False


@rule
def _is_lost(lost: bool, chance: float, rate: float, end: float) -> bool:
    """Whether the tracker does not see a region in this frame: losses begin at a rate and end with a chance."""
    return chance >= end if lost else chance < rate


@rule
def _look_at_marker(robot: Any, constants: Any) -> None:
    """What this frame shows of a robot's marker."""
    jitter, chances = constants.position_jitter, draw(robot, DRAW_MARKER + 4)
    for_x, for_y = halves(draw(robot, DRAW_MARKER + 2))
    x = robot.x / MM_PER_PIXEL + jitter * normal(draw(robot, DRAW_MARKER), for_x)
    y = robot.y / MM_PER_PIXEL + jitter * normal(draw(robot, DRAW_MARKER + 1), for_y)
    # A robot's own cable never disturbs its marker (3.7).
    rate = constants.loss_rate_one_hole if robot.holes == 1 else constants.loss_rate_two_holes
    lost = _is_lost(robot.marker_lost, upper(chances), rate, constants.loss_end)
    robot.marker_lost = lost and not robot.first_frame
    robot.marker_found = not robot.marker_lost and 0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT
    robot.first_frame = False
    if not robot.marker_found:
        return
    turn = draw(robot, DRAW_MARKER + 3)
    degrees = robot.heading * (180.0 / math.pi)
    degrees += constants.heading_jitter * normal(turn, random_bits(turn, _DITHER))
    degrees = np.rint(degrees + (180.0 if lower(chances) < constants.reversal_rate else 0.0))
    robot.marker_x, robot.marker_y = x, y
    robot.marker_heading = degrees - 360.0 * math.floor(degrees / 360.0)


@rule
def _look_at_food(
    robots: Any,
    food: Any,
    k: int,
    detection: Any,
    anchor_x: float,
    anchor_y: float,
    first_frame: bool,
    constants: Any,
) -> bool:
    """What this frame shows of food object `k`; returns whether it is seen, and then writes the detection."""
    robot, jitter, number = robots[0], constants.position_jitter, DRAW_FOOD + k * FOOD_DRAWS
    chance, rate = upper(draw(robot, number + 3)), constants.loss_rate_food
    # A cable makes a loss likelier: so seldom that only then cables are looked at.
    if not food.lost and rate <= chance < rate * constants.cable_loss_factor:
        for i in range(len(robots)):
            if _is_under_cable(food, robots[i], anchor_x, anchor_y):
                rate = rate * constants.cable_loss_factor
                break
    food.lost = _is_lost(food.lost, chance, rate, constants.loss_end) and not first_frame
    if food.lost or _is_hidden(robots, food.x, food.y, FOOD_RADIUS):
        return False
    for_x, for_y = halves(draw(robot, number + 2))
    x = food.x / MM_PER_PIXEL + jitter * normal(draw(robot, number), for_x)
    y = food.y / MM_PER_PIXEL + jitter * normal(draw(robot, number + 1), for_y)
    detection.x = detection.first_x = x
    detection.y, detection.first_y = y, y + FOOD_RADIUS_PX
    detection.holes = 0
    return bool(0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT)


@rule
def _is_under_cable(food: Any, robot: Any, anchor_x: float, anchor_y: float) -> bool:
    """Whether a robot's cable, a straight line from the anchor to the middle of its marker, passes over food."""
    to_x, to_y = robot.x - anchor_x, robot.y - anchor_y
    dx, dy = food.x - anchor_x, food.y - anchor_y
    t = min(1.0, max(0.0, (dx * to_x + dy * to_y) / max(to_x * to_x + to_y * to_y, 1e-9)))
    dx, dy = dx - t * to_x, dy - t * to_y
    return bool(dx * dx + dy * dy <= FOOD_RADIUS * FOOD_RADIUS)


@rule
def _is_hidden(robots: Any, x: float, y: float, radius: float) -> bool:
    """Whether a disc on the floor touches the marker of any robot."""
    for i in range(len(robots)):
        robot = robots[i]
        if touches_plate(x, y, radius, Plate(robot.x, robot.y, robot.cos, robot.sin)):
            return True
    return False


@rule
def _is_visible(robots: Any, foods: Any, track: Any, clearance: float) -> bool:
    """Whether food at the last place of a track would have shown in this frame."""
    x, y = track.x * MM_PER_PIXEL, track.y * MM_PER_PIXEL
    for k in range(len(foods)):
        if foods[k].lost and not shows_beside_lost_food(x, y, foods[k].x, foods[k].y):
            return False
    return not _is_hidden(robots, x, y, clearance)
