"""The records that hold compiled worlds: numpy structured types with one lane for each world of a block.

Kernels work on blocks of worlds. A quantity of a robot or of food is a field with one number a lane, `robot.x[i]`, so
that one instruction works on several worlds. The number of lanes is part of the type: loops have a fixed length, and
the same kernels run blocks of one lane. Units are millimetres, radians and seconds unless a comment says otherwise;
flags that kernels use as numbers are 0.0 or 1.0.
"""

from typing import Any

import numpy as np

from khepera_forage.geometry.walls import Wall

LANES = 128
"""Worlds in a block of many. Only functions that allocate blocks use this number."""

_ROBOT = (
    *("x", "y", "heading", "cos", "sin"),
    *("arm", "jaw"),  # positions on the scales of `robots.khepera`
    "held",  # number of the food object between the closed fingers, -1 without
    *("grip_x", "grip_y"),  # the place of held food in the robot's frame
    *("bias_left", "bias_right"),  # lasting error of each wheel, as a share of its travel
    *("pulses_left", "pulses_right"),
    # Motor commands as applied.
    *("left", "right", "arm_target", "jaw_target"),
    # Senses: whole numbers. The eight readings `proximity` are a field of their own.
    *("object_presence", "arm_reading", "jaw_reading"),
    # The robot's own region in the camera's scene: pixels and whole degrees.
    *("marker_x", "marker_y", "marker_heading"),
    "marker_found",  # whether this frame shows the marker
    "marker_lost",  # whether the tracker does not see the marker at present
    "first_frame",  # whether the coming frame is the first after a reset
    *("last_forward", "last_turn"),  # speeds at the end of the last round, mm/s and rad/s
)
_FOOD = (
    *("x", "y"),
    "lost",  # whether the tracker does not see the object at present
    *("seen", "seen_x", "seen_y"),  # whether this frame shows the object, and where, in pixels
)
_WALL = tuple(name for name in Wall._fields if name not in ("y2", "polygon"))
_SCRATCH = (
    # The motion of this round.
    *("forward", "turn"),  # commanded speeds, mm/s and rad/s
    "travel",  # distance that any part of the robot can move, mm
    *("free_x", "free_y", "free_heading", "free_cos", "free_sin", "free_jaw"),  # the end if nothing resists
    "lag",  # share of the round in which the robot still moves as in the last one
    *("near_wall", "near_food"),  # whether the robot could touch a wall, or food
    "touches",  # whether the robot touches something
    # Lanes near a wall or corner, packed (broad_phase).
    *("near_x", "near_y", "near_cos", "near_sin", "near_jaw"),
    *("near_from_x", "near_from_y", "near_held", "near_grip_x", "near_grip_y", "near_travel", "near_touches"),
    # A wall and a corner of each packed lane, if worlds are in different arenas (listed_walls).
    *(f"wall_{name}" for name in _WALL),
    *("corner_x", "corner_y"),
    # Lanes with an obstacle in range of the infra-reds, packed (sensing).
    *("ahead", "aside", "along", "across", "reading"),
    *("in_range", "in_range_arm_down"),
    "marked",  # marks of lanes within one kernel
)

constants_dtype = np.dtype(
    [
        (name, "f8")
        for name in (
            # Sizes and rates of `Noise`; `loss_end` is the chance that a loss ends.
            *("wheel_slip", "wheel_bias", "proximity_gain", "proximity_floor"),
            *("position_jitter", "heading_jitter", "reversal_rate"),
            *("loss_rate_marker", "loss_rate_food", "loss_end", "cable_loss_factor"),
            *("anchor_x", "anchor_y"),  # the point from which the cable hangs
            "wheel_speed",  # share of the commanded speed that wheels reach
            "round_duration",  # seconds
            *("arm_speed", "jaw_speed"),  # positions a second
        )
    ]
)
"""Numbers that are the same in all worlds."""

wall_dtype = np.dtype([(name, "f8") for name in _WALL])
"""`geometry.walls.Wall` in mm, without `y2` and `polygon`."""

corner_dtype = np.dtype([("x", "f8"), ("y", "f8")])
"""A corner of walls that points into the floor."""

arena_dtype = np.dtype(
    [
        *((name, "i8") for name in ("first_wall", "walls", "first_corner", "corners")),
        *((name, "f8") for name in ("anchor_x", "anchor_y")),
    ]
)
"""One of several arenas: which of all walls and corners are its own, and the point from which the cable hangs."""

track_dtype = np.dtype(
    [
        ("label", "i4"),
        ("x", "f8"),
        ("y", "f8"),
        ("holes", "i1"),
        ("found", "?"),
        ("detection", "i2"),
    ],
    align=True,
)
"""The fields of `vision.association.Track`: one track of one world."""

detection_dtype = np.dtype([("x", "f8"), ("y", "f8"), ("holes", "i8"), ("first_x", "f8"), ("first_y", "f8")])
"""The fields of `vision.association.Detection` that association needs."""


def robot_dtype(lanes: int) -> np.dtype[Any]:
    """One block of robots, with the cameras' numbers of each world and its random numbers."""
    return np.dtype(
        [
            *_over(lanes, _ROBOT),
            ("proximity", "f8", (8, lanes)),
            ("next_label", "i8", (lanes,)),  # label of the next new track
            ("key", "u8", (lanes,)),  # of the world's random numbers
            ("round", "u8", (lanes,)),  # rounds since the key was set
        ]
    )


def food_dtype(lanes: int) -> np.dtype[Any]:
    """One food object in each world of a block."""
    return np.dtype(_over(lanes, _FOOD))


def lists_dtype(lanes: int) -> np.dtype[Any]:
    """In which of several arenas each world of a block is, and what its lists of near walls are made for."""
    return np.dtype(
        [
            *((name, "i8", (lanes,)) for name in ("arena", "listed_arena", "walls", "corners")),
            # Where the robot was, and how far it may move from there, mm.
            *_over(lanes, ("x", "y", "range")),
            *_over(lanes, ("anchor_x", "anchor_y")),  # the point from which the cable hangs
        ]
    )


def near_wall_dtype(lanes: int) -> np.dtype[Any]:
    """One entry in the list of near walls of each world of a block: the fields of `wall_dtype`."""
    return np.dtype(_over(lanes, wall_dtype.names or ()))


def near_corner_dtype(lanes: int) -> np.dtype[Any]:
    """One entry in the list of near corners of each world of a block: the fields of `corner_dtype`."""
    return np.dtype(_over(lanes, corner_dtype.names or ()))


def scratch_dtype(lanes: int) -> np.dtype[Any]:
    """Numbers that are needed within a round only: one record serves all blocks of a thread."""
    return np.dtype([*_over(lanes, _SCRATCH), ("lane", "u2", (lanes,))])  # lane: numbers of packed lanes


def _over(lanes: int, names: tuple[str, ...]) -> list[Any]:
    return [(name, "f8", (lanes,)) for name in names]
