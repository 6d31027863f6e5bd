"""A food object as a pymunk body: a wooden disc that is pushed by contact and slows on the floor."""

import pymunk

from khepera_forage.robots.khepera import FOOD_RADIUS
from khepera_forage.worlds import layers
from khepera_forage.worlds.arena import Point

MASS = 0.013
"""kg: 22 cubic centimetres of soft wood (3.1: light enough for a Khepera to lift). Assumption: 0.6 g/cm3."""
FLOOR_FRICTION = 0.3 * MASS * 9810.0
"""kg mm/s2: wood on a painted floor, coefficient 0.3. Assumption."""


class PymunkFood:
    """One food object: on the floor, or lifted off it.

    Attributes:
        place: Where its centre was at the end of the last round, in mm.
        lifted: Whether it is off the floor.
    """

    def __init__(self, space: pymunk.Space, place: Point) -> None:
        self.body = pymunk.Body(MASS, pymunk.moment_for_circle(MASS, 0, FOOD_RADIUS))
        self.body.position = place
        self.place: tuple[float, float] = place
        self.shape = pymunk.Circle(self.body, FOOD_RADIUS)
        self.shape.friction = 0.2
        self._slide = pymunk.PivotJoint(space.static_body, self.body, (0, 0), (0, 0))
        self._spin = pymunk.GearJoint(space.static_body, self.body, 0, 1)
        self._slide.max_bias = self._spin.max_bias = 0
        self.lifted = False
        self.set_lifted(False)
        space.add(self.body, self.shape, self._slide, self._spin)

    def set_lifted(self, lifted: bool) -> None:
        """Off the floor it feels no friction and passes above other food; walls and robots still stop it."""
        self.lifted = lifted
        self.shape.filter = layers.LIFTED_FOOD if lifted else layers.FOOD
        self._slide.max_force = 0.0 if lifted else FLOOR_FRICTION
        self._spin.max_force = 0.0 if lifted else FLOOR_FRICTION * FOOD_RADIUS * 2 / 3

    def end_round(self) -> None:
        """Take down where it is now."""
        x, y = self.body.position
        self.place = x, y
