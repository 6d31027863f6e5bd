"""The eight infra-red sensors: where they are, and their response, which `sim.sensing` computes.

A sensor responds to the nearest point of each obstacle, by its distance and its angle off the sensor's axis; the
largest response counts.

Response to distance: K-Team's white-paper curve (facts: 1023 up to 8 mm, 450 at 20, 275 at 30, 190 at 40, 150 at
50) minus its value at 60 mm, where the readings of a Khepera I end (KSIM2, PYRO and WART agree on 58 to 60 mm).
Response to bearing: full on the axis, none at 60 degrees (KIKS), about WART's 1.45 % a degree between.
"""

import math

from khepera_forage.robots.khepera import RADIUS

MAX_READING = 1023
RANGE = 60.0
"""mm from the sensor to the most distant visible point."""
REACH = RADIUS + RANGE
"""mm from the robot's centre to the most distant visible point."""
HIDDEN_BY_ARM = (1015, 1022)
"""Lowest and highest reading of sensors 0-5 behind a lowered arm (WSU, measured on the real robot)."""

RESPONSE_GAIN = 450_000.0
RESPONSE_OFFSET = 11.5
RESPONSE_AT_RANGE = 1.0 / (RANGE + RESPONSE_OFFSET) ** 2
"""The curve: gain * (1 / (distance + offset)**2 - value at range), with distances in mm."""


def _sensor(forward: float, left: float, degrees: float) -> tuple[float, float, float, float]:
    angle = math.radians(degrees)
    return forward, left, math.cos(angle), math.sin(angle)


SENSORS = (
    _sensor(9.5, 23.0, 90.0),
    _sensor(18.0, 17.5, 45.0),
    _sensor(24.5, 5.5, 10.0),
    _sensor(24.5, -5.5, -10.0),
    _sensor(18.0, -17.5, -45.0),
    _sensor(9.5, -23.0, -90.0),
    _sensor(-23.0, -9.5, 180.0),
    _sensor(-23.0, 9.5, 180.0),
)
"""Position (mm forward, left; KSIM2) and direction (cosine, sine; protocol names) in the order of command N."""
