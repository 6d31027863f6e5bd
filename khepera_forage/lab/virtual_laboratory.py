"""Laboratories without hardware: real drivers and trackers, connected to virtual robots or cubes."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from khepera_forage.lab.clock import WallClock
from khepera_forage.lab.cubes import CubeOperator
from khepera_forage.lab.laboratory import Laboratory
from khepera_forage.lab.operator import Operator, OperatorGaveUp, OperatorRequest
from khepera_forage.lab.settings_file import LabSettings
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.drivers import DRIVERS, FIRMWARES
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import Faults, VirtualKhepera
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.layout_checks import cable_anchor, check_layout
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout, Timing
from khepera_forage.vision.calibration import DEFAULT_SIZE, Calibration
from khepera_forage.vision.rendering import CameraAppearance, FrameRenderer
from khepera_forage.vision.scene import MM_PER_PIXEL, Truth
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.video import FrameSource

_TAG_FRAMES = (1440, 1080)
"""Pixels of the frames that show tags, which are too small for frames of 640 x 480."""
_INTERVAL = 0.001
"""Seconds of the computer from one position of a virtual cube to the next."""


class VirtualLaboratory(Laboratory):
    """A `Laboratory` with virtual devices.

    Every robot is a simulated body with a Khepera's `Firmware` in front of it, on its own pseudo-terminal. The camera's
    frames are rendered from the simulated world, and the operator is simulated. Driver, protocol, fleet, tracker and
    placement checks are those of the real laboratory.

    By default the clock advances the simulation instead of waiting, as fast as the machine allows. The same seed and
    layout then give the same observations, bit for bit, as long as no fault is enabled and the machine replies within
    the driver's time limits. Encoder counters continue from one episode to the next, as those of a real robot do.

    Args:
        settings: Arena, robots, tolerance, tracker and period; ports, camera source and calibration are replaced.
        arm_speed: Of all robots, positions a second.
        jaw_speed: Of all robots, positions a second.
        noise: Noise of robots and operator (not of the camera); the laboratory's by default.
        appearance: Appearance and disturbances of the frames; the laboratory's by default.
        paced: Whether bytes take the transmission time of each robot's baud rate.
        faults: Faults of the lines.
        fault_seed: Seed of the faults.
        real_time: Whether to keep real time, with the wall clock.
        operator: Replaces `virtual_operator`; for example, a person who directs it.
        camera: Opens the camera in front of the rendered frames, again after a loss; by default the laboratory takes
            the rendered frames themselves.

    Attributes:
        simulation: The simulated world, with the true poses.
        firmwares: The robots' firmwares, which outlast their lines.
        virtual_kheperas: The robots' ends of the serial lines.
        frame_source: Source of the rendered frames.
        virtual_operator: Places the simulated bodies.
    """

    def __init__(
        self,
        settings: LabSettings,
        *,
        arm_speed: float,
        jaw_speed: float,
        noise: Noise | str | None = None,
        appearance: CameraAppearance | None = None,
        paced: bool = False,
        faults: Faults | None = None,
        fault_seed: int = 0,
        real_time: bool = False,
        operator: Operator | None = None,
        camera: Callable[[FrameSource], FrameSource] | None = None,
    ) -> None:
        if others := {robot.type for robot in settings.robots} - FIRMWARES.keys():
            raise ValueError(f"robots are of type {others.pop()!r}; allowed: {', '.join(FIRMWARES)}")
        noise = checked_noise(noise)
        appearance = CameraAppearance.laboratory() if appearance is None else appearance
        arenas = settings.arenas
        # Rounds of the simulation last about as long as a control period of the firmware.
        self._rounds_per_period = max(1, round(settings.period / CONTROL_PERIOD))
        timing = Timing(settings.period / self._rounds_per_period, arm_speed, jaw_speed)
        # A simulated world has markers with one or two holes; the frames show their numbers.
        holes = [min(robot.holes, 2) for robot in settings.robots]
        model = DRIVERS[settings.robots[0].type].model
        self.simulation = PymunkWorld(arenas, holes, noise, timing=timing, model=model)
        layout = Layout(tuple(a.start for a in arenas), tuple(food for a in arenas for food in a.foods))
        self.simulation.reset(np.random.default_rng(fault_seed), layout)
        # One lock for all, because they share one simulated world.
        self._lock = threading.RLock()
        self.firmwares: list[Firmware] = [
            FIRMWARES[robot.type](body, self._lock, timing.round_duration)
            for robot, body in zip(settings.robots, self.simulation.robots, strict=True)
        ]
        size = _TAG_FRAMES if settings.tracker.markers == "tags" else DEFAULT_SIZE
        self.frame_source = FrameRenderer(
            self._truth,
            appearance,
            cable_anchor(arenas) if model.has_gripper else None,  # an e-puck2 has none
            walls=[wall for arena in arenas for wall in arena.segments],
            period=settings.period,
            size=size,
            tracker=settings.tracker,
            gripper=model.has_gripper,
        )
        self.virtual_operator = VirtualOperator(self, noise)
        self._paced, self._faults, self._real_time, self._now = paced, faults, real_time, 0.0
        self._rngs = np.random.default_rng(fault_seed).spawn(len(holes))
        self.virtual_kheperas: list[VirtualKhepera] = []
        middle = PICTURE_WIDTH / 2 * MM_PER_PIXEL, PICTURE_HEIGHT / 2 * MM_PER_PIXEL
        above = None if appearance.height is None else (*middle, appearance.height)
        try:
            # The virtual robots end with this process: no watchdog has anything to stop.
            robots = tuple(replace(robot, watchdog=False) for robot in settings.robots)
            super().__init__(
                self._open_lines(replace(settings, robots=robots)),
                self.virtual_operator if operator is None else operator,
                source=lambda: self.frame_source if camera is None else camera(self.frame_source),
                calibration=Calibration.identity(above, size),
                clock=WallClock(settings.period, time.monotonic if real_time else lambda: self._now, self._sleep),
            )
        except BaseException:
            self._close_lines()
            raise

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """As `Laboratory.reset`; the simulation, the frames and the operator draw from `rng`."""
        check_layout(self.arenas, layout)
        world_rng, frame_rng, operator_rng = rng.spawn(3)
        self.frame_source.reset(frame_rng)
        self.virtual_operator.begin_episode(operator_rng, world_rng)
        super().reset(rng, layout)

    def close(self) -> None:
        """Stop the robots and close all devices; a second call does nothing."""
        try:
            super().close()
        finally:
            self._close_lines()

    def _truth(self) -> Truth:
        """What the camera shows: the simulated world, with the markers of the settings."""
        truth = self.simulation.truth()
        numbered = zip(truth.markers, self.settings.robots, strict=True)
        return truth._replace(markers=tuple((*pose, robot.holes) for (*pose, _), robot in numbered))  # type: ignore[misc]

    def _sleep(self, seconds: float) -> None:
        """Advance the simulation by a round."""
        if self._real_time:
            time.sleep(seconds)
        self._now += self.round_duration
        with self._lock:
            for _ in range(self._rounds_per_period):
                self.simulation.advance()
                for firmware in self.firmwares:
                    firmware.tick()

    def _open_lines(self, settings: LabSettings) -> LabSettings:
        """Open the lines that are not connected; returns the settings with the ports of all lines."""
        for i, (robot, firmware) in enumerate(zip(settings.robots, self.firmwares, strict=True)):
            baud = (robot.baud or firmware.protocol.baud) if self._paced else None
            if i < len(self.virtual_kheperas):
                if self.virtual_kheperas[i].connected:
                    continue
                self.virtual_kheperas[i].close()
            line = VirtualKhepera(firmware, baud=baud, faults=self._faults, rng=self._rngs[i])
            self.virtual_kheperas[i : i + 1] = [line]
        robots = zip(settings.robots, self.virtual_kheperas, strict=True)
        return replace(settings, robots=tuple(replace(robot, port=khepera.url) for robot, khepera in robots))

    def _close_lines(self) -> None:
        while self.virtual_kheperas:
            self.virtual_kheperas.pop().close()


class VirtualCubeLaboratory(Laboratory):
    """A `Laboratory` on a virtual mat, whose time passes in rounds and while the cubes drive to their places.

    `table` has the true places of the cubes, whose ports in the settings begin with "virtual:".
    """

    def __init__(self, settings: LabSettings) -> None:
        from khepera_forage.robots.toio.virtual import VirtualTable, use_table

        self._now = 0.0
        self.table = VirtualTable(lambda: self._now, _INTERVAL)
        use_table(self.table)
        clock = WallClock(settings.period, lambda: self._now, lambda _: self._sleep(settings.period))
        super().__init__(settings, clock=clock)
        self._operator = CubeOperator(self._cubes, self._food_cubes, self.arenas, self._sleep)

    def _sleep(self, seconds: float) -> None:
        self._now += seconds
        self.table.advance()


_MAX_TRIES, _MAX_REPEATS = 200, 10
"""Draws of placement errors before a request counts as impossible; failed repetitions before the operator gives up."""


class VirtualOperator:
    """Carries out requests at once, with the errors `Noise.placement_error` and `placement_heading_error`.

    `requests` are all since the last `begin_episode`.
    """

    def __init__(self, lab: VirtualLaboratory, noise: Noise) -> None:
        self.requests: list[OperatorRequest] = []
        self._lab, self._noise, self._repeats = lab, noise, 0
        self._rng = self._world_rng = np.random.default_rng(0)

    def begin_episode(self, rng: np.random.Generator, world_rng: np.random.Generator) -> None:
        """Set the generators of a new episode, for placement errors and for the reset of the world."""
        self.requests = []
        self._rng, self._world_rng = rng, world_rng

    def __call__(self, request: OperatorRequest) -> None:
        """Carry out a request."""
        self.requests.append(request)
        self._repeats = self._repeats + 1 if request.errors else 0
        if self._repeats >= _MAX_REPEATS:
            raise OperatorGaveUp(
                f"the virtual operator has placed everything {_MAX_REPEATS} times: {'; '.join(request.errors)}"
            )
        if not request.robots and request.foods is None:
            self._lab.settings = self._lab._open_lines(self._lab.settings)
            return
        for _ in range(_MAX_TRIES):
            try:
                self._place(request)
            except ValueError as error:  # in a wall, or on top of something: draw other errors
                reason = error
            else:
                return
        raise OperatorGaveUp(f"the virtual operator finds no room: {reason}")

    def _place(self, request: OperatorRequest) -> None:
        poses = [self._with_error(mark.pose) for mark in request.robots]
        world = self._lab.simulation
        if request.foods is None:
            for mark, pose in zip(request.robots, poses, strict=True):
                world.place(mark.number, pose)
            return
        foods = tuple(Point(*self._with_error(Pose(x, y, 0.0))[:2]) for x, y in request.foods)
        world.reset(self._world_rng, Layout(tuple(poses), foods))
        for firmware, body in zip(self._lab.firmwares, world.robots, strict=True):
            firmware.attach(body)

    def _with_error(self, pose: Pose) -> Pose:
        x, y, turn = self._rng.standard_normal(3).tolist()
        error, heading_error = self._noise.placement_error, self._noise.placement_heading_error
        return Pose(pose.x + error * x, pose.y + error * y, pose.heading + math.radians(heading_error * turn))
