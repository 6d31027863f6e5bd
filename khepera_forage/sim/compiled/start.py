"""The start of an episode: robots are put down."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance, inline
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.counter_rng import random_bits
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN
from khepera_forage.sim.compiled.bodies import Bodies, bodies_of
from khepera_forage.sim.compiled.numbers import DRAW_BIAS, DRAWS, normal
from khepera_forage.sim.compiled.parameters import Parameters

_32, _DRAWS = np.uint64(32), np.uint64(DRAWS)
_BIAS_DITHER, _BIAS_RIGHT, _BIAS_LEFT = (np.uint64(DRAW_BIAS + n) for n in range(3))


@inline
def stand(bodies: Bodies, i: int, x: float, y: float, heading: float, parameters: Parameters) -> None:
    """Put a robot down at the start of an episode, at rest, with its gripper raised and open, and forget its tracks.

    The food's places are set separately.

    Args:
        bodies: The records of one block.
        i: The lane.
        x: Place of the robot in mm.
        y: Place of the robot in mm.
        heading: Radians.
        parameters: What is the same in all worlds.
    """
    robot, constants = bodies.robots, parameters.constants
    key, first = robot.key[i], robot.round[i] * _DRAWS
    dither = random_bits(key, first + _BIAS_DITHER)
    mean, bias = constants[0].wheel_speed - 1.0, constants[0].wheel_bias
    robot.bias_left[i] = mean + bias * normal(random_bits(key, first + _BIAS_LEFT), dither)
    robot.bias_right[i] = mean + bias * normal(random_bits(key, first + _BIAS_RIGHT), dither >> _32)
    robot.x[i], robot.y[i], robot.heading[i] = x, y, heading
    robot.cos[i], robot.sin[i] = cosine_sine(heading)
    robot.arm[i] = robot.arm_target[i] = ARM_RAISED
    robot.jaw[i] = robot.jaw_target[i] = JAW_OPEN
    robot.held[i] = -1.0
    robot.left[i] = robot.right[i] = robot.last_forward[i] = robot.last_turn[i] = 0.0
    robot.pulses_left[i] = robot.pulses_right[i] = 0.0
    robot.object_presence[i] = robot.arm_reading[i] = robot.jaw_reading[i] = 0.0
    robot.marker_x[i] = robot.marker_y[i] = robot.marker_heading[i] = 0.0
    robot.marker_found[i] = robot.marker_lost[i] = 0.0
    robot.first_frame[i] = 1.0
    robot.next_label[i] = 0
    for k in range(bodies.foods.shape[0]):
        food = bodies.foods[k]
        food.lost[i] = food.seen[i] = food.seen_x[i] = food.seen_y[i] = 0.0
    for k in range(bodies.tracks.shape[1]):
        track = bodies.tracks[i, k]
        track.label = track.detection = -1
        track.x = track.y = 0.0
        track.holes = 0
        track.found = False


@entrance
def stand_in_blocks(bodies: Bodies, parameters: Parameters, poses: NDArray[np.float64]) -> None:
    """Put down the robots of all blocks, one row of x, y and heading a lane; see `stand`."""
    lanes = bodies.tracks.shape[1]
    for n in range(poses.shape[0]):
        one = bodies_of(bodies, n // lanes, 0)
        stand(one, n % lanes, poses[n, 0], poses[n, 1], poses[n, 2], parameters)
