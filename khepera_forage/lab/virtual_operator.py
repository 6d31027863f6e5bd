"""The operator of the virtual laboratory: places simulated robots and food with a person's accuracy."""

import math
from collections.abc import Callable

import numpy as np

from khepera_forage.lab.operator import OperatorGaveUp, OperatorRequest
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout

_MAX_TRIES = 200
"""Draws of placement errors before a request counts as impossible."""


class VirtualOperator:
    """Carries out requests at once, with the errors `Noise.placement_error` and `placement_heading_error`.

    Args:
        world: The simulated world.
        noise: The accuracy of placement.
        on_reset: Called after a reset of the world, which creates new bodies.
        reconnect: Called when the laboratory has lost a device.

    Attributes:
        requests: All requests since the last `begin_episode`.
        max_repeats: Number of failed repetitions of a request before the operator gives up.
    """

    def __init__(
        self,
        world: PymunkWorld,
        noise: Noise,
        on_reset: Callable[[], None],
        reconnect: Callable[[], None],
    ) -> None:
        self.requests: list[OperatorRequest] = []
        self.max_repeats = 10
        self._world, self._noise = world, noise
        self._on_reset, self._reconnect = on_reset, reconnect
        self._rng = self._world_rng = np.random.default_rng(0)

    def begin_episode(self, rng: np.random.Generator, world_rng: np.random.Generator) -> None:
        """Set the random generators of a new episode.

        Args:
            rng: Draws the placement errors.
            world_rng: For the reset of the world.
        """
        self.requests = []
        self._rng, self._world_rng = rng, world_rng

    def __call__(self, request: OperatorRequest) -> None:
        """Carry out a request.

        Raises:
            OperatorGaveUp: The same request was repeated too often, or there is no room.
        """
        self.requests.append(request)
        recent = self.requests[-self.max_repeats :]
        if len(recent) == self.max_repeats and all(r.errors and r[:3] == request[:3] for r in recent):
            raise OperatorGaveUp(
                f"the virtual operator has placed everything {self.max_repeats} times: {'; '.join(request.errors)}"
            )
        if not request.robots and request.foods is None:
            self._reconnect()
            return
        for _ in range(_MAX_TRIES):
            try:
                self._place(request)
            except ValueError as error:  # in a wall, or on top of something: draw other errors
                reason = error
            else:
                return
        raise OperatorGaveUp(f"the virtual operator finds no room: {reason}")

    def _place(self, request: OperatorRequest) -> None:
        poses = [self._with_error(mark.pose) for mark in request.robots]
        if request.foods is None:
            for mark, pose in zip(request.robots, poses, strict=True):
                self._world.place(mark.number, pose)
            return
        foods = tuple(Point(*self._with_error(Pose(x, y, 0.0))[:2]) for x, y in request.foods)
        self._world.reset(self._world_rng, Layout(tuple(poses), foods))
        self._on_reset()

    def _with_error(self, pose: Pose) -> Pose:
        x, y, turn = self._rng.standard_normal(3).tolist()
        error, heading_error = self._noise.placement_error, self._noise.placement_heading_error
        return Pose(pose.x + error * x, pose.y + error * y, pose.heading + math.radians(heading_error * turn))
