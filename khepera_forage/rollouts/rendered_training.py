"""A simulated training, rendered as the overhead camera's frames: teacher, learner, food and cables."""

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import Listener, Teacher
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.layout_checks import cable_anchor
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.vision.rendering import FrameRenderer
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH


class RenderedTraining:
    """A `FrameSource` of repeated attempts at a training episode (4.5), with one frame for each round.

    The robots use the simulated camera, not the frames, so that their behaviour does not depend on a tracker of the
    frames.

    Args:
        seed: The same seed gives the same frames.
        paced: Deliver at most one frame in the duration of a round, as a real camera would.
        anchor: Place in mm, seen from above, from which the cables hang; None for the middle of the arenas.

    Attributes:
        world: The simulated world; `world.truth()` has the true poses of the newest frame.
        anchor: Place in mm from which the cables hang.
        renderer: Renders the frames.
        attempts: Number of attempts so far; each begins with robots and food on their marks.
    """

    def __init__(self, seed: int, paced: bool = False, anchor: tuple[float, float] | None = None) -> None:
        corridor = _in_the_middle(checked_arena(CORRIDOR, DEFAULT_DECISIONS), 2)
        timing = timing_of(DEFAULT_DECISIONS)
        self.world = PymunkWorld(copies(corridor, 2), (1, 2), Noise.laboratory(), timing=timing)
        self.anchor = cable_anchor(self.world.arenas) if anchor is None else anchor
        self.attempts = 0
        self._env = TrainingEnv(world=self.world)
        walls = [wall for arena in self.world.arenas for wall in arena.segments]
        period = self.world.round_duration
        self.renderer = FrameRenderer(self.world.truth, anchor=self.anchor, walls=walls, period=period)
        self._paced = paced
        self._due = 0.0
        self._rounds = self._train(np.random.default_rng(seed))

    def advance(self) -> None:
        """Simulate one round; the first call places robots and food on their marks."""
        next(self._rounds)

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        """Simulate one round; returns its frame, and the age of the frame: 0 s."""
        self.advance()
        if self._paced:
            time.sleep(max(0.0, self._due - time.monotonic()))
            self._due = max(self._due, time.monotonic()) + self.world.round_duration
        return self.renderer.frame(), 0.0

    def close(self) -> None:
        """Close the simulation."""
        self._env.close()

    def _train(self, rng: np.random.Generator) -> Iterator[None]:
        env, listener = self._env, Listener()
        teacher = Teacher.of(env)
        while True:
            self.attempts += 1
            env.reset(seed=int(rng.integers(2**31)))
            self.renderer.reset(rng)
            yield
            while not (env.terminations[TEACHER] or env.truncations[TEACHER]):
                for agent in env.possible_agents:
                    observation = env.observe(agent)
                    env.step(int((teacher if agent == TEACHER else listener).act(observation)))
                yield


def _in_the_middle(arena: Arena, count: int) -> Arena:
    """An arena, shifted so that its copies lie in the middle of the picture, below the camera (3.1)."""
    bounds = np.array([a.bounds for a in copies(arena, count)])
    x, y = (bounds[:, :2].min(axis=0) + bounds[:, 2:].max(axis=0)) / 2
    return arena.shifted(PICTURE_WIDTH * MM_PER_PIXEL / 2 - float(x), PICTURE_HEIGHT * MM_PER_PIXEL / 2 - float(y))
