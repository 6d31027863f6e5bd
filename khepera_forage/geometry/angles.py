"""Plane geometry in degrees, for everything in `foraging`.

Each of these is one call of `math` here. The compiled task has versions of its own, of the same accuracy, that run
for many worlds at once: nothing else in `foraging` calls a transcendental function.
"""

import math


def bearing_of(x: float, y: float) -> float:
    """Direction of a vector, degrees -180..180 counter-clockwise from the x axis."""
    return math.degrees(math.atan2(y, x))


def turn_to(direction: float, orientation: float) -> float:
    """Degrees to turn from an orientation to a direction, -180..180, left positive."""
    return (direction - orientation + 180.0) % 360.0 - 180.0


def length(x: float, y: float) -> float:
    """Length of a vector."""
    return math.hypot(x, y)


def sine(degrees: float) -> float:
    """Sine of an angle in degrees."""
    return math.sin(math.radians(degrees))


def arcsine(value: float) -> float:
    """The angle in degrees, -90..90, that has this sine."""
    return math.degrees(math.asin(value))
