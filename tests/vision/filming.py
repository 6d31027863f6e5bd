"""What the tests of tracker and camera share: rendered frames of a stage whose pieces a test moves."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.frames import FrameRenderer
from khepera_forage.vision.scene import Region, Scene
from khepera_forage.vision.simulated_camera import Truth

Marker = tuple[float, float, float, int]


class Film:
    """A renderer above a stage; `shoot` moves the pieces and takes a frame.

    Args:
        look: The laboratory's by default.
        anchor: Of cables.
        seed: Of everything random.
    """

    def __init__(
        self, look: CameraAppearance | None = None, anchor: tuple[float, float] | None = None, seed: int = 0
    ) -> None:
        self.truth = Truth((), ())
        self._renderer = FrameRenderer(lambda: self.truth, look or CameraAppearance.laboratory(), anchor)
        self._rng = np.random.default_rng(seed)
        self._markers = -1

    def shoot(
        self, markers: tuple[Marker, ...], foods: tuple[tuple[float, float], ...] = ()
    ) -> NDArray[np.uint8]:
        self.truth = Truth(markers, foods)
        if len(markers) != self._markers:
            self._markers = len(markers)
            self._renderer.reset(self._rng)
        return self._renderer.frame()


def only(scene: Scene, holes: int) -> Region:
    (region,) = [r for r in scene.regions if r.holes == holes]
    return region


def off(region: Region, x: float, y: float) -> float:
    """Distance in pixels from a place in mm."""
    return math.hypot(region.x - x / 5, region.y - y / 5)


def turned(region: Region, heading: float) -> float:
    """Degrees from a heading in radians."""
    return abs(math.remainder(region.orientation - math.degrees(heading), 360))
