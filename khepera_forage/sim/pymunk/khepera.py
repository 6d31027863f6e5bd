"""A Khepera as a pymunk body: wheels that pull within their traction, infra-reds, and the gripper turret."""

import math
from collections.abc import Callable, Sequence

import pymunk

from khepera_forage.geometry.polygon import Segment
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_ON_FLOOR,
    ARM_RAISED,
    FINGER_TIP,
    JAW_OPEN,
    MASS,
    PRESENT,
    PULSE,
    RADIUS,
    SPEED_UNIT,
    WHEEL_BASE,
    Motors,
    Senses,
    applicable,
    check_finite,
)
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.robots.proximity import clean_readings, reported_readings
from khepera_forage.sim.arena import Pose
from khepera_forage.sim.broad_phase import WallWatch
from khepera_forage.sim.pymunk import collision_filters as layers
from khepera_forage.sim.pymunk.food import PymunkFood
from khepera_forage.sim.pymunk.gripper import PymunkGripper
from khepera_forage.sim.pymunk.nearby import discs_near, may_push
from khepera_forage.sim.pymunk.wheels import add_wheels
from khepera_forage.sim.world import FINE_TRAVEL, SUBSTEPS, Timing

# The properties' own functions: setting them by name goes through `__setattr__` too and costs twice as much.
_set_position: Callable[[pymunk.Body, tuple[float, float]], None] = pymunk.Body.position.fset  # type: ignore[attr-defined]
_set_angle: Callable[[pymunk.Body, float], None] = pymunk.Body.angle.fset  # type: ignore[attr-defined]
_set_velocity: Callable[[pymunk.Body, tuple[float, float]], None] = pymunk.Body.velocity.fset  # type: ignore[attr-defined]
_set_spin: Callable[[pymunk.Body, float], None] = pymunk.Body.angular_velocity.fset  # type: ignore[attr-defined]


