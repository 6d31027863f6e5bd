"""The laboratory of the campaign: a `lab.toml` with three robots and a camera, all devices virtual."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from unittest.mock import patch

import cv2

from khepera_forage.envs.arguments import timing_of
from khepera_forage.envs.laboratories import load_settings
from khepera_forage.lab.clock import Clock
from khepera_forage.lab.operator import Operator
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.robots.serial.line_timing import LineTooSlow
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.vision.rendering.frames import RenderedFrameSource
from khepera_forage.vision.video import VideoSource
from laboratory_faults.virtual_camera import VirtualCamera

ROBOTS = 3
LAB_FILE = "lab.toml"
_DEVICE = 0
_OFFSETS = ((1275, 785), (1275, 1085), (1275, 1385))
"""mm: corridors side by side in the middle of the picture."""


def write_lab_file(folder: Path) -> Path:
    """Write the `lab.toml`."""
    robots = "".join(
        f'[[robots]]\nport = "port_{i}"\noffset = [{x}, {y}]\n' for i, (x, y) in enumerate(_OFFSETS)
    )
    path = folder / LAB_FILE
    path.write_text(f"[camera]\nsource = {_DEVICE}\n{robots}", encoding="utf-8")
    return path


class ExposingClock:
    """A clock after whose rounds the camera shows the new scene.

    Args:
        clock: Simulates the rounds.
        camera: The camera.
        frames: The rendered frames.
    """

    def __init__(self, clock: Clock, camera: VirtualCamera, frames: RenderedFrameSource) -> None:
        self._clock, self._camera, self._frames = clock, camera, frames

    @property
    def rounds(self) -> int:
        """See `Clock`."""
        return self._clock.rounds

    @property
    def overruns(self) -> int:
        """See `Clock`."""
        return self._clock.overruns

    @property
    def worst_overrun(self) -> float:
        """See `Clock`."""
        return self._clock.worst_overrun

    def start(self) -> None:
        """Begin the first round, or the first one after a pause."""
        self._clock.start()

    def wait(self) -> None:
        """Simulate a round, and let the camera take a picture."""
        self._clock.wait()
        self._camera.expose(self._frames.newest()[0])


@contextmanager
def laboratory(
    path: Path, operator: Operator, seed: int
) -> Iterator[tuple[VirtualLaboratory, VirtualCamera]]:
    """The laboratory of a `lab.toml`; drivers, video source and tracker are those of real robots.

    Args:
        path: The file.
        operator: Places the simulated bodies, and repairs what is lost.
        seed: Of the faults of the lines.
    """
    camera = VirtualCamera()
    # OpenCV is below our code: the video source itself is the real one.
    with patch.object(cv2, "VideoCapture", camera.open), _opened(path, operator, seed) as lab:
        lab.clock = ExposingClock(lab.clock, camera, lab.frame_source)
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
