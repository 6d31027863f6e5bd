"""The operator of the virtual laboratory: puts simulated bodies where it is told, as well as a hand can."""

import math
from collections.abc import Callable

import numpy as np

from khepera_forage.lab.operator import OperatorGaveUp, Request
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout

_TRIES = 200


class VirtualOperator:
    """Does at once what it is asked, off by `Noise.placement_error` and `placement_heading_error`.

    What was asked is kept in `requests`.

    Args:
        world: The bodies.
        noise: How well it places them.
        replaced: Called after a reset of the world, which makes new bodies.
        plug_in: Called when something was lost.

    Attributes:
        requests: Everything asked for since the last `begin`.
        patience: How often in a row it does the same again before it gives up.
    """

    def __init__(
        self,
        world: PymunkWorld,
        noise: Noise,
        replaced: Callable[[], None],
        plug_in: Callable[[], None],
    ) -> None:
        self.requests: list[Request] = []
        self.patience = 10
        self._world, self._noise = world, noise
        self._replaced, self._plug_in = replaced, plug_in
        self._hand = self._bodies = np.random.default_rng(0)

    def begin(self, hand: np.random.Generator, bodies: np.random.Generator) -> None:
        """A new episode.

        Args:
            hand: Draws the errors of placement.
            bodies: Handed to the world at its reset.
        """
        self.requests = []
        self._hand, self._bodies = hand, bodies

    def __call__(self, request: Request) -> None:
        """Do it.

        Raises:
            OperatorGaveUp: The same again and again, or there is no room.
        """
        self.requests.append(request)
        again = self.requests[-self.patience :]
        if len(again) == self.patience and all(r.wrong and r[:3] == request[:3] for r in again):
            raise OperatorGaveUp(
                f"the virtual operator has placed everything {self.patience} times: {'; '.join(request.wrong)}"
            )
        if not request.robots and request.foods is None:
            self._plug_in()
            return
        for _ in range(_TRIES):
            try:
                self._put(request)
            except ValueError as error:  # off the floor, or on top of something: the hand tries again
                trouble = error
            else:
                return
        raise OperatorGaveUp(f"the virtual operator finds no room: {trouble}")

    def _put(self, request: Request) -> None:
        poses = [self._near(mark.pose) for mark in request.robots]
        if request.foods is None:
            for mark, pose in zip(request.robots, poses, strict=True):
                self._world.place(mark.number, pose)
            return
        foods = tuple(Point(*self._near(Pose(x, y, 0.0))[:2]) for x, y in request.foods)
        self._world.reset(self._bodies, Layout(tuple(poses), foods))
        self._replaced()

    def _near(self, pose: Pose) -> Pose:
        x, y, turn = self._hand.standard_normal(3).tolist()
        error, heading_error = self._noise.placement_error, self._noise.placement_heading_error
        return Pose(pose.x + error * x, pose.y + error * y, pose.heading + math.radians(heading_error * turn))
