"""Trainings in simulation, observed by all cameras at once."""

from typing import NamedTuple

import cv2
import numpy as np

from khepera_forage.noise import Noise
from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.sim.sensing import OverheadCamera
from khepera_forage.vision.tracker import Tracker
from tracker_accuracy import threshold
from tracker_accuracy.observations import (
    CAMERAS,
    MODEL,
    THRESHOLD,
    TRACKER,
    TRAINING,
    Observation,
    Phantoms,
    observe,
    straight_cables,
)

ANCHOR = 400.0
"""Cables hang from a point within this many mm, along each axis, of the middle of both arenas. In the middle itself
they would hang between the arenas and cross nothing."""


class ObservedTraining(NamedTuple):
    """Two robots forage, one following the other, for some rounds, in as many attempts as that takes.

    Attributes:
        number: Of the training; with the seed, it determines the random numbers.
        seed: Of the run.
        rounds: How many.
    """

    number: int
    seed: int
    rounds: int

    @property
    def key(self) -> str:
        """Number of the training."""
        return f"training {self.number}"

    def run(self) -> list[Observation | Phantoms]:
        """All observations of all cameras, and how many regions of nothing each reported."""
        cv2.setNumThreads(1)
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(self.number,)))
        training = RenderedTraining(int(rng.integers(2**31)))
        middle = training.anchor
        training.close()
        x, y = rng.uniform(-ANCHOR, ANCHOR, 2).tolist()
        anchor = (middle[0] + x, middle[1] + y)
        training = RenderedTraining(int(rng.integers(2**31)), anchor=anchor)
        tracker = Tracker()
        # The world's own camera has its cables between the arenas; this model has the anchor of the rendered ones.
        model = OverheadCamera(training.world.truth, Noise.laboratory(), anchor)
        rows: list[Observation | Phantoms] = []
        phantoms = dict.fromkeys(CAMERAS, 0)
        attempts = 0
        for frame in range(self.rounds):
            picture, _ = training.newest()
            if training.attempts != attempts:
                attempts = training.attempts
                tracker.reset()
                model.reset(rng)
            else:
                model.expose()
            truth = training.world.truth()
            rendered = training.renderer.cables
            for camera, regions, cables in (
                (TRACKER, tracker.update(picture).regions, rendered),
                (THRESHOLD, threshold.regions(picture), rendered),
                (MODEL, model.look().regions, straight_cables(truth, anchor)),
            ):
                # Frames of different attempts are far apart, so that nothing is counted across them.
                number = frame + 100_000 * attempts
                new, stray = observe((TRAINING, camera, self.number, number), truth, regions, cables)
                rows += new
                phantoms[camera] += stray
        training.close()
        return rows + [Phantoms(TRAINING, camera, self.number, n) for camera, n in phantoms.items()]
