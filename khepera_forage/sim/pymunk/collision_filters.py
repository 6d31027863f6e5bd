"""Which bodies touch which: a raised gripper and lifted food pass above food on the floor (23 mm high)."""

from pymunk import ShapeFilter

_WALL, _ROBOT, _FOOD, _FINGERS, _RAISED, _LIFTED = (1 << i for i in range(6))

WALL = ShapeFilter(categories=_WALL)
ROBOT = ShapeFilter(categories=_ROBOT)
FOOD = ShapeFilter(categories=_FOOD, mask=_WALL | _ROBOT | _FOOD | _FINGERS)
LIFTED_FOOD = ShapeFilter(categories=_LIFTED, mask=_WALL | _ROBOT)
FINGERS = ShapeFilter(categories=_FINGERS, mask=_WALL | _ROBOT | _FOOD)
RAISED_FINGERS = ShapeFilter(categories=_RAISED, mask=_WALL | _ROBOT)
