"""A virtual laboratory without noise, and an operator that makes mistakes."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.lab.operator import OperatorRequest
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.arena import Arena, Pose, copies
from khepera_forage.sim.world import Layout
from khepera_forage.vision.rendering import CameraAppearance
from tests.version_0_1 import CORRIDOR, V0_1

ARENAS = copies(CORRIDOR, 2)
QUIET: dict[str, Any] = {"noise": Noise.none(), "appearance": CameraAppearance.none()}


def layout_of(arenas: Sequence[Arena]) -> Layout:
    """The usual places of robots and food."""
    return Layout(tuple(arena.start for arena in arenas), tuple(food for arena in arenas for food in arena.foods))


LAYOUT = layout_of(ARENAS)


class Time:
    """Time that passes only in `sleep`, or when a test changes `now`."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0
        self.now += seconds


class ClumsyOperator:
    """An operator that makes mistakes in the first requests.

    Args:
        *errors: Functions that change the first requests, one each; later requests are carried out unchanged.
    """

    def __init__(self, *errors: Callable[[OperatorRequest], OperatorRequest]) -> None:
        self.errors = list(errors)
        self.requests: list[OperatorRequest] = []
        self.lab: VirtualLaboratory

    def __call__(self, request: OperatorRequest) -> None:
        self.requests.append(request)
        self.lab.virtual_operator(self.errors.pop(0)(request) if self.errors else request)


def quiet_laboratory(operator: ClumsyOperator | None = None, **options: Any) -> VirtualLaboratory:
    lab = virtual_laboratory(CORRIDOR, 2, V0_1, operator=operator, **QUIET, **options)
    if operator is not None:
        operator.lab = lab
    return lab


def moved(request: OperatorRequest, robot: int, dx: float = 0, dy: float = 0, degrees: float = 0) -> OperatorRequest:
    marks = list(request.robots)
    x, y, heading = marks[robot].pose
    marks[robot] = marks[robot]._replace(pose=Pose(x + dx, y + dy, heading + math.radians(degrees)))
    return request._replace(robots=tuple(marks))


def is_stopped(lab: VirtualLaboratory) -> bool:
    """Whether no wheel of any robot is commanded to turn."""
    return not any(firmware.turning for firmware in lab.firmwares)


def drive_all(lab: VirtualLaboratory) -> None:
    for robot in lab.robots:
        robot.drive(Motors(5, 5, 215, 200))
    lab.advance()
    assert not is_stopped(lab)
