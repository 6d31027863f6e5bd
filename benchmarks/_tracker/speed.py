"""How fast the tracker and the renderer are on one core."""

import time

import cv2

from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.vision.tracker import Tracker


def frames_a_second(seed: int, frames: int, repeats: int) -> tuple[list[float], list[float]]:
    """Frames a second of the tracker, and of the renderer, once a repeat; on one thread, by its processor time."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    training = RenderedTraining(seed)
    pictures = [training.newest()[0] for _ in range(frames)]
    tracked, rendered = [], []
    for _ in range(repeats):
        tracker = Tracker()
        began = time.process_time()
        for picture in pictures:
            tracker.update(picture)
        tracked.append(frames / (time.process_time() - began))
        began = time.process_time()
        for _ in pictures:
            training.renderer.frame()
        rendered.append(frames / (time.process_time() - began))
    training.close()
    cv2.setNumThreads(threads)
    return tracked, rendered
