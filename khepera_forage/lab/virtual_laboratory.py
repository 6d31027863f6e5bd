"""A laboratory without hardware: real drivers and a real tracker, on bytes and pixels of a simulated world."""

import math
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Self

import numpy as np

from khepera_forage.lab.clock import WallBeat
from khepera_forage.lab.laboratory import Laboratory
from khepera_forage.lab.operator import Operator
from khepera_forage.lab.settings import CameraSettings, LabSettings, RobotSettings
from khepera_forage.lab.virtual_operator import VirtualOperator
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.virtual.faults import Faults
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from khepera_forage.sim.arena import ARENAS, Arena, Point, copies
from khepera_forage.sim.layout_checks import cable_anchor, check_layout
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.frames import FrameRenderer, RenderedFrameSource
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH


class VirtualLaboratory(Laboratory):
    """A `Laboratory` whose devices are virtual.

    Every robot is a simulated body with the Khepera's ROM in front of it (`Firmware`), on a pty of its own; the
    camera's frames are rendered from where the bodies are; the operator is simulated. All else is the laboratory's
    own: driver, protocol, fleet, tracker, checks.

    By default time is lock-step: the beat moves the bodies on by one period instead of waiting for the wall clock, as
    fast as the machine goes. The same seed and layout then give the same observations, bit for bit, as long as no
    fault is switched on and the machine answers within the driver's time limits. Encoder counters go on from one
    episode to the next, as a real robot's do.

    Args:
        settings: Arena, robots, tolerance and tracker; ports, camera source and calibration are replaced.
        noise: Of bodies and operator; the camera's troubles are those of `look`. By default the laboratory's.
        look: Of the frames; by default the laboratory's.
        paced: Whether bytes take the time on the wire that each robot's baud rate says.
        faults: Of the lines, for all robots or one each.
        fault_seed: Draws when faults happen.
        real_time: Keep the wall clock too.
        operator: Who is asked instead of `hand`, for example a person who has `hand` do it.

    Raises:
        ValueError: A period that is no multiple of the simulation's 0.1 s, or not as many faults as robots.

    Attributes:
        bodies: The simulated world, in which the truth is known.
        ports: The robots' ends of the lines.
        frames: Where the camera's frames come from.
        hand: Puts the bodies where it is told.
    """

    def __init__(
        self,
        settings: LabSettings,
        *,
        noise: Noise | None = None,
        look: CameraAppearance | None = None,
        paced: bool = False,
        faults: Faults | Sequence[Faults | None] | None = None,
        fault_seed: int = 0,
        real_time: bool = False,
        operator: Operator | None = None,
    ) -> None:
        noise = Noise.laboratory() if noise is None else noise
        look = CameraAppearance.laboratory() if look is None else look
        arenas = settings.arenas
        self._steps = round(settings.period / CONTROL_PERIOD)
        if not math.isclose(self._steps * CONTROL_PERIOD, settings.period):
            raise ValueError(
                f"period is {settings.period:g} s; allowed in a virtual laboratory: multiples of {CONTROL_PERIOD:g} s"
            )
        self.bodies = PymunkWorld(arenas, [robot.holes for robot in settings.robots], noise)
        self.bodies.reset(np.random.default_rng(fault_seed), _on_the_marks(arenas))
        # The same lock for all: they stand in front of one simulated world.
        self._lock = threading.RLock()
        self._firmwares = [Firmware(body, self._lock) for body in self.bodies.robots]
        self._renderer = FrameRenderer(
            self.bodies.truth,
            look,
            cable_anchor(arenas),
            walls=[wall for arena in arenas for wall in arena.segments],
            period=settings.period,
        )
        self.frames = RenderedFrameSource(self._renderer)
        self.hand = VirtualOperator(self.bodies, noise, self._attach, self._plug_in)
        each = list(faults) if isinstance(faults, Sequence) else [faults] * len(settings.robots)
        if len(each) != len(settings.robots):
            raise ValueError(f"{len(each)} faults for {len(settings.robots)} robots; allowed: one each")
        draws = np.random.default_rng(fault_seed).spawn(len(settings.robots))
        self._lines = [
            (robot.baud if paced else None, fault, rng)
            for robot, fault, rng in zip(settings.robots, each, draws, strict=True)
        ]
        self.ports: list[VirtualKhepera] = []
        calibration = None
        if look.height is not None:
            middle = PICTURE_WIDTH / 2 * MM_PER_PIXEL, PICTURE_HEIGHT / 2 * MM_PER_PIXEL
            calibration = Calibration.identity((*middle, look.height))
        with ExitStack() as opened:
            opened.callback(self._unplug)
            settings = self._plugged_in(settings)
            super().__init__(
                settings,
                self.hand if operator is None else operator,
                source=self.frames,
                calibration=calibration,
                beat=VirtualBeat(self._step, WallBeat(settings.period) if real_time else None),
            )
            opened.pop_all()

    @classmethod
    def of(cls, arena: Arena | str = "corridor", robots: int = 2, **options: object) -> Self:
        """A laboratory of copies of one arena side by side.

        Args:
            arena: One of one's own, whose first copy stands where it stands; or the name of one of the thesis', whose
                copies stand in the middle of the picture, for at its border markers that reach over a wall are cut.
            robots: The teacher and its learners; one alone is a learner.
            **options: Those of the class.
        """
        original = ARENAS[arena] if isinstance(arena, str) else arena
        arenas = copies(original, robots)
        dx = dy = 0.0
        if isinstance(arena, str):
            middle_x, middle_y = cable_anchor(arenas)
            dx, dy = PICTURE_WIDTH * MM_PER_PIXEL / 2 - middle_x, PICTURE_HEIGHT * MM_PER_PIXEL / 2 - middle_y
        entries = tuple(
            RobotSettings(
                port="virtual",
                name="teacher" if i == 0 and robots > 1 else f"learner_{max(0, i - 1)}",
                holes=1 if i == 0 and robots > 1 else 2,
                offset=Point(copy.home.x - original.home.x + dx, copy.home.y - original.home.y + dy),
            )
            for i, copy in enumerate(arenas)
        )
        settings = LabSettings(original, entries, CameraSettings("rendered frames"))
        return cls(settings, **options)  # type: ignore[arg-type] # as the class takes them

    @property
    def urls(self) -> tuple[str, ...]:
        """Where the robots' drivers find them."""
        return tuple(port.url for port in self.ports)

    def reset(self, rng: np.random.Generator, layout: Layout) -> None:
        """As in any laboratory; bodies, light, cables and the operator's hand draw from `rng`."""
        check_layout(self.arenas, layout)
        bodies, light, hand = rng.spawn(3)
        self._renderer.reset(light)
        self.hand.begin(hand, bodies)
        super().reset(rng, layout)

    def close(self) -> None:
        """Stop the robots and switch everything off; a second call does nothing."""
        with ExitStack() as rest:
            rest.callback(self._unplug)
            super().close()

    def _step(self) -> None:
        with self._lock:
            for _ in range(self._steps):
                self.bodies.advance()
                for firmware in self._firmwares:
                    firmware.tick()

    def _attach(self) -> None:
        for firmware, body in zip(self._firmwares, self.bodies.robots, strict=True):
            firmware.attach(body)

    def _plugged_in(self, settings: LabSettings) -> LabSettings:
        """The settings with the present ports, once every robot that is unplugged has been plugged in."""
        for i, (firmware, (baud, faults, rng)) in enumerate(zip(self._firmwares, self._lines, strict=True)):
            if i == len(self.ports) or not self.ports[i].connected:
                for unplugged in self.ports[i : i + 1]:
                    unplugged.close()
                self.ports[i : i + 1] = [VirtualKhepera(firmware, baud=baud, faults=faults, rng=rng)]
        robots = [replace(robot, port=url) for robot, url in zip(settings.robots, self.urls, strict=True)]
        return replace(settings, robots=tuple(robots))

    def _plug_in(self) -> None:
        self.settings = self._plugged_in(self.settings)

    def _unplug(self) -> None:
        while self.ports:
            self.ports.pop().close()


class VirtualBeat:
    """The beat of a virtual laboratory: what waits for the end of a round makes it happen.

    Args:
        step: Moves the simulated world on by one period.
        wall: Waited for first, to keep the wall clock; None goes as fast as the machine does.
    """

    def __init__(self, step: Callable[[], None], wall: WallBeat | None = None) -> None:
        self.rounds = 0
        self._step, self._wall = step, wall

    @property
    def overruns(self) -> int:
        """Rounds that were over their time on the wall clock; none without one."""
        return 0 if self._wall is None else self._wall.overruns

    @property
    def worst(self) -> float:
        """The longest of these overruns in seconds."""
        return 0.0 if self._wall is None else self._wall.worst

    def start(self) -> None:
        """The first round begins now."""
        if self._wall is not None:
            self._wall.start()

    def wait(self) -> None:
        """Wait for the wall clock, if asked for; then a round has passed for the simulated world."""
        self.rounds += 1
        if self._wall is not None:
            self._wall.wait()
        self._step()


def _on_the_marks(arenas: Sequence[Arena]) -> Layout:
    return Layout(
        tuple(arena.start for arena in arenas), tuple(food for arena in arenas for food in arena.foods)
    )
