"""Real robots under an overhead camera, or on a mat: the `World` of the thesis's experiments."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from typing import Self

import numpy as np

from khepera_forage.lab.clock import WallClock
from khepera_forage.lab.cubes import CubeOperator, MatCamera
from khepera_forage.lab.devices import FreshFrames, calibration_of, open_video
from khepera_forage.lab.localisation import FoodLocator, find_marker, gripper_errors, placement_errors, pose_of
from khepera_forage.lab.operator import Operator, OperatorRequest, RobotMark, ask_person
from khepera_forage.lab.settings_file import LabSettings
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, Motors, RobotLost
from khepera_forage.robots.mat import MatRobot
from khepera_forage.robots.real_robot import Fleet, RealRobot, stop_all, stop_and_log
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.layout_checks import check_apart, check_layout, check_robot, check_seen
from khepera_forage.sim.records import FoodState, RobotState, constants_of
from khepera_forage.sim.sensing import sense
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.sim.world import FoodPlace, Layout, Timing
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.tracker import TrackedCamera, Tracker
from khepera_forage.vision.video import CameraLost, FrameSource

CHECK_ROUNDS = 30
"""Rounds before a failed check goes back to the operator: a gripper takes two seconds to rise and open."""


class Laboratory:
    """Robots, each in its own copy of the arena, under one camera or on a mat.

    One round: send all commands, wait for the clock, read all sensors, take the newest frame. Any exception in a round,
    including Ctrl-C, first stops all robots and is then raised. `reset` reconnects a robot that was lost. The poses and
    the positions of food are those seen by the camera.

    Args:
        settings: The contents of a `lab.toml`.
        operator: Places robots and food; by default a person at the command line, or the cubes themselves if robots and
            food are toio cubes.
        source: Opens the source of the frames, again after a loss; the camera of the settings by default.
        calibration: Calibration of the frames; the one of the settings by default.
        clock: Ends the rounds; the wall clock by default.

    Attributes:
        arenas: The arena of every robot.
        markers: Number of holes of every robot's marker.
        round_duration: Seconds of one round, the period of the settings.
        camera: With its tracker, or the mat of toio cubes; another one after a loss.
        clock: Also counts the rounds that overran.

    Raises:
        RobotLost: A robot does not reply.
        OSError: A port or the camera cannot be opened, or the calibration cannot be read.
        ValueError: The calibration is invalid.
    """

    def __init__(
        self,
        settings: LabSettings,
        operator: Operator | None = None,
        *,
        source: Callable[[], FrameSource] | None = None,
        calibration: Calibration | None = None,
        clock: WallClock | None = None,
    ) -> None:
        self.settings = settings
        self.arenas: tuple[Arena, ...] = settings.arenas
        check_seen(self.arenas)
        self.round_duration = settings.period
        self.markers = tuple(entry.holes for entry in settings.robots)
        self.clock = WallClock(settings.period) if clock is None else clock
        self._ready = self._closed = False
        self._poses = [arena.start for arena in self.arenas]
        self._foods = FoodLocator((), self.arenas)
        self._lost = ""
        self._source, self._calibration = source, calibration
        self.camera: TrackedCamera | MatCamera
        self._frames: FreshFrames | MatCamera
        self._open()
        if operator is None and settings.food_cubes:
            operator = CubeOperator(self._cubes, self._food_cubes, self.arenas)
        self._operator: Operator = ask_person if operator is None else operator

    @property
    def robots(self) -> Sequence[RealRobot]:
        """The robots, the teacher first."""
        return self._fleet.robots

    @property
    def port_urls(self) -> tuple[str, ...]:
        """The ports of the robots, as opened by the drivers."""
        return tuple(robot.port for robot in self.robots)

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Let the operator place everything, and check the result by camera.

        Args:
            rng: Not used: nothing in a real laboratory depends on a seed.
            layout: One start per robot, in its own arena.

        Raises:
            ValueError: The layout is not possible; raised before the operator is involved.
            OperatorGaveUp: The operator declines.
            RobotLost, CameraLost: A robot does not reply, or the camera sends no new frame.
            RuntimeError: The laboratory is closed.
        """
        check_layout(self.arenas, layout)
        if self._closed:
            raise RuntimeError("reset() of a closed laboratory; open another")
        self._ready = False
        while self._lost:
            self._operator(OperatorRequest(f"reconnect what was lost: {self._lost}", (), None))
            try:
                self._fleet.close(report=False)
                self.camera.close()
                self._open()
                self._lost = ""
            except (OSError, ValueError) as error:  # includes RobotLost, and a camera with other frames
                self._lost = str(error)
        with self._stopping():
            self._fleet.stop()
            for cube in self._cubes:
                cube.clearance = None  # the operator may drive it anywhere
            for robot in self.robots:
                robot.drive(Motors(0, 0, ARM_RAISED, JAW_OPEN))
            self._fleet.transmit()
            marks = tuple(self._mark(number, pose) for number, pose in enumerate(layout.starts))
            self._frames.forget()
            self._place(OperatorRequest("start of an episode", marks, layout.foods))
            self._foods = FoodLocator(layout.foods, self.arenas)
            self._update_positions()
            for cube, arena in zip(self._cubes, self.arenas, strict=False):
                cube.clearance = lambda x, y, arena=arena: arena.clearance(Point(x, y))
        self._ready = True
        self.clock.start()

    def advance(self) -> None:
        """Run one round.

        Raises:
            RuntimeError: Before the first reset, or after a loss.
            RobotLost: A robot does not reply; all robots are stopped.
            CameraLost: The newest frame is too old; all robots are stopped.
        """
        if not self._ready:
            raise RuntimeError("advance() before reset(), or after a loss; call reset() first")
        with self._stopping():
            self._frames.begin_round()
            self._fleet.transmit()
            self.clock.wait()
            self._fleet.receive()
            self.camera.expose()
            self._update_positions()

    def poses(self) -> tuple[Pose, ...]:
        """The last pose of each robot that the camera has seen."""
        return tuple(self._poses)

    def food_places(self) -> tuple[FoodPlace, ...]:
        """The last position of each food object that the camera has seen, or of the gripper that holds it."""
        return tuple(self._foods.places)

    def place(self, robot: int, pose: Pose) -> None:
        """Pause, let the operator move a robot, check its pose by camera, and resume (5.3.1).

        Raises:
            ValueError: The pose is not possible; raised before the operator is involved.
            OperatorGaveUp: The operator declines.
            RobotLost, CameraLost: A robot does not reply, or the camera sends no new frame.
        """
        others = [other for i, other in enumerate(self._poses) if i != robot]
        foods_on_floor = [
            Point(food.x, food.y)
            for k, food in enumerate(self.food_places())
            if not food.lifted and k != self._foods.held.get(robot)
        ]
        check_robot(self.arenas[robot], pose)
        check_apart(Layout((*others, pose), tuple(foods_on_floor)))
        with self._stopping():
            self._fleet.stop()
            self._frames.forget()
            self._place(OperatorRequest("pause and resume", (self._mark(robot, pose),), None))
            self._update_positions()
        self.clock.start()

    def stop(self) -> None:
        """Stop the wheels of all robots; those that may still be moving are logged."""
        stop_and_log(self._fleet.robots, "at the end of the episode")

    def close(self) -> None:
        """Stop the robots and close all ports and the camera; a second call does nothing."""
        if self._closed:
            return
        self._closed, self._ready = True, False
        with closing(self.camera):
            self._fleet.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _open(self) -> None:
        """Open robots and camera, or the cubes on a mat; if one fails, close the others."""
        settings = self.settings
        with ExitStack() as opened:
            robots = [opened.enter_context(r.open(settings.period, settings.safe_speed)) for r in settings.robots]
            self._fleet = Fleet(robots)
            self._cubes = [robot for robot in robots if isinstance(robot, MatRobot)]
            foods = [opened.enter_context(r.open(settings.period, settings.safe_speed)) for r in settings.food_robots]
            self._food_cubes = [food for food in foods if isinstance(food, MatRobot)]
            if settings.has_mat:
                self._frames = self.camera = MatCamera(self._cubes, self.markers, self._food_cubes)
            else:
                calibration = self._calibration or calibration_of(settings)
                tracker = Tracker(settings.tracker, calibration)
                source = open_video(settings, calibration) if self._source is None else self._source()
                self._frames = FreshFrames(source, tracker, settings, self._pulses, self._fleet.stop)
                self.camera = TrackedCamera(self._frames, tracker)
            opened.pop_all()

    def _pulses(self) -> list[int]:
        return [count for robot in self.robots for count in robot.sense()[1:3]]

    def _mark(self, number: int, pose: Pose) -> RobotMark:
        entry = self.settings.robots[number]
        return RobotMark(number, entry.name, entry.holes, pose)

    @contextmanager
    def _stopping(self) -> Iterator[None]:
        """Stop all robots on any exception."""
        try:
            yield
        except BaseException as error:
            self._ready = False
            stop_all(self.robots)
            moving = [robot.port for robot in self.robots if not robot.stop_confirmed]
            if moving:  # the same message tells it: a second one would be overlooked
                message = f"{error}; {', '.join(moving)} may still be moving: switch it off"
                error.args = (message,)
            if isinstance(error, RobotLost | CameraLost):
                self._lost = str(error)
            raise

    def _place(self, request: OperatorRequest) -> None:
        """Repeat a request to the operator until the camera sees everything in its place."""
        new_episode = request.foods is not None
        while True:
            self._operator(request)
            self.clock.start()
            for _ in range(CHECK_ROUNDS):
                self._frames.begin_round()
                self.clock.wait()
                self._fleet.receive()
                # No track of a hand that passed through the picture may continue in a new episode.
                if new_episode:
                    self.camera.reset()
                else:
                    self.camera.expose()
                scene, tolerance = self.camera.look(), self.settings.tolerance
                errors = placement_errors(scene, self.arenas, request.robots, request.foods, tolerance)
                if new_episode:
                    errors += gripper_errors(request.robots, self.robots)
                if not errors:
                    return
            request = request._replace(errors=errors)

    def _update_positions(self) -> None:
        scene = self.camera.look()
        for number, (arena, holes) in enumerate(zip(self.arenas, self.markers, strict=True)):
            region = find_marker(scene, arena, holes)
            if region is not None:
                self._poses[number] = pose_of(region)
        for robot in self.robots:
            robot.sense()  # reads those that have not been read yet
        self._foods.update(scene, list(zip(self._poses, self.robots, strict=True)))
        # Tell robots with fewer sensors than a Khepera what the map shows.
        foods = [FoodState(food.x, food.y) for food in self.food_places()]
        states = [
            RobotState(*pose, math.cos(pose.heading), math.sin(pose.heading), has_gripper=False) for pose in self._poses
        ]
        timing = Timing(self.round_duration, 0.0, 0.0)
        for number, (robot, arena) in enumerate(zip(self.robots, self.arenas, strict=True)):
            if not robot.model.has_gripper:
                constants = constants_of(Noise.none(), timing, model=robot.model)
                sense(states, number, foods, arena.wall_records, constants)
                shown = SimulatedKhepera(states, number).sense()
                proximity = None if robot.model.infra_reds else shown.proximity
                robot.note_surroundings(shown.object_presence != 0, proximity)
