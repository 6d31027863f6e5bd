"""Position control of one wheel (commands C, J and K): to a target count, with a trapezoidal speed profile.

Speeds are pulses in 10 ms, as in command D. The real firmware plans every 10 ms; this one once per control period.
"""

import math

from khepera_forage.robots.khepera import PULSES_PER_UNIT

DEFAULT_SPEED = 20
DEFAULT_ACCELERATION = 64
"""1/256 speed unit in 10 ms; both defaults are KNET's and KH2PY's, 160 mm/s and 200 mm/s2."""
TOLERANCE = 0.5
"""In pulses of one control period at one speed unit: the accuracy of wheels that take whole speed units."""


class WheelPositionController:
    """Drives one wheel to a target count.

    Args:
        pulses_per_unit: Pulses of a wheel in one control period at one speed unit.

    Attributes:
        max_speed: Limit of the speed, in speed units.
        target: The count to reach.
    """

    def __init__(self, pulses_per_unit: float = PULSES_PER_UNIT) -> None:
        self._pulses_per_unit = pulses_per_unit
        self.max_speed = DEFAULT_SPEED
        self.target = 0
        self._acceleration = 0.0
        self._planned, self._speed = 0.0, 0.0
        self.set_profile(DEFAULT_SPEED, DEFAULT_ACCELERATION)

    def set_profile(self, max_speed: int, acceleration: int) -> None:
        """Set the speed profile.

        Args:
            max_speed: In speed units.
            acceleration: In 1/256 speed unit in 10 ms.
        """
        self.max_speed = max_speed
        self._acceleration = acceleration / 256 * self._pulses_per_unit

    def set_target(self, target: int, count: int, speed: float) -> None:
        """Start moving to a target.

        Args:
            target: The count to reach.
            count: The present count.
            speed: The present speed, in speed units.
        """
        self.target = target
        self._planned, self._speed = float(count), float(speed)

    def shift_counter(self, pulses: int) -> None:
        """Correct the plan after the counter was set to a value higher by `pulses`."""
        self._planned += pulses

    def reached(self, count: int) -> bool:
        """Whether a wheel at this count has reached the target."""
        return abs(self.target - count) <= TOLERANCE * self._pulses_per_unit

    def speed(self, count: int) -> int:
        """The speed for the next control period, in whole units, of a wheel at this count."""
        remaining = self.target - self._planned
        distance = abs(remaining) / self._pulses_per_unit
        # From `braking_speed` the wheel stops within the distance at the given deceleration; the last step, shorter
        # than one period, may be slower still.
        half = self._acceleration / 2
        braking_speed = math.sqrt(half * half + 2 * self._acceleration * distance) - half
        wanted = math.copysign(min(self.max_speed, braking_speed, distance), remaining)
        if distance > self._acceleration or abs(self._speed) > 2 * self._acceleration:
            wanted = max(self._speed - self._acceleration, min(self._speed + self._acceleration, wanted))
        self._speed = wanted
        self._planned += wanted * self._pulses_per_unit
        return math.floor((self._planned - count) / self._pulses_per_unit + 0.5)
