"""Makes the rules of the task known to the compiler, as they stand.

Importing this module registers every function of the modules below, so that kernels compile the functions that Python
calls. Only plane geometry and random bits have compiled versions of their own: no rule is written twice.
"""

import inspect
import math

import numpy as np

from khepera_forage.compilation import counter_rng  # noqa: F401 (registers the random numbers)
from khepera_forage.compilation.decorators import inline, kernel, stand_in
from khepera_forage.compilation.trigonometry import cosine_sine, direction
from khepera_forage.geometry import angles, known_ways, nearest_wall, paths, straight_ways, walls
from khepera_forage.robots import footprint, khepera
from khepera_forage.task import (
    actions,
    arena_map,
    behaviours,
    episode,
    following,
    food_links,
    food_tracking,
    identification,
    nearest_food,
    pairing,
    past_poison,
    perception,
    placement,
    scoring,
    states,
    steering,
    way_finding,
)

RULE_MODULES = (
    walls,
    nearest_wall,
    straight_ways,
    known_ways,
    paths,
    footprint,
    actions,
    arena_map,
    behaviours,
    episode,
    following,
    food_links,
    food_tracking,
    identification,
    nearest_food,
    pairing,
    past_poison,
    perception,
    placement,
    scoring,
    states,
    steering,
    way_finding,
)
"""Modules whose functions kernels may call."""

_RARE = (
    nearest_wall.find_nearest_walls,
    known_ways.examine,
    paths.find_lengths,
    paths.has_path,
    past_poison.past_poison,
)
"""Long functions that few rounds call, compiled once."""
_DEGREES, _RADIANS = 180.0 / math.pi, math.pi / 180.0
_COSINES, _SINES = np.array(angles.HEADINGS).T.copy()


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


@stand_in(angles.cosine_sine)
def cosine_and_sine(radians: float) -> tuple[float, float]:
    """See `angles.cosine_sine`."""
    return cosine_sine(radians)


@stand_in(angles.heading_of)
def heading_of(orientation: float) -> tuple[float, float]:
    """See `angles.heading_of`."""
    degrees = int(orientation)
    return _COSINES[degrees], _SINES[degrees]


inline(khepera.applicable)
for _function in _RARE:
    kernel(_function)
for _module in RULE_MODULES:
    for _function in vars(_module).values():
        if (
            inspect.isfunction(_function)
            and _function.__module__ == _module.__name__
            and _function not in _RARE
        ):
            inline(_function)
