"""The eight infra-red sensors: what they read of walls and discs around them.

One analytic function for every world. A sensor answers to the nearest point of each obstacle, by its distance
and by how far it lies off the sensor's axis; the largest answer counts.

Response to distance: K-Team's white-paper curve (facts: 1023 up to 8 mm, 450 at 20, 275 at 30, 190 at 40, 150 at
50), less its value at 60 mm, where the readings of a Khepera I end (KSIM2, PYRO and WART agree on 58 to 60 mm).
Response to bearing: full on the axis, none at 60 degrees (KIKS), about WART's 1.45 % a degree between.
"""

import math
from collections.abc import Sequence

from khepera_forage.robots.khepera import RADIUS

MAX_READING = 1023
RANGE = 60.0
"""mm from the sensor beyond which nothing is seen."""
REACH = RADIUS + RANGE
"""mm from the robot's centre beyond which no obstacle is seen."""
HIDDEN_BY_ARM = (1015, 1022)
"""What sensors 0-5 read, lowest and highest, behind a lowered arm (WSU, on the real robot)."""

_GAIN = 450_000.0
_OFFSET = 11.5
_AT_RANGE = 1.0 / (RANGE + _OFFSET) ** 2


def _mount(forward: float, left: float, pointing: float) -> tuple[float, float, float, float]:
    angle = math.radians(pointing)
    return forward, left, math.cos(angle), math.sin(angle)


SENSORS = (
    _mount(9.5, 23.0, 90.0),
    _mount(18.0, 17.5, 45.0),
    _mount(24.5, 5.5, 10.0),
    _mount(24.5, -5.5, -10.0),
    _mount(18.0, -17.5, -45.0),
    _mount(9.5, -23.0, -90.0),
    _mount(-23.0, -9.5, 180.0),
    _mount(-23.0, 9.5, 180.0),
)
"""Place (mm forward, left; KSIM2) and direction (cosine, sine; protocol names) in the order of command N."""


def response(distance: float) -> float:
    """Reading 0..1023 of white paper straight ahead, `distance` mm from the sensor."""
    near = (distance if distance > 0.0 else 0.0) + _OFFSET
    reading = _GAIN * (1.0 / (near * near) - _AT_RANGE)
    if reading <= 0.0:
        return 0.0
    return reading if reading < MAX_READING else float(MAX_READING)


def cast(
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
        x: Of the robot, mm.
        y: Of the robot, mm.
        cosine: Of its heading.
        sine: Of its heading.
        walls: Segments (x1, y1, x2, y2), mm; those farther than `REACH` from the robot change nothing.
        discs: Food and other robots as (x, y, radius), mm.
        first: Number of the first sensor to cast; those before it stay at 0.

    Returns:
        Eight readings 0..1023, in the order of command N.
    """
    readings = [0.0] * 8
    # Everything is seen from the robot, x forward and y left, where the sensors stand still.
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


def measured(
    clean: Sequence[float], arm_down: bool, gain: float, floor: int, draws: Sequence[float]
) -> tuple[int, int, int, int, int, int, int, int]:
    """Readings as a robot reports them: whole numbers, with their noise, and hidden by a lowered arm.

    Args:
        clean: Eight noise-free readings, from `cast`.
        arm_down: Whether the gripper stands before sensors 0-5.
        gain: Largest error, as a share of the reading.
        floor: Readings up to this are noise.
        draws: Eight uniform numbers in [0, 1).
    """
    readings = [0] * 8
    hidden = 6 if arm_down else 0
    low, high = HIDDEN_BY_ARM
    for i in range(hidden):
        readings[i] = int(low + (high - low + 1) * (draws[i] if gain else 0.5))
    for i in range(hidden, 8):
        if clean[i] > 0.0:
            readings[i] = _reported(clean[i], gain, floor, draws[i])
        elif floor:
            readings[i] = int((floor + 1) * draws[i])
    a, b, c, d, e, f, g, h = readings
    return a, b, c, d, e, f, g, h


def _reported(clean: float, gain: float, floor: int, draw: float) -> int:
    reading = clean * (1.0 + gain * (2.0 * draw - 1.0))
    if reading <= floor:
        return int((floor + 1) * draw) if floor else int(reading)
    return int(reading) if reading < MAX_READING else MAX_READING
