"""The wheels of a simulated Khepera: joints that pull its body within their traction."""

import pymunk

from khepera_forage.robots.khepera import MASS, WHEEL_BASE

_TRACTION = 0.6 * MASS * 9810.0
"""kg mm/s2 that the wheels can pull: rubber on a painted floor, coefficient 0.6. Assumption."""


def add_wheels(space: pymunk.Space, body: pymunk.Body) -> pymunk.Body:
    """Add wheels to a robot's body.

    The wheels are joints that give the body the wanted velocity as far as their traction reaches. The joints connect
    it to a second body, which never moves but has that velocity.

    Args:
        space: The pymunk space of the robot.
        body: Already in that space.

    Returns:
        The second body: its velocity and angular velocity are those that the wheels pull to.
    """
    wanted = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    pull = pymunk.PivotJoint(wanted, body, (0, 0), (0, 0))
    twist = pymunk.GearJoint(wanted, body, 0, 1)
    pull.max_bias = twist.max_bias = 0
    pull.max_force, twist.max_force = _TRACTION, _TRACTION * WHEEL_BASE / 2
    space.add(wanted, pull, twist)
    return wanted
