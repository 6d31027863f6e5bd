"""Trainings in simulation, watched by all at once: tracker and bare threshold on rendered frames, and the model."""

from dataclasses import dataclass

import cv2
import numpy as np

from _tracker import bare
from _tracker.sights import BARE, MODEL, TRACKER, Sight, sights, straight
from khepera_forage.noise import Noise
from khepera_forage.rollouts.rendered_training import RenderedTraining
from khepera_forage.vision.simulated_camera import OverheadCamera
from khepera_forage.vision.tracker import Tracker

ANCHOR = 400.0
"""Cables hang from somewhere within so many mm, each way, of the middle of both arenas: in the middle they would hang
between the two and cross nothing."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Two robots forage, one following the other, for so many rounds, in as many attempts as that takes.

    Attributes:
        number: Of the drive; it and the seed give the drive its random numbers.
        seed: Of the run.
        rounds: How long.
    """

    number: int
    seed: int
    rounds: int

    def run(self) -> tuple[list[Sight], dict[str, int]]:
        """All sights of all cameras, and how many regions of nothing each reported."""
        cv2.setNumThreads(1)
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(self.number,)))
        training = RenderedTraining(int(rng.integers(2**31)))
        middle = training.anchor
        training.close()
        x, y = rng.uniform(-ANCHOR, ANCHOR, 2).tolist()
        anchor = (middle[0] + x, middle[1] + y)
        training = RenderedTraining(int(rng.integers(2**31)), anchor=anchor)
        tracker = Tracker()
        # Not the world's own, whose cables hang between the arenas: the model under the same anchor.
        model = OverheadCamera(training.world.truth, Noise.laboratory(), anchor)
        rows: list[Sight] = []
        phantoms = {TRACKER: 0, MODEL: 0, BARE: 0}
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
            # Frames of different attempts are far apart, so that nothing is counted across them.
            at = frame + 100_000 * attempts
            scene = tracker.update(picture)
            new, stray = sights(TRACKER, self.number, at, truth, scene.regions, training.renderer.cables)
            rows += new
            phantoms[TRACKER] += stray
            plain = bare.regions(picture)
            new, stray = sights(BARE, self.number, at, truth, plain, training.renderer.cables)
            rows += new
            phantoms[BARE] += stray
            modelled = model.look().regions
            new, stray = sights(MODEL, self.number, at, truth, modelled, straight(truth, anchor))
            rows += new
            phantoms[MODEL] += stray
        training.close()
        return rows, phantoms
