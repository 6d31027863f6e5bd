"""Frames a second of the tracker and the renderer on one core."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.tracker import Tracker
from tracker_accuracy.tiles import Conditions, frames

TRACKER, CROSSED, RENDERER = "tracker", "tracker, each marker under a cable", "renderer"
PARTS = (TRACKER, CROSSED, RENDERER)
_CROSSED = Conditions(CameraAppearance.laboratory(), cable_width=8.0)
"""Frames with two markers, each under a cable, and two foods."""


@dataclass(frozen=True, slots=True)
class Rate:
    """One repeat of one part.

    Attributes:
        part: One of `PARTS`.
        repeat: From 0.
        rate: Frames a second, by the processor time of one thread.
    """

    part: str
    repeat: int
    rate: float


class Speed(NamedTuple):
    """The speed of all parts.

    Attributes:
        seed: Of the training whose frames are used.
        frames: In each repeat.
        repeats: How many.
    """

    seed: int
    frames: int
    repeats: int

    @property
    def key(self) -> str:
        """The same for all: there is one unit of this kind."""
        return "speed"

    def run(self) -> list[Rate]:
        """Measure all parts in alternation."""
        threads = cv2.getNumThreads()
        cv2.setNumThreads(1)
        training = RenderedTraining(self.seed)
        images = [training.newest()[0] for _ in range(self.frames)]

        crossed = [
            frame for _, frame in frames(_CROSSED, self.frames, np.random.default_rng(self.seed), tiles=2)
        ]

        def track(images: list[NDArray[np.uint8]], one_scene: bool) -> None:
            tracker = Tracker()
            for image in images:
                if not one_scene:
                    tracker.reset()
                tracker.update(image)

        def render() -> None:
            for _ in images:
                training.renderer.frame()

        works: dict[str, Callable[[], None]] = {
            TRACKER: partial(track, images, True),
            CROSSED: partial(track, crossed, False),
            RENDERER: render,
        }
        rows = [
            Rate(part, repeat, self.frames / _processor_seconds(work))
            for repeat in range(self.repeats)
            for part, work in works.items()
        ]
        training.close()
        cv2.setNumThreads(threads)
        return rows


def _processor_seconds(work: Callable[[], None]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began
