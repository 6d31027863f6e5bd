"""The looks under which random scenes are judged, and the scenes."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from _tracker.sights import TRACKER, Sight, sights
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.frames import FrameRenderer
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.simulated_camera import Truth
from khepera_forage.vision.tracker import Tracker

_LAB = CameraAppearance.laboratory()
_HEIGHT = 2700.0
"""mm of a camera above the floor that sees 3.2 x 2.4 m through a lens of 60 degrees."""
_MIDDLE = (PICTURE_WIDTH * MM_PER_PIXEL / 2, PICTURE_HEIGHT * MM_PER_PIXEL / 2)
_BORDER = 110.0
"""mm from the border of the picture at which everything is inside."""
_BATCH = 10
"""Scenes under one floor, one light, and cables from one anchor."""
_APART = 200.0
"""mm between the middles of things: whether one hides another is not asked here."""


@dataclass(frozen=True, slots=True)
class Condition:
    """How frames look, and what the tracker knows of it."""

    name: str
    look: CameraAppearance
    corrected: bool = False


CONDITIONS = (
    Condition("nothing but quantisation", CameraAppearance.none()),
    Condition("laboratory", _LAB),
    Condition("laboratory, no cables", replace(_LAB, cable_width=0.0)),
    Condition("blur 1.2 pixels", replace(_LAB, blur=1.2)),
    Condition("sensor noise 6 levels", replace(_LAB, grain=6.0)),
    Condition("corners at half the light", replace(_LAB, vignette=0.5)),
    Condition("cables 8 mm thick", replace(_LAB, cable_width=8.0)),
    Condition("light grey cables", replace(_LAB, cable=190.0)),
    Condition("camera at 2.7 m, parallax corrected", replace(_LAB, height=_HEIGHT), corrected=True),
    Condition("camera at 2.7 m, not corrected", replace(_LAB, height=_HEIGHT)),
)
LABORATORY = CONDITIONS[1].name


@dataclass(frozen=True, slots=True)
class Scenes:
    """Random scenes under one condition: two markers, two foods, cables from anywhere.

    Attributes:
        condition: Number in `CONDITIONS`.
        seed: The same for every condition, so that all judge the same scenes.
        count: Of scenes.
    """

    condition: int
    seed: int
    count: int

    def run(self) -> tuple[str, list[Sight], int]:
        """Name of the condition, all sights, and the regions that were of nothing."""
        cv2.setNumThreads(1)
        condition = CONDITIONS[self.condition]
        camera = (*_MIDDLE, _HEIGHT) if condition.corrected else None
        tracker = Tracker(calibration=Calibration.identity(camera))
        places, noise = np.random.default_rng(self.seed).spawn(2)
        stage = _Stage(Truth((), ()))
        rows: list[Sight] = []
        phantoms = 0
        for number, (truth, anchor) in enumerate(_scenes(places, self.count)):
            if number % _BATCH == 0:
                renderer = FrameRenderer(stage.now, condition.look, anchor)
                stage.truth = truth
                renderer.reset(noise)
            stage.truth = truth
            seen = tracker.detect(renderer.frame())
            new, stray = sights(TRACKER, 0, number, truth, seen, renderer.cables)
            rows += new
            phantoms += stray
        return condition.name, rows, phantoms


@dataclass(slots=True)
class _Stage:
    """What the renderer shall draw next."""

    truth: Truth

    def now(self) -> Truth:
        return self.truth


def _scenes(rng: np.random.Generator, count: int) -> Iterator[tuple[Truth, tuple[float, float]]]:
    """Truths, each with the place that its cables hang from."""
    low = np.full(2, _BORDER)
    high = np.array((PICTURE_WIDTH, PICTURE_HEIGHT)) * MM_PER_PIXEL - _BORDER
    for number in range(count):
        if number % _BATCH == 0:
            anchor_x, anchor_y = rng.uniform(0, low + high).tolist()
        while True:
            spots = [(float(x), float(y)) for x, y in rng.uniform(low, high, (4, 2))]
            turns = rng.uniform(-math.pi, math.pi, 2).tolist()
            gaps = [math.dist(a, b) for i, a in enumerate(spots) for b in spots[:i]]
            if min(gaps) > _APART:
                break
        markers = tuple((*spots[i], turns[i], i + 1) for i in range(2))
        yield Truth(markers, tuple(spots[2:])), (anchor_x, anchor_y)
