"""Many compiled worlds of bodies, for tests."""

from typing import Any

import numpy as np

from khepera_forage.compilation import entry, share_out
from khepera_forage.counter_rng import keys_of
from khepera_forage.noise import Noise
from khepera_forage.records import array_of
from khepera_forage.robots.khepera import ARM_ON_FLOOR
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.world import (
    advance,
    corner_dtype,
    detection_dtype,
    food_dtype,
    robot_dtype,
    track_dtype,
    wall_dtype,
)
from khepera_forage.sim.driving import put_down
from khepera_forage.sim.layout_checks import cable_anchor
from khepera_forage.sim.records import Enclosure, constants_of
from khepera_forage.sim.sensing import forget_tracks
from tests.version_0_1 import TIMING


@entry
def _advance(
    first: int,
    last: int,
    robots: Any,
    foods: Any,
    tracks: Any,
    detections: Any,
    walls: Any,
    corners: Any,
    anchor: Any,
    constants: Any,
    starts: Any,
) -> None:
    for i in range(first, last):
        if len(starts) > 0:
            put_down(robots[i, 0], starts[i, 0], starts[i, 1], starts[i, 2], constants[0])
            forget_tracks(foods[i], tracks[i])
        anchor_x, anchor_y = anchor[0], anchor[1]
        world = Enclosure(robots[i], foods[i], tracks[i], detections[i], walls, corners)
        advance(world, anchor_x, anchor_y, constants[0])


class ManyWorlds:
    """Worlds of one robot and its food each.

    Args:
        arena: Of every world.
        worlds: How many.
        foods: Food objects in each.
        noise: By default `Noise.laboratory()`.
    """

    def __init__(self, arena: Arena, worlds: int, foods: int = 1, noise: Noise | None = None) -> None:
        self.worlds = worlds
        self._walls = np.array(list(map(tuple, arena.wall_records)), wall_dtype)
        self._corners = np.array([corner[:2] for corner in arena.corners], corner_dtype)
        self._anchor = np.array(cable_anchor([arena]))
        self._constants = array_of(constants_of(noise or Noise.laboratory(), TIMING))
        self.robots = np.zeros((worlds, 1), robot_dtype)
        self.robots["holes"] = 2
        self.foods = np.zeros((worlds, foods), food_dtype)
        self._tracks = np.zeros((worlds, 2 * foods), track_dtype)
        self.detections = np.zeros((worlds, foods), detection_dtype)

    def reset(self, seed: int, starts: Any, foods: Any) -> None:
        """Put everything in its place: poses (worlds, 3) or (3,), food places (worlds, foods, 2) or (foods, 2)."""
        self.robots["key"][:, 0] = keys_of(np.uint64(seed) + np.arange(self.worlds, dtype=np.uint64))
        self.robots["round"] = 0
        self.foods["x"], self.foods["y"] = np.moveaxis(np.asarray(foods, float), -1, 0)
        self._run(
            np.broadcast_to(np.asarray(starts, float), (self.worlds, 3)).copy()
        )  # takes the first frame

    def advance(self, motors: Any) -> None:
        """One round by whole motor commands, shape (worlds, 4) or (4,)."""
        given = np.broadcast_to(np.asarray(motors, float), (self.worlds, 4))
        for n, name in enumerate(("left", "right", "arm_target", "jaw_target")):
            self.robots[name][:, 0] = given[:, n]
        self._run(np.zeros((0, 3)))

    def _run(self, starts: Any) -> None:
        share_out(
            _advance,
            self.worlds,
            *(self.robots, self.foods, self._tracks, self.detections, self._walls, self._corners),
            *(self._anchor, self._constants, starts),
        )

    def robot(self, name: str) -> Any:
        """A field of the robots, one row a world."""
        return self.robots[name][:, 0]

    def food(self, name: str) -> Any:
        """A field of the food, shape (worlds, foods)."""
        return self.foods[name]

    def tracks(self) -> Any:
        """The food's tracks, shape (worlds, 2 * foods)."""
        return self._tracks

    def poses(self) -> Any:
        """x mm, y mm and heading of the robots, shape (worlds, 3)."""
        return np.stack([self.robot(name) for name in ("x", "y", "heading")], axis=1)

    def lifted(self) -> Any:
        """Whether a raised gripper holds each food object, shape (worlds, foods)."""
        held, raised = self.robot("held"), self.robot("arm") < ARM_ON_FLOOR
        return (held[:, None] == np.arange(self.foods.shape[1])) & raised[:, None]
