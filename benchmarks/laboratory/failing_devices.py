"""Devices of the virtual laboratory that fail: lines, a camera below OpenCV, and a disk below Python."""

import os
import resource
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.cli.train import ATTEMPTS
from khepera_forage.envs.arguments import timing_of
from khepera_forage.envs.laboratories import load_settings
from khepera_forage.lab.operator import Operator
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.serial.line import LineTooSlow
from khepera_forage.robots.virtual.virtual_khepera import Faults
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.vision.video import VideoSource

ROBOT, CAMERA, DISK = "robot", "camera", "disk"
FRAME_INTERVAL = 0.02
"""Seconds: 50 frames a second."""
_DEVICE = 0
_OFFSETS = ((1275, 785), (1275, 1085), (1275, 1385))
"""mm: corridors side by side in the middle of the picture."""
_MOMENT = 0.01
"""Seconds: a fault of a line begins within this time, so that it hits any part of a round."""
_AT_ONCE, _LINE_BURST, _CUT, _CAMERA_BURST = (0.0, 0.0), (0.05, 0.5), (0.05, 1.5), (0.05, 0.3)
"""Seconds that faults last which pass by themselves."""
_SHARE = 0.3
"""Of the replies, in a burst."""
Repair = Callable[[], object]


class VirtualCamera:
    """A camera that shows the last frame given to `expose`, with new sensor noise in every frame that is read.

    Attributes:
        fault: `silent`, `failing`, `raising`, `frozen`, `black`, `overexposed`, `no signal`, `resized`, or empty. May
            be set at any time.
    """

    def __init__(self) -> None:
        self.fault = ""
        self.changed = threading.Condition()
        self.exposures = 0
        self.shown = 0
        """Number of the newest exposure that a reader has finished with."""
        self._picture = np.full((480, 640), 110, np.uint8)
        self._noise = np.random.default_rng(0).integers(0, 2, self._picture.shape, np.uint8)
        self._reads = 0
        self._frozen = self._picture

    def expose(self, picture: NDArray[np.uint8]) -> None:
        """Show a new picture; returns when it has been read, or cannot be."""
        with self.changed:
            self._picture = picture
            self.exposures += 1
            number = self.exposures
            self.changed.notify_all()
            if self.fault not in ("silent", "failing", "raising"):
                self.changed.wait_for(lambda: self.shown >= number, 0.1)

    def picture(self) -> NDArray[np.uint8]:
        """The next frame, with the present fault."""
        self._reads += 1
        noisy: NDArray[np.uint8] = self._picture ^ np.roll(self._noise, 641 * self._reads)
        if self.fault == "frozen":
            return self._frozen
        self._frozen = noisy
        faulty: dict[str, Callable[[], Any]] = {
            "black": lambda: noisy >> 5,
            "overexposed": lambda: cv2.add(noisy, noisy),
            "no signal": lambda: (noisy & 1) + 16,
            "resized": lambda: np.ascontiguousarray(noisy[:360]),
        }
        return np.asarray(faulty[self.fault](), np.uint8) if self.fault in faulty else noisy


class _Capture:
    """The part of `cv2.VideoCapture` that a frame source uses."""

    def __init__(self, camera: VirtualCamera) -> None:
        self._camera = camera
        self._open = camera.fault not in ("failing", "raising")
        self._read_until = 0

    def isOpened(self) -> bool:  # noqa: N802 (OpenCV's name)
        return self._open

    def get(self, what: int) -> float:
        return 1 / FRAME_INTERVAL  # the only property that is read

    def set(self, what: int, value: float) -> bool:
        return False

    def release(self) -> None:
        self._open = False

    def read(self) -> tuple[bool, Any]:
        camera = self._camera
        with camera.changed:
            camera.shown = max(camera.shown, self._read_until)
            camera.changed.notify_all()
            camera.changed.wait_for(lambda: camera.exposures > self._read_until, FRAME_INTERVAL)
            while camera.fault == "silent" and self._open:
                camera.changed.wait(FRAME_INTERVAL)
            if camera.fault == "raising":
                raise cv2.error("(-215:Assertion failed) !image.empty() in function 'retrieve'")
            if camera.fault == "failing" or not self._open:
                return False, None
            self._read_until = camera.exposures
            return True, cv2.cvtColor(camera.picture(), cv2.COLOR_GRAY2BGR)


def write_lab_file(folder: Path) -> Path:
    """Write a `lab.toml` with three robots and a camera."""
    robots = "".join(f'[[robots]]\nport = "port_{i}"\noffset = [{x}, {y}]\n' for i, (x, y) in enumerate(_OFFSETS))
    path = folder / "lab.toml"
    path.write_text(f"[camera]\nsource = {_DEVICE}\n{robots}", encoding="utf-8")
    return path


