"""Angles and lengths in the plane. Plain functions, also compiled."""

import math


def bearing_of(x: float, y: float) -> float:
    """Direction of a vector, degrees -180..180 counter-clockwise from the x axis."""
    return math.degrees(math.atan2(y, x))


def turn_to(direction: float, orientation: float) -> float:
    """Degrees to turn from an orientation to a direction, -180..180, left positive."""
    return (direction - orientation + 180.0) % 360.0 - 180.0


def length(x: float, y: float) -> float:
    """Length of a vector."""
    return math.sqrt(x * x + y * y)


def sine(degrees: float) -> float:
    """Sine of an angle in degrees."""
    return math.sin(math.radians(degrees))


def arcsine(value: float) -> float:
    """The angle in degrees, -90..90, that has this sine."""
    return math.degrees(math.asin(value))


def cosine_sine(radians: float) -> tuple[float, float]:
    """Cosine and sine of an angle in radians."""
    return math.cos(radians), math.sin(radians)


def heading_of(orientation: int) -> tuple[float, float]:
    """Cosine and sine of an orientation in degrees."""
    return cosine_sine(math.radians(orientation))
