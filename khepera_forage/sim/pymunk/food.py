"""A food object as a pymunk body: a wooden disc that is pushed by contact and slows on the floor."""

import math

import pymunk

from khepera_forage.robots.khepera import FOOD_RADIUS
from khepera_forage.sim.arena import Point
from khepera_forage.sim.pymunk import collision_filters as layers

MASS = 0.013
"""kg: 22 cubic centimetres of soft wood (3.1: light enough for a Khepera to lift). Assumption: 0.6 g/cm3."""
FLOOR_FRICTION = 0.3 * MASS * 9810.0
"""kg mm/s2: wood on a painted floor, coefficient 0.3. Assumption."""


class PymunkFood:
    """One food object: on the floor, lifted off it, or fast between the fingers of a gripper.

    Held, it is one rigid body with the robot, as a wooden disc in a closed jaw is.

    Attributes:
        place: Where its centre was at the end of the last round, in mm.
        lifted: Whether it is off the floor.
        moved: How far it got in the last round on the floor, in mm.
    """

    def __init__(self, space: pymunk.Space, place: Point) -> None:
        self._space = space
        self._body = pymunk.Body(MASS, pymunk.moment_for_circle(MASS, 0, FOOD_RADIUS))
        self._body.position = place
        self._slide = pymunk.PivotJoint(space.static_body, self._body, (0, 0), (0, 0))
        self._spin = pymunk.GearJoint(space.static_body, self._body, 0, 1)
        self._slide.max_bias = self._spin.max_bias = 0
        self._slide.max_force = FLOOR_FRICTION
        self._spin.max_force = FLOOR_FRICTION * FOOD_RADIUS * 2 / 3
        self._holder: pymunk.Body | None = None
        self._grip = 0.0, 0.0
        self.place: tuple[float, float] = place
        self.lifted = False
        self.moved = 0.0
        self._shape = self._disc(self._body, (0.0, 0.0))
        space.add(self._body, self._shape, self._slide, self._spin)

    @property
    def position(self) -> tuple[float, float]:
        """Where its centre is within a round, in mm."""
        x, y = self._body.position if self._holder is None else self._holder.local_to_world(self._grip)
        return x, y

    def hold(self, holder: pymunk.Body) -> None:
        """From now on it moves with the robot that grips it."""
        self._grip = x, y = holder.world_to_local(self._body.position)
        self._space.remove(self._body, self._shape, self._slide, self._spin)
        self._shape = self._disc(holder, (x, y))
        self._space.add(self._shape)
        self._holder = holder

    def let_go(self) -> None:
        """It lies where the gripper held it, at rest on the floor."""
        assert self._holder is not None
        self._body.position = self.position
        self._body.velocity, self._body.angular_velocity = (0, 0), 0
        self._space.remove(self._shape)
        self._shape = self._disc(self._body, (0.0, 0.0))
        self._space.add(self._body, self._shape, self._slide, self._spin)
        self._holder = None
        self.set_lifted(False)

    def set_lifted(self, lifted: bool) -> None:
        """Off the floor it passes above other food; walls and robots still stop it."""
        self.lifted = lifted
        self._shape.filter = layers.LIFTED_FOOD if lifted else layers.FOOD

    def end_round(self) -> None:
        """Take down where it is now."""
        place = self.position
        self.moved = math.dist(place, self.place) if self._holder is None else 0.0
        self.place = place

    def end_round_held_at(self, x: float, y: float, cosine: float, sine: float) -> None:
        """Take down where it is in the gripper of a robot at a place, mm, with this cosine and sine of its heading."""
        ahead, left = self._grip
        self.moved = 0.0
        self.place = cosine * ahead - sine * left + x, sine * ahead + cosine * left + y

    def _disc(self, body: pymunk.Body, offset: tuple[float, float]) -> pymunk.Circle:
        disc = pymunk.Circle(body, FOOD_RADIUS, offset)
        disc.friction = 0.2
        disc.filter = layers.LIFTED_FOOD if self.lifted else layers.FOOD
        return disc