@contextmanager
def laboratory(path: Path, operator: Operator, seed: int) -> Iterator[tuple[VirtualLaboratory, VirtualCamera]]:
    """The laboratory of a `lab.toml`, with the drivers, video source and tracker of real robots.

    The operator places the simulated bodies, and repairs what is lost; the seed is that of the faults of the lines.
    """
    camera = VirtualCamera()
    # OpenCV is below our code: the video source itself is the real one.
    with patch.object(cv2, "VideoCapture", lambda _: _Capture(camera)), _opened(path, operator, seed) as lab:
        wait = lab.clock.wait

        def wait_and_expose() -> None:
            wait()
            camera.expose(lab.frame_source.newest()[0])

        with patch.object(lab.clock, "wait", wait_and_expose):
            yield lab, camera


def _opened(path: Path, operator: Operator, seed: int) -> VirtualLaboratory:
    """Open all devices; again, if a busy machine lets the line to a virtual robot appear too slow."""
    timing = timing_of(DEFAULT_DECISIONS)
    while True:
        with suppress(LineTooSlow):
            return VirtualLaboratory(
                load_settings(path),
                arm_speed=timing.arm_speed,
                jaw_speed=timing.jaw_speed,
                operator=operator,
                camera=lambda _: VideoSource(_DEVICE),
                fault_seed=seed,
            )


class Target(NamedTuple):
    """What a fault hits: a robot by its number, the camera, or the files of a training; `rng` draws times."""

    lab: VirtualLaboratory
    camera: VirtualCamera
    folder: Path
    file: Path
    robot: int
    rng: np.random.Generator


class Kind(NamedTuple):
    """A kind of fault of a part of the laboratory; `begin` returns what repairs it.

    Attributes:
        duration: Shortest and longest time in seconds until it passes by itself; None lasts until it is repaired.
        unreachable: Whether the robot drives on out of reach of its serial line.
        cause: What a message about it must contain, beside the name of the device or file; `|` separates alternatives.
    """

    name: str
    part: str
    begin: Callable[[Target], Repair]
    duration: tuple[float, float] | None = None
    unreachable: bool = False
    cause: str = ""


def begin_soon(kind: Kind, target: Target) -> Repair:
    """Begin a fault of a robot at a random moment of the next round, others now; returns what repairs it."""
    if kind.part != ROBOT:
        return kind.begin(target)
    repairs: list[Repair] = []
    timer = threading.Timer(float(target.rng.uniform(0, _MOMENT)), lambda: repairs.append(kind.begin(target)))
    timer.start()

    def repair() -> None:
        timer.join()
        repairs[0]()

    return repair


def _changed(of: Callable[[Target], object], name: str, value: object, usual: object) -> Callable[[Target], Repair]:
    """A fault that sets an attribute, and whose repair sets it to its usual value."""

    def begin(target: Target) -> Repair:
        device = of(target)
        setattr(device, name, value)
        return lambda: setattr(device, name, usual)

    return begin


def _line(faults: Faults) -> Callable[[Target], Repair]:
    return _changed(lambda target: target.lab.virtual_kheperas[target.robot], "faults", faults, Faults())


def _camera(fault: str) -> Callable[[Target], Repair]:
    return _changed(lambda target: target.camera, "fault", fault, "")


_cut = _changed(lambda target: target.lab.virtual_kheperas[target.robot], "interrupted", True, False)


def _restart(target: Target) -> Repair:
    khepera = target.lab.virtual_kheperas[target.robot]
    before = khepera.fault_counts["reset"]
    khepera.faults = Faults(reset=1.0)

    def until_restarted() -> None:
        while khepera.fault_counts["reset"] == before and khepera.connected:
            time.sleep(0.0005)
        khepera.faults = Faults()

    threading.Thread(target=until_restarted, daemon=True).start()
    return lambda: None


def _restart_without_banner(target: Target) -> Repair:
    target.lab.firmwares[target.robot].power_on()
    return lambda: None


def _without_power(target: Target) -> Repair:
    repair = _cut(target)
    target.lab.firmwares[target.robot].power_on()
    return repair


def _all_unplugged(target: Target) -> Repair:
    for khepera in target.lab.virtual_kheperas:
        khepera.faults = Faults(unplug=1.0)
    return lambda: None


def _port_pulled(target: Target) -> Repair:
    target.lab.virtual_kheperas[target.robot].close()
    return lambda: None


def _full(path: Path) -> Repair:
    """Every write to an open file fails: no space left (ENOSPC)."""
    return _redirected(path, os.open("/dev/full", os.O_WRONLY))


