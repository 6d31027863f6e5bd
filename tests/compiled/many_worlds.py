"""Many compiled worlds of bodies, for tests: blocks of records and the kernels of `sim.compiled.stepping`."""

from typing import Any

import numpy as np
from khepera_forage.compilation.threads import threads_for
from khepera_forage.sim.compiled.bodies import empty_bodies
from khepera_forage.sim.compiled.parameters import parameters_of
from khepera_forage.sim.compiled.start import stand_in_blocks
from khepera_forage.sim.compiled.stepping import advance_all

from khepera_forage.counter_rng import keys_of
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_ON_FLOOR, Motors
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.records import LANES
from tests.version_0_1 import TIMING


class ManyWorlds:
    """Worlds of one robot and its food each.

    Args:
        arena: Of every world.
        worlds: How many.
        foods: Food objects in each.
        noise: By default `Noise.laboratory()`.
        lanes: Worlds in a block.
    """

    def __init__(
        self, arena: Arena, worlds: int, foods: int = 1, noise: Noise | None = None, lanes: int = LANES
    ) -> None:
        self.worlds, self.foods = worlds, foods
        self._shape = -(-worlds // lanes), lanes
        self._parameters = parameters_of(arena, foods, noise, holes=2, timing=TIMING)
        self.bodies = empty_bodies(self._shape[0], foods, lanes)

    def reset(self, seed: int, starts: Any, foods: Any) -> None:
        """Put everything in its place: poses (worlds, 3) or (3,), food places (worlds, foods, 2) or (foods, 2)."""
        robots, count = self.bodies.robots, self._shape[0] * self._shape[1]
        robots["key"] = keys_of(np.uint64(seed) + np.arange(count, dtype=np.uint64)).reshape(self._shape)
        robots["round"] = 0
        poses = np.empty((count, 3))
        poses[: self.worlds], poses[self.worlds :] = starts, np.reshape(starts, (-1, 3))[-1]
        stand_in_blocks(self.bodies, self._parameters, poses)
        places = np.empty((count, self.foods, 2))
        places[: self.worlds], places[self.worlds :] = foods, np.reshape(foods, (-1, self.foods, 2))[-1]
        for n, name in enumerate(("x", "y")):
            self.bodies.foods[name] = places[..., n].reshape(*self._shape, self.foods).transpose(0, 2, 1)
        self.advance(Motors(0, 0, 215, 200))  # Nothing moves: this takes the first frame.

    def advance(self, motors: Any) -> None:
        """One round by whole motor commands, shape (worlds, 4) or (4,)."""
        given = np.zeros((self._shape[0] * self._shape[1], 4))
        given[: self.worlds] = motors
        for n, name in enumerate(("left", "right", "arm_target", "jaw_target")):
            self.bodies.robots[name] = given[:, n].reshape(self._shape)
        threads = threads_for(self._shape[0])
        advance_all(self.bodies, self._parameters, threads)

    def robot(self, name: str) -> Any:
        """A field of the robots, one row a world."""
        field = self.bodies.robots[name]
        return np.moveaxis(field, -1, 1).reshape(-1, *field.shape[1:-1])[: self.worlds]

    def food(self, name: str) -> Any:
        """A field of the food, shape (worlds, foods)."""
        return self.bodies.foods[name].transpose(0, 2, 1).reshape(-1, self.foods)[: self.worlds]

    def tracks(self) -> Any:
        """The food's tracks, shape (worlds, 2 * foods)."""
        return self.bodies.tracks.reshape(-1, 2 * self.foods)[: self.worlds]

    def poses(self) -> Any:
        """x mm, y mm and heading of the robots, shape (worlds, 3)."""
        return np.stack([self.robot(name) for name in ("x", "y", "heading")], axis=1)

    def lifted(self) -> Any:
        """Whether a raised gripper holds each food object, shape (worlds, foods)."""
        held, raised = self.robot("held"), self.robot("arm") < ARM_ON_FLOOR
        return (held[:, None] == np.arange(self.foods)) & raised[:, None]
