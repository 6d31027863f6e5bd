"""The start of a round: the arm moves, the wheels' slip is drawn, and the free end of the round is predicted.

The free end of a round is where the robot gets if nothing resists. `move_freely` takes it in all worlds in which the
robot touches nothing; `contact` moves the others step by step.
"""

import math
from typing import Any

import numpy as np

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.counter_rng import random_bits
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FINGER_TIP, PULSE, SPEED_UNIT, WHEEL_BASE
from khepera_forage.sim.compiled.gripper import room_below
from khepera_forage.sim.compiled.numbers import DRAW_WHEELS, DRAWS, normal
from khepera_forage.sim.pymunk.khepera import FINE_TRAVEL, SUBSTEPS

_32, _DRAWS = np.uint64(32), np.uint64(DRAWS)
_LEFT, _RIGHT, _DITHER = (np.uint64(DRAW_WHEELS + n) for n in range(3))


@inline
def towards(target: float, value: float, step: float) -> float:
    """A value moved by at most `step` towards a target."""
    return min(target, value + step) if target > value else max(target, value - step)


@kernel
def begin_round(robot: Any, foods: Any, scratch: Any, constants: Any) -> None:
    """Move the arms, and draw the wheels' slip of this round."""
    duration, slip = constants[0].round_duration, constants[0].wheel_slip
    arm_step, jaw_step = constants[0].arm_speed * duration, constants[0].jaw_speed * duration
    lanes = robot.x.shape[0]
    for i in range(lanes):
        arm = robot.arm[i]
        moved = towards(robot.arm_target[i], arm, arm_step)
        scratch.marked[i] = 1.0 if moved >= ARM_ON_FLOOR and arm < ARM_ON_FLOOR else 0.0
        robot.arm[i] = moved
    for n in range(pack(scratch.marked, scratch.lane, 0)):
        i = scratch.lane[n]
        if not room_below(robot, foods, i):
            robot.arm[i] = ARM_ON_FLOOR - 1.0
    for i in range(lanes):
        key, first = robot.key[i], robot.round[i] * _DRAWS
        dither = random_bits(key, first + _DITHER)
        left_normal = normal(random_bits(key, first + _LEFT), dither)
        right_normal = normal(random_bits(key, first + _RIGHT), dither >> _32)
        left = robot.left[i] * SPEED_UNIT * (1.0 + robot.bias_left[i] + slip * left_normal)
        right = robot.right[i] * SPEED_UNIT * (1.0 + robot.bias_right[i] + slip * right_normal)
        forward, turn = (left + right) / 2, (right - left) / WHEEL_BASE
        # A jaw that holds food closes no further. One that opens and releases food is moved step by step.
        held = robot.held[i] >= 0.0
        jaw, target = robot.jaw[i], robot.jaw_target[i]
        scratch.free_jaw[i] = jaw if held else towards(target, jaw, jaw_step)
        scratch.travel[i] = (abs(forward) + abs(turn) * FINGER_TIP) * duration
        scratch.touches[i] = 1.0 if held and target > jaw else 0.0
        scratch.forward[i] = forward
        scratch.turn[i] = turn
        scratch.near_wall[i] = 0.0
        scratch.near_food[i] = 0.0


@kernel
def predict(robot: Any, scratch: Any, constants: Any) -> None:
    """Compute the free end of the round.

    Chipmunk moves bodies by the speed of the step before. So where `PymunkWorld` needs physics, near walls and food, a
    robot changes its speed one physics step late: 20 ms, or less near a wall, where steps are finer.
    """
    duration = constants[0].round_duration
    for i in range(robot.x.shape[0]):
        travel = scratch.travel[i]
        still = travel == 0.0 and scratch.free_jaw[i] == robot.jaw[i]
        wall, food = scratch.near_wall[i] != 0.0, scratch.near_food[i] != 0.0
        steps = max(float(SUBSTEPS), math.ceil(travel / FINE_TRAVEL)) if wall else float(SUBSTEPS)
        lag = 1.0 / steps if (wall or food) and not still else 0.0
        scratch.lag[i] = lag
        forward = scratch.forward[i] + lag * (robot.last_forward[i] - scratch.forward[i])
        turn = scratch.turn[i] + lag * (robot.last_turn[i] - scratch.turn[i])
        heading = robot.heading[i]
        # The chord of an arc has the direction of the arc's middle.
        cos, sin = cosine_sine(heading + turn * duration / 2)
        end = heading + turn * duration
        end_cos, end_sin = cosine_sine(end)
        scratch.free_x[i] = robot.x[i] + forward * cos * duration
        scratch.free_y[i] = robot.y[i] + forward * sin * duration
        scratch.free_heading[i] = end
        scratch.free_cos[i] = end_cos
        scratch.free_sin[i] = end_sin


@kernel
def move_freely(robot: Any, scratch: Any, constants: Any) -> None:
    """Move the robots that touch nothing, or do not move, to the free end of the round."""
    pulses = SPEED_UNIT * constants[0].round_duration / PULSE
    for i in range(robot.x.shape[0]):
        still = (
            scratch.travel[i] == 0.0
            and robot.last_forward[i] == 0.0
            and robot.last_turn[i] == 0.0
            and scratch.free_jaw[i] == robot.jaw[i]
        )
        opens = robot.held[i] >= 0.0 and robot.jaw_target[i] > robot.jaw[i]
        touches = scratch.touches[i] != 0.0 and (opens or not still)
        scratch.touches[i] = 1.0 if touches else 0.0
        robot.pulses_left[i] += robot.left[i] * pulses
        robot.pulses_right[i] += robot.right[i] * pulses
        robot.x[i] = _either(touches, robot.x[i], scratch.free_x[i])
        robot.y[i] = _either(touches, robot.y[i], scratch.free_y[i])
        robot.heading[i] = _either(touches, robot.heading[i], scratch.free_heading[i])
        robot.cos[i] = _either(touches, robot.cos[i], scratch.free_cos[i])
        robot.sin[i] = _either(touches, robot.sin[i], scratch.free_sin[i])
        robot.jaw[i] = _either(touches, robot.jaw[i], scratch.free_jaw[i])
        robot.last_forward[i] = _either(touches, robot.last_forward[i], scratch.forward[i])
        robot.last_turn[i] = _either(touches, robot.last_turn[i], scratch.turn[i])


@inline
def _either(first: bool, one: float, other: float) -> float:
    """One number or the other; both are loaded before the choice, so that the loop vectorises."""
    return one if first else other
