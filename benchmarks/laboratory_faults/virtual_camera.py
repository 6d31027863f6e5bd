"""A virtual camera device below OpenCV: `cv2.VideoCapture` opens it, and its pictures can fail."""

import threading
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
FRAME_INTERVAL = 0.02
"""Seconds: 50 frames a second."""
_HANDOVER = 0.1
"""Seconds that `expose` waits for the reader of the frames."""
_SILENT, _FAILING, _RAISING, _FROZEN = "silent", "failing", "raising", "frozen"
CAMERA_FAULTS = (_SILENT, _FAILING, _RAISING, _FROZEN, "black", "overexposed", "no signal", "resized")


class VirtualCamera:
    """A camera that shows the last frame given to `expose`, with new sensor noise in every frame that is read.

    Attributes:
        fault: One of `CAMERA_FAULTS`, or empty. May be set at any time.
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

    def expose(self, picture: Picture) -> None:
        """Show a new picture; returns when it has been read, or cannot be."""
        with self.changed:
            self._picture = picture
            self.exposures += 1
            number = self.exposures
            self.changed.notify_all()
            if self.fault not in (_SILENT, _FAILING, _RAISING):
                self.changed.wait_for(lambda: self.shown >= number, _HANDOVER)

    def open(self, source: int | str) -> "Capture":
        """What `cv2.VideoCapture` returns."""
        return Capture(self)

    def picture(self) -> Picture:
        """The next frame, with the present fault."""
        self._reads += 1
        noisy: Picture = self._picture ^ np.roll(self._noise, 641 * self._reads)
        if self.fault == _FROZEN:
            return self._frozen
        self._frozen = noisy
        faulty: dict[str, Callable[[], Any]] = {
            "black": lambda: noisy >> 5,
            "overexposed": lambda: cv2.add(noisy, noisy),
            "no signal": lambda: (noisy & 1) + 16,
            "resized": lambda: np.ascontiguousarray(noisy[:360]),
        }
        return np.asarray(faulty[self.fault](), np.uint8) if self.fault in faulty else noisy


class Capture:
    """The part of `cv2.VideoCapture` that a frame source uses.

    Args:
        camera: The device.
    """

    def __init__(self, camera: VirtualCamera) -> None:
        self._camera = camera
        self._open = camera.fault not in (_FAILING, _RAISING)
        self._read_until = 0

    def isOpened(self) -> bool:  # noqa: N802 (OpenCV's name)
        """Whether the device could be opened."""
        return self._open

    def get(self, what: int) -> float:
        """A property: a device has no number of frames."""
        return -1.0 if what == cv2.CAP_PROP_FRAME_COUNT else 1 / FRAME_INTERVAL

    def set(self, what: int, value: float) -> bool:
        """Accept no property."""
        return False

    def release(self) -> None:
        """Close the device."""
        self._open = False

    def read(self) -> tuple[bool, Any]:
        """Wait for the next frame."""
        camera = self._camera
        with camera.changed:
            camera.shown = max(camera.shown, self._read_until)
            camera.changed.notify_all()
            camera.changed.wait_for(lambda: camera.exposures > self._read_until, FRAME_INTERVAL)
            while camera.fault == _SILENT and self._open:
                camera.changed.wait(FRAME_INTERVAL)
            if camera.fault == _RAISING:
                raise cv2.error("(-215:Assertion failed) !image.empty() in function 'retrieve'")
            if camera.fault == _FAILING or not self._open:
                return False, None
            self._read_until = camera.exposures
            return True, cv2.cvtColor(camera.picture(), cv2.COLOR_GRAY2BGR)
