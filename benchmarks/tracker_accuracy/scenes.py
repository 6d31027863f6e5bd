"""Single frames of random scenes, in several appearances."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.frames import FrameRenderer
from khepera_forage.vision.scene import MM_PER_PIXEL, Truth
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.tracker import Tracker
from tracker_accuracy.observations import TRACKER, Observation, Phantoms, observe

_LAB = CameraAppearance.laboratory()
_HEIGHT = 2700.0
"""mm above the floor of a camera that sees 3.2 x 2.4 m through a lens of 60 degrees."""
_MIDDLE = (PICTURE_WIDTH * MM_PER_PIXEL / 2, PICTURE_HEIGHT * MM_PER_PIXEL / 2)
_BORDER = 110.0
"""mm from the border of the image from which everything is inside."""
_BATCH = 10
"""Scenes with the same floor and light, and with cables from the same anchor."""
_DISTANCE = 200.0
"""Smallest distance in mm between the centres of two things, so that nothing hides another thing."""
LABORATORY = "laboratory"
APPEARANCES = {
    "nothing but quantisation": CameraAppearance.none(),
    LABORATORY: _LAB,
    "laboratory, no cables": replace(_LAB, cable_width=0.0),
    "blur 1.2 pixels": replace(_LAB, blur=1.2),
    "sensor noise 6 levels": replace(_LAB, grain=6.0),
    "corners at half the light": replace(_LAB, vignette=0.5),
    "cables 8 mm thick": replace(_LAB, cable_width=8.0),
    "light grey cables": replace(_LAB, cable=190.0),
    "camera at 2.7 m, parallax corrected": replace(_LAB, height=_HEIGHT),
    "camera at 2.7 m, not corrected": replace(_LAB, height=_HEIGHT),
}


class Scenes(NamedTuple):
    """Random scenes in one appearance: two markers, two foods, and cables from anywhere.

    Attributes:
        appearance: One of `APPEARANCES`.
        seed: The same for every appearance, so that all have the same scenes.
        scenes: How many.
    """

    appearance: str
    seed: int
    scenes: int

    @property
    def key(self) -> str:
        """The appearance."""
        return self.appearance

    def run(self) -> list[Observation | Phantoms]:
        """All observations, and the number of regions of nothing."""
        cv2.setNumThreads(1)
        camera = (*_MIDDLE, _HEIGHT) if self.appearance.endswith("parallax corrected") else None
        tracker = Tracker(calibration=Calibration.identity(camera))
        places, noise = np.random.default_rng(self.seed).spawn(2)
        stage = _Stage(Truth((), ()))
        rows: list[Observation | Phantoms] = []
        phantoms = 0
        for number, (truth, anchor) in enumerate(_scenes(places, self.scenes)):
            if number % _BATCH == 0:
                renderer = FrameRenderer(stage.now, APPEARANCES[self.appearance], anchor)
                stage.truth = truth
                renderer.reset(noise)
            stage.truth = truth
            regions = tracker.detect(renderer.frame())
            new, stray = observe((self.appearance, TRACKER, 0, number), truth, regions, renderer.cables)
            rows += new
            phantoms += stray
        return [*rows, Phantoms(self.appearance, TRACKER, 0, phantoms)]


@dataclass(slots=True)
class _Stage:
    """The scene that the renderer draws next."""

    truth: Truth

    def now(self) -> Truth:
        return self.truth


def _scenes(rng: np.random.Generator, count: int) -> Iterator[tuple[Truth, tuple[float, float]]]:
    """Random scenes, each with the anchor of its cables."""
    low = np.full(2, _BORDER)
    high = np.array((PICTURE_WIDTH, PICTURE_HEIGHT)) * MM_PER_PIXEL - _BORDER
    for number in range(count):
        if number % _BATCH == 0:
            anchor_x, anchor_y = rng.uniform(0, low + high).tolist()
        while True:
            places = [(float(x), float(y)) for x, y in rng.uniform(low, high, (4, 2))]
            turns = rng.uniform(-math.pi, math.pi, 2).tolist()
            distances = [math.dist(a, b) for i, a in enumerate(places) for b in places[:i]]
            if min(distances) > _DISTANCE:
                break
        markers = tuple((*places[i], turns[i], i + 1) for i in range(2))
        yield Truth(markers, tuple(places[2:])), (anchor_x, anchor_y)
