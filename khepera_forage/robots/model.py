"""What the kinds of robots can do, as data: dimensions, speeds, sensors, gripper."""

import math
from dataclasses import dataclass

from khepera_forage.robots.khepera import BARRIER, FOOD_RADIUS, MAX_SPEED, PULSE, RADIUS, SPEED_UNIT, WHEEL_BASE
from khepera_forage.robots.proximity import SENSORS


@dataclass(frozen=True, slots=True)
class RobotModel:
    """One kind of robot.

    Every robot acts in the thesis's arenas, whose plans are drawn for a Khepera. For a robot of another size the arena,
    its food and its markers are built `scale` times as large, so that all distances of the task remain those of the
    thesis. Lengths below are those of the real robot; the driver converts speeds and counters.

    Attributes:
        name: As in `lab.toml`.
        radius: Of the body, in mm.
        wheel_base: Distance of the wheels, in mm.
        scale: Millimetres on the real floor for one millimetre of the plan.
        max_speed: Highest wheel speed in speed units: 8 mm/s on the plan.
        unit: What a wheel is commanded, in the robot's own unit, for one speed unit.
        pulse: Millimetres of real wheel travel for one count; 0 for a robot without counters.
        infra_reds: Direction of each sensor in degrees, counter-clockwise from straight ahead, in the robot's order;
            none for a robot that has no such sensors.
        sensors: Place (mm forward and left on the plan) and direction (cosine, sine) of each infra-red, in Khepera's
            order; of a robot that has none, those of a Khepera, for readings that follow from the map.
        reach: Millimetres on the plan from the robot's centre to that of food that is before it, at most; for a robot
            without a gripper.
        marker_height: Millimetres on the plan from the floor to its marker, on posts or on top of the robot; 0 without
            a marker. Assumption.
        has_gripper: Whether it can pick up food. Without one, the arm counts as lowered, and the jaw as open; and the
            marker is no larger than the robot, so that it hides no food.
    """

    name: str
    radius: float
    wheel_base: float
    scale: float
    max_speed: int
    unit: float
    pulse: float
    infra_reds: tuple[float, ...]
    sensors: tuple[tuple[float, float, float, float], ...]
    reach: float
    marker_height: float
    has_gripper: bool

    @property
    def plan_base(self) -> float:
        """Distance of the wheels on the plan, in mm. The radius there is a Khepera's for every robot."""
        return self.wheel_base / self.scale


KHEPERA = RobotModel(
    name="khepera",
    radius=RADIUS,
    wheel_base=WHEEL_BASE,
    scale=1.0,
    max_speed=MAX_SPEED,
    unit=1.0,
    pulse=PULSE,
    infra_reds=(90.0, 45.0, 10.0, -10.0, -45.0, -90.0, 180.0, 180.0),
    sensors=SENSORS,
    reach=0.0,
    marker_height=70.0,
    has_gripper=True,
)
KHEPERA_ORDER = (5, 6, 7, 0, 1, 2, 3, 4)
"""An e-puck's sensors in the order of `Senses.proximity`: left 90, 49, 17, right 17, 49, 90, back right, back left."""
_E_PUCK_INFRA_REDS = (-17.0, -49.0, -90.0, -150.0, 150.0, 90.0, 49.0, 17.0)
_STEP = 128.8 / 1000
_E_PUCK_SCALE = 35.0 / RADIUS
E_PUCK = RobotModel(
    name="e-puck2",
    radius=35.0,
    wheel_base=53.0,
    scale=_E_PUCK_SCALE,
    max_speed=int(1100 * _STEP / (SPEED_UNIT * _E_PUCK_SCALE)),
    unit=SPEED_UNIT * _E_PUCK_SCALE / _STEP,
    pulse=_STEP,
    infra_reds=_E_PUCK_INFRA_REDS,
    sensors=tuple(
        (RADIUS * math.cos(a), RADIUS * math.sin(a), math.cos(a), math.sin(a))
        for a in (math.radians(_E_PUCK_INFRA_REDS[i]) for i in KHEPERA_ORDER)
    ),
    reach=BARRIER + FOOD_RADIUS,
    marker_height=45.0 / _E_PUCK_SCALE,
    has_gripper=False,
)
"""GCtronic: 70 mm across, 1,000 steps or 128.8 mm a turn of a wheel, at most 1,100 steps/s."""
_TOIO_SCALE = 32.0 / 55.0
_TOIO_SPEED = 2.81
"""mm/s of a wheel for one unit of a cube's motor speed."""
TOIO = RobotModel(
    name="toio",
    radius=16.0,
    wheel_base=26.6,
    scale=_TOIO_SCALE,
    max_speed=MAX_SPEED,
    unit=SPEED_UNIT * _TOIO_SCALE / _TOIO_SPEED,
    pulse=0.0,
    infra_reds=(),
    sensors=SENSORS,
    reach=BARRIER + FOOD_RADIUS,
    marker_height=0.0,
    has_gripper=False,
)
"""Sony: cubes of 31.8 mm, which know their place on a printed mat."""

MODELS = {model.name: model for model in (KHEPERA, E_PUCK, TOIO)}


def model_of(robot: str) -> RobotModel:
    """The model with a name; raises `ValueError` for an unknown one."""
    if robot not in tuple(MODELS):  # unlike a dictionary, it takes what has no hash
        raise ValueError(f"robot is {robot!r}; allowed: {', '.join(map(repr, MODELS))}")
    return MODELS[robot]
