"""Rendered frames of markers and food placed by a test, and errors of the regions tracked in them."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.rendering import CameraAppearance, FrameRenderer, Light
from khepera_forage.vision.scene import Region, Scene, Truth

Frame = NDArray[np.uint8]
LABORATORY = CameraAppearance.laboratory()
NONE = CameraAppearance.none()
PAIR = Truth(((400.0, 300.0, 0.5, 1), (900.0, 700.0, 2.0, 2)), ((400.0, 700.0), (900.0, 300.0)))
ROW, COLUMN = np.mgrid[:480, :640] + 0.5
Marker = tuple[float, float, float, int]


class SceneRenderer:
    """Renders one frame after another; every frame has its own markers and food.

    Args:
        appearance: The laboratory's by default.
        anchor: Of the cables.
        seed: Of everything random.
    """

    def __init__(
        self,
        appearance: CameraAppearance | None = None,
        anchor: tuple[float, float] | None = None,
        seed: int = 0,
    ) -> None:
        self.truth = Truth((), ())
        self._renderer = FrameRenderer(
            lambda: self.truth, appearance or CameraAppearance.laboratory(), anchor
        )
        self._rng = np.random.default_rng(seed)
        self._markers = -1

    def frame(
        self, markers: tuple[Marker, ...], foods: tuple[tuple[float, float], ...] = ()
    ) -> NDArray[np.uint8]:
        self.truth = Truth(markers, foods)
        if len(markers) != self._markers:
            self._markers = len(markers)
            self._renderer.reset(self._rng)
        return self._renderer.frame()


class Laboratory:
    """Frames of a laboratory, with something done to the picture before lens and sensor."""

    def __init__(
        self, appearance: CameraAppearance = LABORATORY, walls: tuple[tuple[float, ...], ...] = ()
    ) -> None:
        self.rng = np.random.default_rng(5)
        self.truth = Truth((), ())
        self.renderer = FrameRenderer(self._shown, appearance, walls=walls)  # type: ignore[arg-type] # four each
        self.renderer.reset(self.rng)
        self.light = Light(appearance, self.rng)

    def _shown(self) -> Truth:
        return self.truth

    def frame(
        self,
        markers: tuple[Marker, ...],
        foods: tuple[tuple[float, float], ...] = (),
        change: Callable[[Frame], Frame] = lambda picture: picture,
    ) -> NDArray[np.uint8]:
        self.truth = Truth(markers, foods)
        return self.light.expose(change(self.renderer.picture()), 0.0)

    def marker(self, holes: int) -> Marker:
        x, y, heading = self.rng.uniform((300, 300, -math.pi), (2900, 2100, math.pi)).tolist()
        return x, y, heading, holes


def random_marker(rng: np.random.Generator, holes: int, left: float = 120.0, right: float = 3080.0) -> Marker:
    """A marker at a random pose inside the picture, its x between `left` and `right` mm."""
    heading = float(rng.uniform(-math.pi, math.pi))
    return float(rng.uniform(left, right)), float(rng.uniform(120, 2280)), heading, holes


def only_region(scene: Scene, holes: int) -> Region:
    (region,) = [r for r in scene.regions if r.holes == holes]
    return region


def position_error(region: Region, x: float, y: float) -> float:
    """Distance in pixels from a position in mm."""
    return math.hypot(region.x - x / 5, region.y - y / 5)


def heading_error(region: Region, heading: float) -> float:
    """Degrees from a heading in radians."""
    return abs(math.remainder(region.orientation - math.degrees(heading), 360))


def render_frames(
    truth: Truth,
    appearance: CameraAppearance = NONE,
    frames: int = 1,
    seed: int = 0,
    anchor: tuple[float, float] | None = None,
) -> list[Frame]:
    renderer = FrameRenderer(lambda: truth, appearance, anchor)
    renderer.reset(np.random.default_rng(seed))
    return [renderer.frame() for _ in range(frames)]


def render_frame(
    truth: Truth, appearance: CameraAppearance = NONE, anchor: tuple[float, float] | None = None
) -> Frame:
    return render_frames(truth, appearance, anchor=anchor)[0]


def centroid(weight: NDArray[np.float64]) -> tuple[float, float]:
    """Centroid in pixels, x right and y up."""
    total = weight.sum()
    return float((weight * COLUMN).sum() / total), 480 - float((weight * ROW).sum() / total)


def grey_at(frame: Frame, x: float, y: float) -> int:
    """The grey level at a place in mm."""
    return int(frame[479 - int(y / 5), int(x / 5)])
