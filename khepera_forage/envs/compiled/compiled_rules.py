"""The functions of `foraging`, made known to the compiler as they are.

Only plane geometry has a compiled version of its own: nothing else of the task is written twice.
"""

import math

from khepera_forage.compilation.decorators import inline, stand_in
from khepera_forage.compilation.trigonometry import cosine_sine, direction
from khepera_forage.geometry import angles
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    JAW_CLOSED,
    JAW_OPEN,
    MAX_SPEED,
    Motors,
    applicable,
)
from khepera_forage.task import (
    behaviours,
    identification,
    perception,
    scoring,
    states,
    steering,
)

_DEGREES, _RADIANS = 180.0 / math.pi, math.pi / 180.0


@stand_in(angles.bearing_of)
def bearing_of(x: float, y: float) -> float:
    """See `angles.bearing_of`."""
    return direction(x, y) * _DEGREES


@stand_in(angles.turn_to)
def turn_to(way: float, orientation: float) -> float:
    """See `angles.turn_to`."""
    turn = way - orientation + 180.0
    return turn - 360.0 * math.floor(turn / 360.0) - 180.0


@stand_in(angles.length)
def length(x: float, y: float) -> float:
    """See `angles.length`."""
    return math.sqrt(x * x + y * y)


@stand_in(angles.sine)
def sine(degrees: float) -> float:
    """See `angles.sine`."""
    return cosine_sine(degrees * _RADIANS)[1]


@stand_in(angles.arcsine)
def arcsine(value: float) -> float:
    """See `angles.arcsine`."""
    # `abs` changes nothing, but tells the compiler that the root exists.
    return direction(math.sqrt(abs((1.0 - value) * (1.0 + value))), value) * _DEGREES


@stand_in(applicable)
def whole(motors: Motors) -> Motors:
    """See `applicable`; numbers that are not finite are kept out before they get here."""
    left = max(-MAX_SPEED, min(MAX_SPEED, math.floor(motors.left + 0.5)))
    right = max(-MAX_SPEED, min(MAX_SPEED, math.floor(motors.right + 0.5)))
    arm = max(ARM_RAISED, min(ARM_DOWN, math.floor(motors.arm + 0.5)))
    return Motors(float(left), float(right), arm, JAW_OPEN if motors.jaw > JAW_OPEN / 2 else JAW_CLOSED)


for _function in (
    perception.way_to_wall,
    perception.raw_data,
    perception.state_vector,
    states.classify,
    steering.detour,
    steering.steer,
    steering._turn_on_the_spot,
    steering.clip,
    behaviours.command,
    behaviours.wait,
    behaviours._search,
    behaviours._approach,
    behaviours._orient,
    behaviours._pick_up,
    behaviours._push,
    behaviours._go_home,
    behaviours._avoid_home,
    behaviours._release,
    behaviours._arm_after_jaw,
    identification.explored,
    identification.drawn_type,
    identification.at_home,
    scoring.penalty,
    scoring.score,
):
    inline(_function)
