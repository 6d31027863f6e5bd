"""Position control of one wheel, as commands C, J and K have it: to a count, along a trapezoid of speed.

Speeds are pulses in 10 ms, as in command D. The ROM plans every 10 ms; here it is planned once a control period.
"""

import math

from khepera_forage.robots.khepera import CONTROL_PERIOD

PULSES_A_PERIOD = round(CONTROL_PERIOD / 0.01)
"""Pulses that a wheel turns in a control period at one speed unit."""
DEFAULT_SPEED = 20
DEFAULT_ACCELERATION = 64
"""1/256 speed unit in 10 ms; both defaults are KNET's and KH2PY's, 160 mm/s and 200 mm/s2."""
TOLERANCE = PULSES_A_PERIOD // 2
"""Pulses, 0.4 mm: wheels that take whole speed units for whole control periods come no nearer."""


class WheelPosition:
    """The way of one wheel to where it shall stand.

    Attributes:
        max_speed: Speed units that it does not exceed.
        target: The count to reach.
    """

    def __init__(self) -> None:
        self.max_speed = DEFAULT_SPEED
        self.target = 0
        self._growth = 0.0
        self._planned, self._speed = 0.0, 0.0
        self.set_profile(DEFAULT_SPEED, DEFAULT_ACCELERATION)

    def set_profile(self, max_speed: int, acceleration: int) -> None:
        """What the trapezoid looks like.

        Args:
            max_speed: In speed units.
            acceleration: In 1/256 speed unit in 10 ms.
        """
        self.max_speed = max_speed
        self._growth = acceleration / 256 * PULSES_A_PERIOD

    def aim(self, target: int, count: int, speed: float) -> None:
        """Go to a target.

        Args:
            target: A count.
            count: Where the wheel is.
            speed: At which it turns.
        """
        self.target = target
        self._planned, self._speed = float(count), float(speed)

    def shift(self, pulses: int) -> None:
        """The counter has been set: where the wheel stands now counts so much more."""
        self._planned += pulses

    def reached(self, count: int) -> bool:
        """Whether a wheel at this count is where it shall be."""
        return abs(self.target - count) <= TOLERANCE

    def speed(self, count: int) -> int:
        """The speed for the coming control period, in whole units, of a wheel at this count."""
        ahead = self.target - self._planned
        distance = abs(ahead) / PULSES_A_PERIOD
        # From `brakes` the wheel stops within the distance if it slows down by `growth` a period; the last step, which
        # is less than one period long, may be slower still.
        half = self._growth / 2
        brakes = math.sqrt(half * half + 2 * self._growth * distance) - half
        wanted = math.copysign(min(self.max_speed, brakes, distance), ahead)
        if distance > self._growth or abs(self._speed) > 2 * self._growth:
            wanted = max(self._speed - self._growth, min(self._speed + self._growth, wanted))
        self._speed = wanted
        self._planned += wanted * PULSES_A_PERIOD
        return math.floor((self._planned - count) / PULSES_A_PERIOD + 0.5)
