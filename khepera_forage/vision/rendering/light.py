"""What the light, the lens and the sensor make of a picture."""

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.rendering.appearance import CameraLook
from khepera_forage.vision.rendering.slow_noise import Slow
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_PERIOD = 40.0
"""Typical seconds in which the light comes and goes."""
_SPARE = 256
"""How much larger than a picture, each way, the sheet of noise is from which every frame takes a random window."""


class Light:
    """Uneven and slowly varying light, blur, noise and quantisation.

    The light is a plane that tilts slowly, less a bowl (the vignette). The noise is normal and independent from
    pixel to pixel; to be quick it is drawn once, and each frame takes a window of it at a random place, turned
    one of four ways.

    Args:
        look: Sizes.
        rng: Spawned for the light's waves and the sensor's noise.
    """

    def __init__(self, look: CameraLook, rng: np.random.Generator) -> None:
        waves, self._rng = rng.spawn(2)
        self._look = look
        self._slow = Slow(waves, 3, _PERIOD)
        self._tilt = waves.uniform(-1, 1, 2)
        self._tilt *= look.gradient / max(1e-9, float(np.abs(self._tilt).max()))
        height, width = int(PICTURE_HEIGHT), int(PICTURE_WIDTH)
        self._across = np.linspace(-1, 1, width, dtype=np.float32)
        self._down = np.linspace(-1, 1, height, dtype=np.float32)[:, None]
        sheet = self._rng.standard_normal((height + _SPARE, width + _SPARE), dtype=np.float32)
        self._noise = np.float32(look.grain) * sheet
        self._lit = np.empty((height, width), np.float32)

    def expose(self, picture: NDArray[np.uint8], seconds: float) -> NDArray[np.uint8]:
        """The frame that the camera makes of a picture under full, even light.

        Args:
            picture: 480 x 640 grey levels; it is left as it was.
            seconds: Time since the reset.

        Returns:
            A new 480 x 640 picture.
        """
        look = self._look
        if look.blur > 0:
            picture = cv2.GaussianBlur(picture, (0, 0), look.blur)  # type: ignore[assignment]
        brightness, *tilt = look.drift * self._slow.at(seconds)
        tilt_x, tilt_y = (np.float32(t) for t in self._tilt + tilt)
        bowl = np.float32(look.vignette / 2)
        # Light multiplies and the lens blurs, in nature the other way round: over a pixel the light is even.
        across = np.float32(1 + brightness) + tilt_x * self._across - bowl * self._across**2
        down = tilt_y * self._down - bowl * self._down**2
        np.add(across, down, out=self._lit)
        np.multiply(self._lit, picture, out=self._lit)
        frame: NDArray[np.uint8] = cv2.add(self._lit, self._window(), dtype=cv2.CV_8U)  # type: ignore[assignment]
        return frame

    def _window(self) -> NDArray[np.float32]:
        height, width = self._lit.shape
        row, column, turn = self._rng.integers(0, (_SPARE, _SPARE, 4)).tolist()
        window = self._noise[row : row + height, column : column + width]
        return np.ascontiguousarray(window[:: 1 - 2 * (turn & 1), :: 1 - (turn & 2)])