class PymunkKhepera:
    """A simulated `Robot`; its world moves it.

    Args:
        space: The pymunk space to live in.
        pose: Where it starts.
        walls: Segments of its own enclosure, which it senses and keeps an eye on.
        noise: Its troubles.
        bias: Lasting share by which the left and the right wheel travel too far.
        parameters: Its constant deviations.
        timing: How long a round lasts, and how fast arm and jaw move.
    """

    def __init__(
        self,
        space: pymunk.Space,
        pose: Pose,
        walls: Sequence[Segment],
        noise: Noise,
        bias: tuple[float, float],
        parameters: RobotParameters,
        timing: Timing,
    ) -> None:
        self.body = pymunk.Body(MASS, MASS * RADIUS**2 / 2)
        self.body.position = pose[:2]
        self.body.angle = pose.heading
        shape = pymunk.Circle(self.body, RADIUS)
        shape.friction = 0.2
        shape.filter = layers.ROBOT
        space.add(self.body, shape)
        self._wheels = add_wheels(space, self.body)
        self.gripper = PymunkGripper(space, self.body, parameters.finger_length, timing)
        self._duration = timing.round_duration
        self._pulses_a_round = SPEED_UNIT * self._duration / PULSE
        self.foods: Sequence[PymunkFood] = ()
        self.others: Sequence[pymunk.Body] = ()
        self._walls = WallWatch(walls)
        self._noise = noise
        self._infra_red_gain = parameters.infra_red_gain
        self._arm_reading_scale = parameters.arm_reading_scale
        self._left_share, self._right_share = 1.0 + (bias[0] + parameters.left_wheel_error), 1.0 + bias[1]
        self._command = Motors(0, 0, ARM_RAISED, JAW_OPEN)
        self._left_pulses = self._right_pulses = 0.0
        self._senses: Senses | None = None
        self._sensor_draws: Sequence[float] = (0.5,) * 8
        self._velocity = self._rolling = 0.0, 0.0
        self._forward = self._turn = self._turning = 0.0
        self._steering = self._glided = self._moves_jaw = False
        self._free = True
        self.pose = pose
        self._walls.survey(pose.x, pose.y)

    def sense(self) -> Senses:
        """What the robot senses now; the same until the world advances."""
        if self._senses is None:
            self._senses = self._read()
        return self._senses

    def drive(self, motors: Motors) -> Motors:
        """Take a command for the coming rounds; returns it in whole speed units, within limits."""
        check_finite(motors)
        self._command = applicable(motors)
        return self._command

    def stop(self) -> None:
        """Wheels to zero; arm and jaw go on to where they were sent, as a real turret does."""
        self._command = self._command._replace(left=0, right=0)

    def close(self) -> None:
        """Stop."""
        self.stop()

    def put(self, pose: Pose) -> None:
        """Stand elsewhere, at rest; food in the gripper comes along."""
        self.body.position, self.body.angle = pose[:2], pose.heading
        self.body.velocity, self.body.angular_velocity = (0, 0), 0
        if self.gripper.held is not None:
            self.gripper.held.end_round()
        self._rolling, self._turning = (0.0, 0.0), 0.0
        self._senses = None
        self.pose = pose
        self._walls.survey(pose.x, pose.y)

    def begin_round(self, wheel_draws: Sequence[float], sensor_draws: Sequence[float]) -> int:
        """Fix this round's wheel travel and the noise of the sensors at its end.

        Args:
            wheel_draws: Two standard normal numbers.
            sensor_draws: Eight uniform ones.

        Returns:
            How many physics steps the round needs, by what the robot can touch in it; 0 where it touches nothing.
        """
        self._sensor_draws = sensor_draws
        left, right, arm, jaw = self._command
        gripper = self.gripper
        if arm != gripper.arm:
            self._place_body()
            gripper.move_arm(arm, self._duration, self.foods, self.others)
        slip = self._noise.wheel_slip
        left_speed = left * SPEED_UNIT * (self._left_share + slip * wheel_draws[0])
        right_speed = right * SPEED_UNIT * (self._right_share + slip * wheel_draws[1])
        forward = self._forward = (left_speed + right_speed) / 2
        turn = self._turn = (right_speed - left_speed) / WHEEL_BASE
        travel = (abs(forward) + abs(turn) * FINGER_TIP) * self._duration
        x, y, heading = self.pose
        # Away from walls the direction in the middle of the round does for all of it: the chord ends where the arc
        # does, to less than 0.1 mm. Where a wall may turn the robot, the wheels are pointed step by step.
        heading += turn * self._duration / 2
        self._velocity = forward * math.cos(heading), forward * math.sin(heading)
        self._steering, self._free = False, True
        pushing, moving = may_push(x, y, travel, gripper.on_floor, gripper.held, self.foods, self.others)
        moves_jaw = self._moves_jaw = jaw != gripper.jaw and gripper.wants_to_move_jaw(jaw)
        if travel == 0.0 and not moving and not moves_jaw:
            return 0
        if self._walls.clear(self.pose, travel, pushing):
            self._free = not pushing
            return SUBSTEPS if pushing else 1 if moves_jaw else 0
        self._free = False
        self._steering = forward != 0.0
        return max(SUBSTEPS, math.ceil(travel / FINE_TRAVEL))

    def glide(self) -> None:
        """The whole round where nothing resists: uniform motion, for which no physics is needed."""
        x, y, angle = self.pose
        velocity_x, velocity_y = self._rolling = self._velocity
        turn = self._turning = self._turn
        if velocity_x or velocity_y or turn:
            x, y = x + velocity_x * self._duration, y + velocity_y * self._duration
            angle += turn * self._duration
        self._glided = True
        self._end_round(x, y, angle)
        if self.others:
            self._place_body()
        if self.gripper.held is not None:
            self.gripper.held.end_round_held_at(x, y, math.cos(angle), math.sin(angle))

    def engage(self) -> None:
        """Hand the wheels over to the physics of this round."""
        _set_velocity(self._wheels, self._velocity)
        _set_spin(self._wheels, self._turn)
        if self._free:
            self._rolling, self._turning = self._velocity, self._turn
        self._place_body()
        if self._free or self._glided:
            _set_velocity(self.body, self._rolling)
            _set_spin(self.body, self._turning)
            self._glided = False

    def _place_body(self) -> None:
        """Bring the body to where the robot has glided: only physics, the gripper and other robots look at it."""
        if self._glided:
            _set_position(self.body, self.pose[:2])
            _set_angle(self.body, self.pose.heading)

    @property
    def busy(self) -> bool:
        """Whether wheels or jaw want to be moved along within the round."""
        return self._steering or self._moves_jaw

    def push(self, dt: float) -> None:
        """Point the wheels' pull for the next `dt` seconds, and move the jaw."""
        if self._steering:
            angle = self.body.angle
            _set_velocity(self._wheels, (self._forward * math.cos(angle), self._forward * math.sin(angle)))
        if self._moves_jaw:
            self.gripper.move_jaw(self._command.jaw, dt, self.foods, self.others, self._walls.near)

    def end_round(self) -> None:
        """Take down where physics has brought the robot."""
        self._end_round(*self.body.position, self.body.angle)

    def _end_round(self, x: float, y: float, angle: float) -> None:
        left, right, _, _ = self._command
        self._left_pulses += left * self._pulses_a_round
        self._right_pulses += right * self._pulses_a_round
        self._senses = None
        # In every round, as in `_read`: a named tuple's own constructor takes twice as long as that of tuples.
        self.pose = tuple.__new__(Pose, (x, y, angle))
        self._walls.survey(x, y)

    def _read(self) -> Senses:
        gripper = self.gripper
        x, y, angle = self.pose
        blocked = gripper.arm >= ARM_ON_FLOOR
        discs = discs_near(x, y, self.foods, self.others)
        walls = self._walls.near
        cosine, sine = math.cos(angle), math.sin(angle)
        if walls or discs:
            clean = clean_readings(x, y, cosine, sine, walls, discs, first=6 if blocked else 0)
            if self._infra_red_gain != 1.0:
                clean = [self._infra_red_gain * reading for reading in clean]
        else:
            clean = [0.0] * 8
        gain, floor = self._noise.proximity_gain, self._noise.proximity_floor
        readings = reported_readings(clean, blocked, gain, floor, self._sensor_draws)
        arm = int(ARM_DOWN - self._arm_reading_scale * (ARM_DOWN - gripper.arm) + 0.5)
        present = PRESENT if gripper.interrupted(x, y, cosine, sine, self.foods) else 0
        return tuple.__new__(
            Senses,
            (readings, int(self._left_pulses), int(self._right_pulses), arm, int(gripper.jaw + 0.5), present),
        )
