"""The camera of a laboratory, whose frames are those of the present round."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from khepera_forage.lab.settings_file import LabSettings
from khepera_forage.robots.khepera import PULSE
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.image_quality import is_well_exposed, why_unusable
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.video import CameraLost, Frame, FrameSource, VideoSource

_HOLD_AFTER = 2
"""Periods from the beginning of a round until the wheels are stopped for want of a frame."""
_POLL = 0.002
"""Seconds from one look at the source to the next."""
_LEAST_TRAVEL = 5.0
"""mm, one pixel: robots that have travelled farther cannot leave the picture as it was."""


class FreshFrames:
    """A `FrameSource` that waits for a frame of the present round.

    A frame is refused if it was taken before the round began, if it shows no scene (black, suddenly overexposed), or if
    it is the same as the last one, pixel by pixel, although a robot has travelled: the camera is then frozen.
    Experience is therefore never recorded from an old picture. `hold` stops the wheels after two periods without a
    frame. `pulses` returns the encoder counters of all wheels.
    """

    def __init__(
        self,
        source: FrameSource,
        tracker: Tracker,
        settings: LabSettings,
        pulses: Callable[[], Sequence[int]],
        hold: Callable[[], None],
    ) -> None:
        self._source, self._tracker = source, tracker
        self._name, self._oldest = str(settings.camera.source), settings.camera.oldest
        self._hold_after = _HOLD_AFTER * settings.period
        self._pulses, self._hold = pulses, hold
        self._round_begin = time.monotonic()
        self._last: tuple[Frame, Sequence[int]] | None = None

    def begin_round(self) -> None:
        """Accept only frames taken from now on."""
        self._round_begin = time.monotonic()

    def forget(self) -> None:
        """Forget the last frame: robots may have been carried, or exchanged."""
        self._last = None

    def newest(self) -> tuple[Frame, float]:
        """A frame of this round, and its age in s.

        Raises `CameraLost` if there is none for `oldest` seconds, or the source has no more frames.
        """
        begin, held = time.monotonic(), False
        while True:
            frame, age = self._source.newest()
            reason = self._why_refused(frame, age)
            if not reason:
                return frame, age
            now = time.monotonic()
            if max(now - begin, age) > self._oldest:
                raise CameraLost(self._name, reason, age)
            if now - self._round_begin > self._hold_after and not held:
                held = True
                self._hold()
            time.sleep(_POLL)

    def close(self) -> None:
        """Close the source; a second call does nothing."""
        self._source.close()

    def _why_refused(self, frame: Frame, age: float) -> str:
        if age > time.monotonic() - self._round_begin:
            return f"no frame for {self._oldest:g} s"
        pulses = self._pulses()
        if self._last is not None and np.array_equal(frame, self._last[0]):
            farthest = max(abs(now - then) for now, then in zip(pulses, self._last[1], strict=True)) * PULSE
            if farthest <= _LEAST_TRAVEL:
                return ""
            return f"its picture has not changed, although a robot has travelled {farthest:.0f} mm"
        strict = self._last is not None and is_well_exposed(self._last[0])
        reason = why_unusable(frame, self._tracker, strict)
        if not reason:
            self._last = frame, pulses
        return reason and f"its picture {reason}"


def calibration_of(settings: LabSettings) -> Calibration | None:
    """The calibration that the settings name."""
    file = settings.camera.calibration
    return None if file is None else Calibration.load(file)


def open_video(settings: LabSettings, calibration: Calibration | None) -> VideoSource:
    """Open the camera of the settings, by default with the size of its calibration."""
    camera = settings.camera
    if camera.size is None and calibration is not None:
        camera = replace(camera, size=calibration.size)
    return VideoSource(camera.source, settings=camera)
