"""Frames a second of the tracker and the renderer on one core."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import cv2

from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.vision.tracker import Tracker

PARTS = ("tracker", "renderer")


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
    """The speed of both parts.

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
        """Measure both parts in alternation."""
        threads = cv2.getNumThreads()
        cv2.setNumThreads(1)
        training = RenderedTraining(self.seed)
        images = [training.newest()[0] for _ in range(self.frames)]

        def track() -> None:
            tracker = Tracker()
            for image in images:
                tracker.update(image)

        def render() -> None:
            for _ in images:
                training.renderer.frame()

        rows = [
            Rate(part, repeat, self.frames / _processor_seconds(work))
            for repeat in range(self.repeats)
            for part, work in zip(PARTS, (track, render), strict=True)
        ]
        training.close()
        cv2.setNumThreads(threads)
        return rows


def _processor_seconds(work: Callable[[], None]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began
