"""Uneven light, lens blur and sensor noise, applied to a drawn picture."""

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_PERIOD = 40.0
"""Typical period in s of the light's drift."""
_SPARE = 256
"""Pixels by which the precomputed noise is larger than a frame in each direction."""

_WAVES = 3
_PERIODS = (0.6, 1.7)
"""Shortest and longest period of a wave, as a share of the typical period."""


class SlowNoise:
    """Independent random signals, each the mean of three sine waves with random periods and phases.

    Args:
        rng: Draws all periods and phases at construction.
        count: Number of signals.
        period: Typical period of a wave in s.
    """

    def __init__(self, rng: np.random.Generator, count: int, period: float) -> None:
        periods = period * rng.uniform(*_PERIODS, (count, _WAVES))
        self._rates = 2 * np.pi / periods
        self._phases = rng.uniform(0, 2 * np.pi, (count, _WAVES))

    def at(self, seconds: float) -> NDArray[np.float64]:
        """The signals at a time: mean 0, within -1..1, with a standard deviation of 0.41."""
        waves: NDArray[np.float64] = np.sin(self._rates * seconds + self._phases)
        means: NDArray[np.float64] = waves.mean(axis=1)
        return means


class Light:
    """Uneven and slowly varying light, blur, noise and quantisation.

    The light is a slowly tilting plane minus a paraboloid (the vignette). The noise is normal and independent from
    pixel to pixel. For speed it is drawn once, and each frame uses a randomly shifted and mirrored part of it.

    Args:
        appearance: Sizes of all effects.
        rng: Spawned for the light's drift and the sensor's noise.
    """

    def __init__(self, appearance: CameraAppearance, rng: np.random.Generator) -> None:
        drift, self._rng = rng.spawn(2)
        self._appearance = appearance
        self._drift = SlowNoise(drift, 3, _PERIOD)
        self._tilt = drift.uniform(-1, 1, 2)
        self._tilt *= appearance.gradient / max(1e-9, float(np.abs(self._tilt).max()))
        height, width = int(PICTURE_HEIGHT), int(PICTURE_WIDTH)
        self._across = np.linspace(-1, 1, width, dtype=np.float32)
        self._down = np.linspace(-1, 1, height, dtype=np.float32)[:, None]
        noise = self._rng.standard_normal((height + _SPARE, width + _SPARE), dtype=np.float32)
        self._noise = np.float32(appearance.grain) * noise
        self._lit = np.empty((height, width), np.float32)

    def expose(self, picture: NDArray[np.uint8], seconds: float) -> NDArray[np.uint8]:
        """The frame that the camera takes of a picture drawn under full, even light.

        Args:
            picture: 480 x 640 grey levels; not changed.
            seconds: Time since the reset.

        Returns:
            A new 480 x 640 frame.
        """
        appearance = self._appearance
        if appearance.blur > 0:
            picture = cv2.GaussianBlur(picture, (0, 0), appearance.blur)  # type: ignore[assignment]
        brightness, *tilt = appearance.drift * self._drift.at(seconds)
        tilt_x, tilt_y = (np.float32(t) for t in self._tilt + tilt)
        vignette = np.float32(appearance.vignette / 2)
        # Blur before light is the wrong order physically, but the light hardly changes over the width of the blur.
        across = np.float32(1 + brightness) + tilt_x * self._across - vignette * self._across**2
        down = tilt_y * self._down - vignette * self._down**2
        np.add(across, down, out=self._lit)
        np.multiply(self._lit, picture, out=self._lit)
        frame: NDArray[np.uint8] = cv2.add(self._lit, self._noise_window(), dtype=cv2.CV_8U)  # type: ignore[assignment]
        return frame

    def _noise_window(self) -> NDArray[np.float32]:
        """A part of the precomputed noise at a random place, mirrored at random in both directions."""
        height, width = self._lit.shape
        row, column, mirrors = self._rng.integers(0, (_SPARE, _SPARE, 4)).tolist()
        window = self._noise[row : row + height, column : column + width]
        return np.ascontiguousarray(window[:: 1 - 2 * (mirrors & 1), :: 1 - (mirrors & 2)])
