"""Rendered frames of markers and food placed by a test, and errors of the regions tracked in them."""

import math
from collections.abc import Callable, Iterable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.association import Detection
from khepera_forage.vision.rendering import CameraAppearance, FrameRenderer, Light
from khepera_forage.vision.scene import Region, Scene, Truth

Frame = NDArray[np.uint8]
Place = tuple[float, float]
Marker = tuple[float, float, float, int]
LABORATORY = CameraAppearance.laboratory()
NONE = CameraAppearance.none()
PAIR = Truth(((400.0, 300.0, 0.5, 1), (900.0, 700.0, 2.0, 2)), ((400.0, 700.0), (900.0, 300.0)))
ROW, COLUMN = np.mgrid[:480, :640] + 0.5


class SceneRenderer:
    """Renders one frame after another; every frame has its own markers and food.

    Args:
        appearance: The laboratory's by default.
        anchor: Of the cables.
        walls: As for `FrameRenderer`.
        seed: Of everything random.
    """

    def __init__(
        self,
        appearance: CameraAppearance = LABORATORY,
        anchor: Place | None = None,
        walls: tuple[tuple[float, float, float, float], ...] = (),
        seed: int = 0,
    ) -> None:
        self.truth, self.rng = Truth((), ()), np.random.default_rng(seed)
        self._renderer = FrameRenderer(self._shown, appearance, anchor, walls=walls)
        self._renderer.reset(self.rng)
        self._light = Light(appearance, self.rng)

    def _shown(self) -> Truth:  # a method, so that a copy shows its own truth
        return self.truth

    def frame(
        self, markers: tuple[Marker, ...], foods: tuple[Place, ...] = (), change: Callable[[Frame], Frame] | None = None
    ) -> Frame:
        """The next frame; a change is done to the picture before lens and sensor, and without cables."""
        robots, self.truth = len(self.truth.markers), Truth(markers, foods)
        if change is not None:
            return self._light.expose(change(self._renderer.picture()), 0.0)
        if len(markers) != robots:  # each has a cable
            self._renderer.reset(self.rng)
        return self._renderer.frame()


def random_marker(
    rng: np.random.Generator, holes: int, left: float = 120.0, right: float = 3080.0, border: float = 120.0
) -> Marker:
    """A marker at a random pose inside the picture, its x between `left` and `right` mm."""
    heading = float(rng.uniform(-math.pi, math.pi))
    return float(rng.uniform(left, right)), float(rng.uniform(border, 2400 - border)), heading, holes


def only_region(scene: Scene, holes: int) -> Region:
    (region,) = [r for r in scene.regions if r.holes == holes]
    return region


def position_error(region: Region | Detection, x: float, y: float) -> float:
    """Distance in pixels from a position in mm."""
    return math.hypot(region.x - x / 5, region.y - y / 5)


def heading_error(region: Region | Detection, heading: float) -> float:
    """Degrees from a heading in radians."""
    return abs(math.remainder(region.orientation - math.degrees(heading), 360))


def write_film(path: Path, frames: Iterable[Frame], fps: float = 10.0) -> Path:
    """Write frames, grey or in colour, as a film."""
    first, *more = frames
    code, size = cv2.VideoWriter.fourcc(*"MJPG"), first.shape[1::-1]
    writer = cv2.VideoWriter(str(path), code, fps, size, first.ndim == 3)
    for frame in (first, *more):
        writer.write(frame)
    writer.release()
    return path


def render_frames(truth: Truth, appearance: CameraAppearance = NONE, frames: int = 1) -> list[Frame]:
    renderer = SceneRenderer(appearance)
    return [renderer.frame(truth.markers, truth.foods) for _ in range(frames)]


def render_frame(truth: Truth, appearance: CameraAppearance = NONE, anchor: Place | None = None) -> Frame:
    return SceneRenderer(appearance, anchor).frame(truth.markers, truth.foods)