def _broken(path: Path) -> Repair:
    """Every write to an open file fails: input/output error (EIO)."""
    master, slave = os.openpty()
    os.close(master)
    return _redirected(path, slave)


def _limited(target: Target) -> Repair:
    """The file takes a few more bytes, so that a line is cut in two; then it is too large (EFBIG)."""
    # Python ignores the signal already; a process that resets it would end.
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    usual, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    size = target.file.stat().st_size + int(target.rng.integers(1, 60))
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (usual, hard))


def _folder_gone(target: Target) -> Repair:
    """The folder is gone; files that are open stay open."""
    away = target.folder.with_name(f"{target.folder.name}.away")
    target.folder.rename(away)
    return lambda: away.replace(target.folder)


def _redirected(path: Path, target: int) -> Repair:
    """Let the open descriptors of a file refer to another one, which is closed by the returned function."""
    wanted, found = os.fstat(target), list[int]()
    for name in os.listdir("/proc/self/fd"):
        with suppress(OSError):  # the descriptor of the listing itself
            if os.readlink(f"/proc/self/fd/{name}") == str(path):
                found.append(int(name))
    # All are found before any is copied: a copy may get the number of the descriptor of the listing.
    kept = [(descriptor, os.dup(descriptor)) for descriptor in found]
    for descriptor, _ in kept:
        os.dup2(target, descriptor)

    def restore() -> None:
        for descriptor, original in kept:
            # A closed descriptor may have another file by now.
            with suppress(OSError):
                now = os.fstat(descriptor)
                if (now.st_dev, now.st_ino) == (wanted.st_dev, wanted.st_ino):
                    os.dup2(original, descriptor)
            os.close(original)
        os.close(target)

    return restore


_NO_SPACE, _INPUT_OUTPUT = "No space left", "Input/output"
KINDS = (
    Kind("restarts", ROBOT, _restart, _AT_ONCE),
    Kind("restarts, banner lost", ROBOT, _restart_without_banner, _AT_ONCE),
    Kind("replies garbled for a while", ROBOT, _line(Faults(garble=_SHARE)), _LINE_BURST),
    Kind("replies late for a while", ROBOT, _line(Faults(delay=_SHARE, lateness=(0.02, 0.2))), _LINE_BURST),
    Kind("replies lost for a while", ROBOT, _line(Faults(drop=_SHARE)), _LINE_BURST),
    Kind("line cut for a while", ROBOT, _cut, _CUT, unreachable=True),
    Kind("all replies garbled", ROBOT, _line(Faults(garble=1.0))),
    Kind("power supply lost", ROBOT, _without_power),
    Kind("cable unplugged", ROBOT, _line(Faults(unplug=1.0))),
    Kind("all cables unplugged", ROBOT, _all_unplugged),
    Kind("line cut, robot on its battery", ROBOT, _cut, unreachable=True),
    Kind("port pulled, robot on its battery", ROBOT, _port_pulled, unreachable=True),
    Kind("no frames for a while", CAMERA, _camera("silent"), _CAMERA_BURST),
    Kind("frozen for a while", CAMERA, _camera("frozen"), _CAMERA_BURST),
    Kind("black for a while", CAMERA, _camera("black"), _CAMERA_BURST),
    Kind("overexposed for a while", CAMERA, _camera("overexposed"), _CAMERA_BURST),
    Kind("no frames", CAMERA, _camera("silent"), cause="no frame"),
    Kind("reads fail", CAMERA, _camera("failing"), cause="no frame|no more frames"),
    Kind("reads raise errors", CAMERA, _camera("raising"), cause="Assertion failed"),
    Kind("frozen", CAMERA, _camera("frozen"), cause="has not changed"),
    Kind("black", CAMERA, _camera("black"), cause="underexposed|shows nothing"),
    Kind("overexposed", CAMERA, _camera("overexposed"), cause="overexposed"),
    Kind("no signal", CAMERA, _camera("no signal"), cause="underexposed|shows nothing"),
    Kind("another frame size", CAMERA, _camera("resized"), cause="640 x 360"),
    Kind("experience file: disk full", DISK, lambda t: _full(t.file), cause=_NO_SPACE),
    Kind("experience file: error", DISK, lambda t: _broken(t.file), cause=_INPUT_OUTPUT),
    Kind("experience file: cut short", DISK, _limited, cause="File too large|" + _NO_SPACE),
    Kind("attempts.csv: disk full", DISK, lambda t: _full(t.folder / ATTEMPTS), cause=_NO_SPACE),
    Kind("attempts.csv: error", DISK, lambda t: _broken(t.folder / ATTEMPTS), cause=_INPUT_OUTPUT),
    Kind("folder gone", DISK, _folder_gone, cause="No such file"),
)
