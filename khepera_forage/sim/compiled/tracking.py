"""Tracks of food: the rule of `vision.association` in every world of a block."""

from typing import Any

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.sim.compiled.camera import plate_of
from khepera_forage.vision import association
from khepera_forage.vision.association import match, may_vanish, start_tracks
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import (
    FOOD_RADIUS_PX,
    shows_beside_lost_food,
    touches_plate,
    visible_clearance,
)

for _rule in (
    *(
        match,
        may_vanish,
        start_tracks,
        association.association_cost,
        shows_beside_lost_food,
        visible_clearance,
    ),
    *(association._match_obvious, association._match_by_cost, association._is_shown),
    *(association._reads_before, association._slot_for_new_track),
):
    inline(_rule)


@kernel
def track(robot: Any, foods: Any, tracks: Any, detections: Any, constants: Any) -> None:
    """Associate the frame just taken with the tracks of every world of a block."""
    clearance = visible_clearance(constants[0].position_jitter)
    for i in range(robot.x.shape[0]):
        slots = tracks[i]
        count = _detect(foods, i, detections)
        new = match(slots, detections, count, False)
        for k in range(slots.shape[0]):
            if may_vanish(slots[k], False) and _is_visible(robot, foods, i, slots[k], clearance):
                slots[k].label = -1
        if new:
            robot.next_label[i] = start_tracks(slots, detections, count, robot.next_label[i])


@inline
def _detect(foods: Any, i: int, detections: Any) -> int:
    """Write what the frame shows of the food; returns the number of detections."""
    count = 0
    for k in range(foods.shape[0]):
        if foods[k].seen[i] != 0.0:
            detection = detections[count]
            detection.x = detection.first_x = foods[k].seen_x[i]
            detection.y = foods[k].seen_y[i]
            detection.first_y = detection.y + FOOD_RADIUS_PX
            detection.holes = 0
            count += 1
    return count


@inline
def _is_visible(robot: Any, foods: Any, i: int, track: Any, clearance: float) -> bool:
    """Whether food at the last place of a track would have shown in this frame."""
    x, y = track.x * MM_PER_PIXEL, track.y * MM_PER_PIXEL
    visible = not touches_plate(x, y, clearance, plate_of(robot, i))
    for k in range(foods.shape[0]):
        if foods[k].lost[i] != 0.0 and not shows_beside_lost_food(x, y, foods[k].x[i], foods[k].y[i]):
            visible = False
    return visible
