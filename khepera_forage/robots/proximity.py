"""The eight infra-red sensors: readings of the walls and discs around a robot.

The same analytic function serves all simulations. A sensor responds to the nearest point of each obstacle, by its
distance and its angle off the sensor's axis; the largest response counts.

Response to distance: K-Team's white-paper curve (facts: 1023 up to 8 mm, 450 at 20, 275 at 30, 190 at 40, 150 at
50) minus its value at 60 mm, where the readings of a Khepera I end (KSIM2, PYRO and WART agree on 58 to 60 mm).
Response to bearing: full on the axis, none at 60 degrees (KIKS), about WART's 1.45 % a degree between.
"""

import math
from collections.abc import Sequence

from khepera_forage.robots.khepera import RADIUS

MAX_READING = 1023
RANGE = 60.0
"""mm from the sensor to the most distant visible point."""
REACH = RADIUS + RANGE
"""mm from the robot's centre to the most distant visible point."""
HIDDEN_BY_ARM = (1015, 1022)
"""Lowest and highest reading of sensors 0-5 behind a lowered arm (WSU, measured on the real robot)."""
_HIDDEN_LOW, _HIDDEN_VALUES = HIDDEN_BY_ARM[0], HIDDEN_BY_ARM[1] - HIDDEN_BY_ARM[0] + 1

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


def response(distance: float) -> float:
    """Reading 0..1023 of white paper straight ahead, `distance` mm from the sensor."""
    near = (distance if distance > 0.0 else 0.0) + RESPONSE_OFFSET
    reading = RESPONSE_GAIN * (1.0 / (near * near) - RESPONSE_AT_RANGE)
    if reading <= 0.0:
        return 0.0
    return reading if reading < MAX_READING else float(MAX_READING)


def clean_readings(
    x: float,
    y: float,
    cosine: float,
    sine: float,
    walls: Sequence[tuple[float, float, float, float]],
    discs: Sequence[tuple[float, float, float]],
    first: int = 0,
) -> list[float]:
    """Noise-free readings of the eight sensors.

    Args:
        x: Position of the robot, mm.
        y: Position of the robot, mm.
        cosine: Cosine of its heading.
        sine: Sine of its heading.
        walls: Segments (x1, y1, x2, y2), mm; those farther than `REACH` from the robot have no effect.
        discs: Food and other robots as (x, y, radius), mm.
        first: Number of the first sensor to compute; those before it read 0.

    Returns:
        Eight readings 0..1023, in the order of command N.
    """
    readings = [0.0] * 8
    # Coordinates are relative to the robot, x forward and y left, so that the sensors are constant.
    for x1, y1, x2, y2 in walls:
        from_x = (x1 - x) * cosine + (y1 - y) * sine
        from_y = (y1 - y) * cosine - (x1 - x) * sine
        ex = (x2 - x1) * cosine + (y2 - y1) * sine
        ey = (y2 - y1) * cosine - (x2 - x1) * sine
        squared = ex * ex + ey * ey
        for i in range(first, 8):
            forward, left, axis, across = SENSORS[i]
            dx = from_x - forward
            dy = from_y - left
            t = -(dx * ex + dy * ey) / squared
            t = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
            dx += t * ex
            dy += t * ey
            along = dx * axis + dy * across
            if along > 0.0:
                distance = math.sqrt(dx * dx + dy * dy)
                if distance < RANGE and 2.0 * along > distance:
                    reading = response(distance) * (2.0 * along / distance - 1.0)
                    if reading > readings[i]:
                        readings[i] = reading
    for cx, cy, radius in discs:
        to_x = (cx - x) * cosine + (cy - y) * sine
        to_y = (cy - y) * cosine - (cx - x) * sine
        for i in range(first, 8):
            forward, left, axis, across = SENSORS[i]
            dx = to_x - forward
            dy = to_y - left
            along = dx * axis + dy * across
            if along > 0.0:
                distance = math.sqrt(dx * dx + dy * dy)
                if distance - radius < RANGE and 2.0 * along > distance:
                    reading = response(distance - radius) * (2.0 * along / distance - 1.0)
                    if reading > readings[i]:
                        readings[i] = reading
    return readings


def reported_readings(
    clean: Sequence[float], arm_down: bool, gain: float, floor: int, draws: Sequence[float]
) -> tuple[int, int, int, int, int, int, int, int]:
    """Readings as a robot reports them: whole numbers with noise; a lowered arm hides sensors 0-5.

    Args:
        clean: Eight noise-free readings, from `clean_readings`.
        arm_down: Whether the gripper is in front of sensors 0-5.
        gain: Largest error, as a share of the reading.
        floor: Readings up to this are noise.
        draws: Eight uniform numbers in [0, 1).
    """
    readings = [0] * 8
    hidden = 6 if arm_down else 0
    for i in range(hidden):
        readings[i] = int(_HIDDEN_LOW + _HIDDEN_VALUES * (draws[i] if gain else 0.5))
    noise_values = floor + 1
    for i in range(hidden, 8):
        if clean[i] > 0.0:
            readings[i] = _reported(clean[i], gain, floor, draws[i])
        elif floor:
            readings[i] = int(noise_values * draws[i])
    a, b, c, d, e, f, g, h = readings
    return a, b, c, d, e, f, g, h


def _reported(clean: float, gain: float, floor: int, draw: float) -> int:
    reading = clean * (1.0 + gain * (2.0 * draw - 1.0))
    if reading <= floor:
        return int((floor + 1) * draw) if floor else int(reading)
    return int(reading) if reading < MAX_READING else MAX_READING
