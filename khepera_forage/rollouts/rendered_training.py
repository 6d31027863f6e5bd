"""A training in simulation as the overhead camera would film it: teacher, learner, food and cables, in pixels."""

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import Listener, Teacher
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.sim.arena import CORRIDOR, Arena, copies
from khepera_forage.sim.layout_checks import cable_anchor
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.frames import FrameRenderer
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH


class RenderedTraining:
    """Attempt after attempt at a training episode (4.5), a round of 0.1 s a frame; a `FrameSource`.

    The robots see through the simulated camera, so that what they do does not depend on who looks at the frames.

    Args:
        seed: The same seed gives the same frames.
        look: Of the frames.
        noise: Of the simulation.
        paced: Hand out frames no faster than one a round, as they would come.
        anchor: Where the cables hang from, in mm as seen from above; None for the middle of the arenas.

    Attributes:
        world: What is filmed; `world.truth()` is what the newest frame shows.
        anchor: Where the cables hang from, in mm.
        attempts: How many were begun; at each, robots and food are put on their marks anew.
    """

    def __init__(
        self,
        seed: int,
        look: CameraAppearance | None = None,
        noise: Noise | None = None,
        paced: bool = False,
        anchor: tuple[float, float] | None = None,
    ) -> None:
        self.world = PymunkWorld(copies(_in_the_middle(CORRIDOR, 2), 2), (1, 2), noise)
        self.anchor = cable_anchor(self.world.arenas) if anchor is None else anchor
        self.attempts = 0
        self._env = TrainingEnv(noise=noise, world=self.world)
        walls = [wall for arena in self.world.arenas for wall in arena.segments]
        self._renderer = FrameRenderer(self.world.truth, look, self.anchor, walls=walls)
        self._paced = paced
        self._due = 0.0
        self._rounds = self._train(np.random.default_rng(seed))

    @property
    def renderer(self) -> FrameRenderer:
        """Who draws the frames."""
        return self._renderer

    def advance(self) -> None:
        """One round; the first puts everything on its marks."""
        next(self._rounds)

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        """A frame after one more round, and its age: 0 s."""
        self.advance()
        if self._paced:
            time.sleep(max(0.0, self._due - time.monotonic()))
            self._due = max(self._due, time.monotonic() - CONTROL_PERIOD) + CONTROL_PERIOD
        return self._renderer.frame(), 0.0

    def close(self) -> None:
        """Let go of the simulation."""
        self._env.close()

    def _train(self, rng: np.random.Generator) -> Iterator[None]:
        env, listener = self._env, Listener()
        teacher = Teacher(env.home_radius)
        while True:
            self.attempts += 1
            env.reset(seed=int(rng.integers(2**31)))
            self._renderer.reset(rng)
            yield
            while not (env.terminations[TEACHER] or env.truncations[TEACHER]):
                for agent in env.possible_agents:
                    observation = env.observe(agent)
                    env.step(int((teacher if agent == TEACHER else listener).act(observation)))
                yield


def _in_the_middle(arena: Arena, count: int) -> Arena:
    """An arena whose copies fill the middle of the picture: overhead is where the camera hangs (3.1)."""
    bounds = np.array([a.bounds for a in copies(arena, count)])
    x, y = (bounds[:, :2].min(axis=0) + bounds[:, 2:].max(axis=0)) / 2
    return arena.shifted(
        PICTURE_WIDTH * MM_PER_PIXEL / 2 - float(x), PICTURE_HEIGHT * MM_PER_PIXEL / 2 - float(y)
    )
