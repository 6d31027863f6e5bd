"""The real overhead camera: frames from a source, regions from the tracker."""

import logging

import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.image_quality import measure_quality
from khepera_forage.vision.scene import Scene
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.video import FrameSource

_LOG = logging.getLogger(__name__)
_URGENT = ("camera moved", "tag twice", "tag size")
"""Warnings of the tracker that are logged at once."""
_LASTING = 5
"""Frames after which the others are logged: half a second of rounds."""
_CHECK_INTERVAL = 300
"""Frames from one check of the picture's quality to the next: half a minute of rounds."""


class TrackedCamera:
    """A `Camera` that reports the regions which a `Tracker` finds in the frames of a `FrameSource`.

    The scene is empty before the first `reset` or `expose`. The first frame after a reset, and one frame every half
    minute, is checked by `measure_quality`; what is beyond its limit is logged as a warning, once. What the tracker is
    uncertain about is logged once in an episode.

    A context manager: leaving it closes the source.

    Args:
        source: Frame source; it is closed with the camera.
        tracker: A tracker that nothing else uses.

    Attributes:
        tracker: With its settings and calibration.
        age: Of the last frame in s when it was taken from the source.
    """

    def __init__(self, source: FrameSource, tracker: Tracker) -> None:
        self.tracker, self.age = tracker, 0.0
        self._source = source
        self._frame: NDArray[np.uint8] | None = None
        self._until_check = 0
        self._warned: set[str] = set()
        self._lasted: dict[str, int] = {}
        self._logged: set[str] = set()

    def reset(self) -> None:
        """Forget all tracks, and take the first frame.

        Raises:
            CameraLost: The source has no more frames.
        """
        self.tracker.reset()
        self._until_check = 0
        self._lasted, self._logged = {}, set()
        self.expose()

    def expose(self) -> None:
        """Take the newest frame, once per round.

        Raises:
            CameraLost: The source has no more frames; `look` still returns the last scene.
        """
        self._frame, self.age = self._source.newest()
        self.tracker.update(self._frame)
        self._log_troubles()
        self._until_check -= 1
        if self._until_check < 0:
            self._until_check = _CHECK_INTERVAL
            self._log_quality()

    def look(self) -> Scene:
        """The scene of the last frame; empty before the first."""
        return self.tracker.scene

    @property
    def frame(self) -> NDArray[np.uint8]:
        """The tracker's last frame, grey levels.

        Raises:
            RuntimeError: No frame was taken yet.
        """
        if self._frame is None:
            raise RuntimeError("frame before any expose(); allowed: after one")
        return self._frame

    def close(self) -> None:
        """Close the source; a second call does nothing."""
        self._source.close()

    def __enter__(self) -> "TrackedCamera":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _log_quality(self) -> None:
        """Log what is beyond its limit and was not at the last check."""
        found = measure_quality(self.tracker.reduced(self.frame)).warnings(self.tracker.settings)
        for name, text in found.items():
            if name not in self._warned:
                _LOG.warning("camera picture %s", text)
        self._warned = set(found)

    def _log_troubles(self) -> None:
        """Log what the tracker is uncertain about, once in an episode, if it lasts or needs the user."""
        found = self.tracker.warnings
        self._lasted = {name: self._lasted.get(name, 0) + 1 for name in found}
        for name, text in found.items():
            if name not in self._logged and (name in _URGENT or self._lasted[name] >= _LASTING):
                _LOG.warning("camera: %s", text)
                self._logged.add(name)
