"""Real Kheperas under a real overhead camera: the `World` in which the thesis' experiments took place."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from typing import Self

import numpy as np

from khepera_forage.lab.clock import Beat, WallBeat
from khepera_forage.lab.devices import open_camera, open_robots
from khepera_forage.lab.food_places import FoodWatch
from khepera_forage.lab.operator import Operator, Prompt, Request, RobotMark
from khepera_forage.lab.settings import LabSettings
from khepera_forage.lab.survey import closed_grippers, own_marker, pose_of, survey
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, Motors, RobotLost, Senses
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.layout_checks import check_apart, check_layout, check_robot, check_seen
from khepera_forage.sim.world import FoodPlace, Layout
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.video import CameraLost, FrameSource

ROUNDS = 30
"""Rounds in which everything may come to be where it should, before the operator is asked again: the camera may lose
a region for half a second, and a gripper takes two to come up and open."""


class Laboratory:
    """Robots on serial ports, each in its own copy of the arena, and one camera above them all.

    A round is: send every robot what it was commanded, wait for the beat, read every robot's sensors, take the newest
    frame. Whatever goes wrong in it, also Ctrl-C, all robots are stopped before anybody hears of it. A robot that was
    lost is looked for again at the next `reset`. Poses and places of food are those that the camera knows.

    Args:
        settings: What a `lab.toml` says.
        operator: Who puts robots and food in their places; by default whoever sits at the command line.
        source: Where frames come from; by default the camera of the settings.
        calibration: Of these frames; by default that of the settings.
        beat: What rounds wait for; by default the wall clock.

    Attributes:
        arenas: Every robot's own.
        markers: Holes of every robot's marker.
        camera: With its tracker.
        beat: Counts the rounds that were over their time.

    Raises:
        RobotLost: A robot does not answer.
        OSError: A port or the camera cannot be opened, or the calibration cannot be read.
        ValueError: The calibration cannot be used.
    """

    def __init__(
        self,
        settings: LabSettings,
        operator: Operator | None = None,
        *,
        source: FrameSource | None = None,
        calibration: Calibration | None = None,
        beat: Beat | None = None,
    ) -> None:
        self.settings = settings
        self.arenas: tuple[Arena, ...] = settings.arenas
        check_seen(self.arenas)
        self.markers = tuple(entry.holes for entry in settings.robots)
        self.beat: Beat = WallBeat(settings.period) if beat is None else beat
        self._operator: Operator = Prompt() if operator is None else operator
        self._ready = self._closed = False
        self._poses = [arena.start for arena in self.arenas]
        self._foods = FoodWatch((), self.arenas)
        self._source, self._calibration = source, calibration
        self._lost = ""
        self.camera = open_camera(settings, source, calibration)
        try:
            self._fleet = open_robots(settings)
        except BaseException:
            self.camera.close()
            raise

    @property
    def robots(self) -> Sequence[SerialKhepera]:
        """The robots, the teacher first."""
        return self._fleet.robots

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """Have the operator put everything in its place, and check by camera that it stands there.

        Args:
            rng: Not used: nothing in a real laboratory comes from a seed.
            layout: One start a robot, in its own arena.

        Raises:
            ValueError: A robot or food that cannot stand where it should; nobody is asked then.
            OperatorGaveUp: The operator will not do it.
            RobotLost, CameraLost: A robot does not answer, or the camera shows nothing new.
            RuntimeError: The laboratory is closed.
        """
        check_layout(self.arenas, layout)
        if self._closed:
            raise RuntimeError("reset() of a closed laboratory; open another")
        self._ready = False
        while self._lost:
            self._operator(Request(f"see to what is lost: {self._lost}", (), None))
            try:
                self._find_again()
            except OSError as error:  # RobotLost is one, and a port or device that is gone
                self._lost = str(error)
        with self._stopping():
            self._fleet.stop()
            for robot in self.robots:
                robot.drive(Motors(0, 0, ARM_RAISED, JAW_OPEN))
            self._fleet.transmit()
            marks = tuple(self._mark(number, pose) for number, pose in enumerate(layout.starts))
            self._arrange(Request("start of an episode", marks, layout.foods))
            self._foods = FoodWatch(layout.foods, self.arenas)
            self._take_in()
        self._ready = True
        self.beat.start()

    def advance(self) -> None:
        """One round.

        Raises:
            RuntimeError: Before the first reset, or after something was lost.
            RobotLost: A robot does not answer; all are stopped.
            CameraLost: The newest frame is too old; all robots are stopped.
        """
        if not self._ready:
            raise RuntimeError("advance() before reset(), or after something was lost; call reset() first")
        with self._stopping():
            self._fleet.transmit()
            self.beat.wait()
            self._fleet.receive()
            self._expose()
            self._take_in()

    def poses(self) -> tuple[Pose, ...]:
        """Where the camera saw each robot last."""
        return tuple(self._poses)

    def food_places(self) -> tuple[FoodPlace, ...]:
        """Where the food was seen last, or the gripper that has it."""
        return self._foods.places()

    def place(self, robot: int, pose: Pose) -> None:
        """Pause, have the operator put a robot down elsewhere, check it by camera, and resume (5.3.1).

        Raises:
            ValueError: It cannot stand there; nobody is asked then.
            OperatorGaveUp: The operator will not do it.
            RobotLost, CameraLost: A robot does not answer, or the camera shows nothing new.
        """
        others = [other for i, other in enumerate(self._poses) if i != robot]
        lying = [
            Point(food.x, food.y)
            for k, food in enumerate(self.food_places())
            if not food.lifted and k != self._foods.held_by(robot)
        ]
        check_robot(self.arenas[robot], pose)
        check_apart(Layout((*others, pose), tuple(lying)))
        with self._stopping():
            self._fleet.stop()
            self._arrange(Request("pause and resume", (self._mark(robot, pose),), None))
            self._take_in()
        self.beat.start()

    def stop(self) -> None:
        """Wheels of all robots to zero, as far as they answer."""
        with suppress(RobotLost):
            self._fleet.stop()

    def close(self) -> None:
        """Stop the robots and let go of them and of the camera; a second call does nothing."""
        if self._closed:
            return
        self._closed, self._ready = True, False
        with closing(self.camera):
            self._fleet.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _find_again(self) -> None:
        """Take hold of everything anew, once something was lost."""
        self._fleet.close()
        if self._source is None:  # one that was given is its giver's to replace
            self.camera.close()
            self.camera = open_camera(self.settings, None, self._calibration)
        self._fleet = open_robots(self.settings)
        self._lost = ""

    def _mark(self, number: int, pose: Pose) -> RobotMark:
        entry = self.settings.robots[number]
        return RobotMark(number, entry.name, entry.holes, pose)

    @contextmanager
    def _stopping(self) -> Iterator[None]:
        """Whatever goes wrong inside, stop everybody first."""
        try:
            yield
        except BaseException as error:
            self._ready = False
            if isinstance(error, RobotLost | CameraLost):
                self._lost = str(error)
            self.stop()
            raise

    def _arrange(self, request: Request) -> None:
        """Ask the operator until the camera sees everything in its place."""
        anew = request.foods is not None
        while True:
            self._operator(request)
            self.beat.start()
            for _ in range(ROUNDS):
                self.beat.wait()
                self._fleet.receive()
                # What passed through the picture while the operator worked starts no track in a new episode.
                self._expose(anew)
                scene = self.camera.look()
                wrong = survey(scene, self.arenas, request.robots, request.foods, self.settings.tolerance)
                if anew:
                    wrong += closed_grippers(request.robots, self._senses())
                if not wrong:
                    return
            request = request._replace(wrong=wrong)

    def _expose(self, anew: bool = False) -> None:
        """Take the newest frame; `anew` forgets all tracks before."""
        if anew:
            self.camera.reset()
        else:
            self.camera.expose()
        age, oldest = self.camera.age, self.settings.camera.oldest
        if age > oldest:
            raise CameraLost(str(self.settings.camera.source), f"no frame for {oldest:g} s", age)

    def _take_in(self) -> None:
        """Where everything is now."""
        scene = self.camera.look()
        for number, (arena, holes) in enumerate(zip(self.arenas, self.markers, strict=True)):
            region = own_marker(scene, arena, holes)
            if region is not None:
                self._poses[number] = pose_of(region)
        self._foods.update(scene, list(zip(self._poses, self._senses(), strict=True)))

    def _senses(self) -> list[Senses]:
        return [robot.sense() for robot in self.robots]
