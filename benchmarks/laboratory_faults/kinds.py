"""The kinds of faults: how each begins, and how it is repaired."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from khepera_forage.cli.train import ATTEMPTS
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.virtual.faults import Faults
from laboratory_faults import virtual_disk
from laboratory_faults.virtual_camera import VirtualCamera

ROBOT, CAMERA, DISK = "robot", "camera", "disk"
_MOMENT = 0.01
"""Seconds: a fault of a line begins within this time, so that it hits any part of a round."""
_LINE_BURST, _CUT, _CAMERA_BURST = (0.05, 0.5), (0.05, 1.5), (0.05, 0.3)
"""Seconds that faults last which pass by themselves."""
_AT_ONCE = (0.0, 0.0)
_SHARE = 0.3
"""Of the replies, in a burst."""
_POLL = 0.0005

Repair = Callable[[], None]


class Target(NamedTuple):
    """What a fault hits.

    Attributes:
        lab: The laboratory.
        camera: Its camera.
        folder: Of the training's files.
        file: The experience file that is being written.
        robot: Number of a robot.
        rng: Draws times.
    """

    lab: VirtualLaboratory
    camera: VirtualCamera
    folder: Path
    file: Path
    robot: int
    rng: np.random.Generator


class Kind(NamedTuple):
    """A kind of fault.

    Attributes:
        name: In the tables.
        part: `ROBOT`, `CAMERA` or `DISK`.
        begin: Begins it; returns what repairs it.
        duration: Shortest and longest time in seconds until it passes by itself; None lasts until it is repaired.
        unreachable: Whether the robot drives on out of reach of its serial line.
        cause: What a message about it must contain, beside the name of the device or file; alternatives separated by
            `|`.
    """

    name: str
    part: str
    begin: Callable[[Target], Repair]
    duration: tuple[float, float] | None = None
    unreachable: bool = False
    cause: str = ""


def _disturbed(faults: Faults) -> Callable[[Target], Repair]:
    def begin(target: Target) -> Repair:
        khepera = target.lab.virtual_kheperas[target.robot]
        khepera.faults = faults

        def repair() -> None:
            khepera.faults = Faults()

        return repair

    return begin


def _restart(target: Target) -> Repair:
    khepera = target.lab.virtual_kheperas[target.robot]
    before = khepera.fault_counts.reset
    khepera.faults = Faults(reset=1.0)

    def until_restarted() -> None:
        while khepera.fault_counts.reset == before and khepera.connected:
            time.sleep(_POLL)
        khepera.faults = Faults()

    threading.Thread(target=until_restarted, daemon=True).start()
    return _nothing


def _restart_without_banner(target: Target) -> Repair:
    target.lab.firmwares[target.robot].power_on()
    return _nothing


def _nothing() -> None: ...


def _cut(target: Target) -> Repair:
    khepera = target.lab.virtual_kheperas[target.robot]
    khepera.interrupted = True

    def repair() -> None:
        khepera.interrupted = False

    return repair


def _without_power(target: Target) -> Repair:
    repair = _cut(target)
    target.lab.firmwares[target.robot].power_on()
    return repair


def _unplugged(target: Target) -> Repair:
    return _disturbed(Faults(unplug=1.0))(target)


def _all_unplugged(target: Target) -> Repair:
    for robot in range(len(target.lab.robots)):
        _unplugged(target._replace(robot=robot))
    return _nothing


def _port_pulled(target: Target) -> Repair:
    target.lab.virtual_kheperas[target.robot].close()
    return _nothing


def _camera(fault: str) -> Callable[[Target], Repair]:
    def begin(target: Target) -> Repair:
        target.camera.fault = fault

        def repair() -> None:
            target.camera.fault = ""

        return repair

    return begin


def _file_limited(target: Target) -> Repair:
    return virtual_disk.limit(target.file, int(target.rng.integers(1, 60)))


_GARBLED = Faults(garble=_SHARE)
_LATE = Faults(delay=_SHARE, lateness=(0.02, 0.2))
_LOST = Faults(drop=_SHARE)
_FULL = "No space left"
KINDS = (
    Kind("restarts", ROBOT, _restart, _AT_ONCE),
    Kind("restarts, banner lost", ROBOT, _restart_without_banner, _AT_ONCE),
    Kind("replies garbled for a while", ROBOT, _disturbed(_GARBLED), _LINE_BURST),
    Kind("replies late for a while", ROBOT, _disturbed(_LATE), _LINE_BURST),
    Kind("replies lost for a while", ROBOT, _disturbed(_LOST), _LINE_BURST),
    Kind("line cut for a while", ROBOT, _cut, _CUT, unreachable=True),
    Kind("all replies garbled", ROBOT, _disturbed(Faults(garble=1.0))),
    Kind("power supply lost", ROBOT, _without_power),
    Kind("cable unplugged", ROBOT, _unplugged),
    Kind("all cables unplugged", ROBOT, _all_unplugged),
    Kind("line cut, robot on its battery", ROBOT, _cut, unreachable=True),
    Kind("port pulled, robot on its battery", ROBOT, _port_pulled, unreachable=True),
    Kind("no frames for a while", CAMERA, _camera("silent"), _CAMERA_BURST),
    Kind("frozen for a while", CAMERA, _camera("frozen"), _CAMERA_BURST),
    Kind("black for a while", CAMERA, _camera("black"), _CAMERA_BURST),
    Kind("overexposed for a while", CAMERA, _camera("overexposed"), _CAMERA_BURST),
    Kind("no frames", CAMERA, _camera("silent"), cause="no frame"),
    Kind("reads fail", CAMERA, _camera("failing"), cause="no more frames"),
    Kind("reads raise errors", CAMERA, _camera("raising"), cause="Assertion failed"),
    Kind("frozen", CAMERA, _camera("frozen"), cause="has not changed"),
    Kind("black", CAMERA, _camera("black"), cause="underexposed|shows nothing"),
    Kind("overexposed", CAMERA, _camera("overexposed"), cause="overexposed"),
    Kind("no signal", CAMERA, _camera("no signal"), cause="underexposed|shows nothing"),
    Kind("another frame size", CAMERA, _camera("resized"), cause="640 x 360"),
    Kind("experience file: disk full", DISK, lambda t: virtual_disk.fill_up(t.file), cause=_FULL),
    Kind("experience file: error", DISK, lambda t: virtual_disk.break_down(t.file), cause="Input/output"),
    Kind("experience file: cut short", DISK, _file_limited, cause="File too large|" + _FULL),
    Kind(
        "attempts.csv: disk full",
        DISK,
        lambda t: virtual_disk.fill_up(t.folder / ATTEMPTS),
        cause=_FULL,
    ),
    Kind(
        "attempts.csv: error",
        DISK,
        lambda t: virtual_disk.break_down(t.folder / ATTEMPTS),
        cause="Input/output",
    ),
    Kind("folder gone", DISK, lambda t: virtual_disk.unmount(t.folder), cause="No such file"),
)


def begin_soon(kind: Kind, target: Target) -> Repair:
    """Begin a fault at a random moment of the next round; a fault of camera or disk begins now.

    Returns:
        What repairs it.
    """
    if kind.part != ROBOT:
        return kind.begin(target)
    repairs: list[Repair] = []
    timer = threading.Timer(float(target.rng.uniform(0, _MOMENT)), lambda: repairs.append(kind.begin(target)))
    timer.start()

    def repair() -> None:
        timer.join()
        repairs[0]()

    return repair
