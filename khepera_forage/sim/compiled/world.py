"""`BatchWorld`: many simulated worlds of one robot, its food and a camera, advanced together."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.compilation.threads import BLOCKS_A_THREAD, share_out, threads_for
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_ON_FLOOR,
    ARM_RAISED,
    JAW_CLOSED,
    JAW_OPEN,
    MAX_SPEED,
)
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.bodies import empty_bodies
from khepera_forage.sim.compiled.numbers import keys_of
from khepera_forage.sim.compiled.parameters import setting_of
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.compiled.stepping import advance_all, stand_all
from khepera_forage.sim.layout_checks import check_seen

Floats = NDArray[np.float64]


class BatchSenses(NamedTuple):
    """What the robots report of themselves: the fields of `Senses`, one row or number a world."""

    proximity: NDArray[np.int64]
    left_pulses: NDArray[np.int64]
    right_pulses: NDArray[np.int64]
    arm: NDArray[np.int64]
    jaw: NDArray[np.int64]
    object_presence: NDArray[np.int64]


class BatchScene(NamedTuple):
    """What the cameras report, one row a world; pixels and whole degrees.

    Attributes:
        robots: x, y and orientation of each robot's own region, shape (worlds, 3).
        found: Whether that region is tracked now; otherwise it is lost.
        labels: Of the food's tracks, -1 where there is none, shape (worlds, 2 * foods).
        foods: x and y of those tracks, shape (worlds, 2 * foods, 2).
        foods_found: Whether each is tracked now.
    """

    robots: Floats
    found: NDArray[np.bool_]
    labels: NDArray[np.int64]
    foods: Floats
    foods_found: NDArray[np.bool_]


class BatchWorld:
    """Worlds that do not touch one another, each with one robot, food and a camera above one and the same arena.

    Bodies and camera are those of `PymunkWorld`, in the same units, with the same noise; what differs in contact is
    said in `contact`. Random numbers are counted: what happens in world i of a seed depends on nothing but both.

    Args:
        arena: The enclosure of every world.
        num_worlds: How many.
        foods: Food objects in each, 1 to 16.
        noise: The laboratory's troubles, by default `Noise.laboratory()`.
        holes: Of the robots' marker, 1 or 2.

    Raises:
        ValueError: A number out of range, or an arena that the camera does not see.
    """

    def __init__(
        self, arena: Arena, num_worlds: int, foods: int = 1, noise: Noise | None = None, holes: int = 2
    ) -> None:
        if num_worlds < 1:
            raise ValueError(f"num_worlds is {num_worlds!r}; allowed: at least 1")
        if not 1 <= foods <= at.MOST_FOODS:
            raise ValueError(f"foods is {foods!r}; allowed: 1 to {at.MOST_FOODS} in a batch")
        if holes not in (1, 2):
            raise ValueError(f"holes is {holes!r}; allowed: 1 or 2")
        check_seen([arena])
        self.arena = arena
        self.num_worlds = num_worlds
        self.foods = foods
        self.noise = Noise.laboratory() if noise is None else noise
        blocks = -(-num_worlds // LANES)
        self._bodies = empty_bodies(blocks, foods)
        self._setting = setting_of(arena, foods, self.noise, holes)

    @property
    def bytes_per_world(self) -> float:
        """Memory that a world takes."""
        return float(sum(rows.nbytes for rows in self._bodies) / self._bodies.robots.shape[0] / LANES)

    def reset(self, seed: int, starts: ArrayLike, foods: ArrayLike) -> None:
        """Put everything in its place.

        Args:
            seed: Of all worlds: each draws random numbers of its own.
            starts: x mm, y mm and heading in radians of each robot, shape (worlds, 3) or (3,) for all alike.
            foods: x mm and y mm of each food object, shape (worlds, foods, 2) or (foods, 2).

        Raises:
            ValueError: Arrays of another shape, or with values that are not finite.
        """
        poses = self._all("starts", starts, (3,))
        places = self._all("foods", foods, (self.foods, 2))
        keys = self._bodies.keys
        blocks = keys.shape[0]
        keys[:, at.KEY * LANES : (at.KEY + 1) * LANES] = keys_of(
            seed, np.arange(blocks * LANES).reshape(blocks, LANES)
        )
        keys[:, at.ROUND * LANES : (at.ROUND + 1) * LANES] = 0
        stand_all(self._bodies, self._setting, poses, places)
        self.advance((0, 0, ARM_RAISED, JAW_OPEN))  # nothing moves: the first frame is taken

    def advance(self, motors: ArrayLike) -> None:
        """One round of 0.1 s.

        Args:
            motors: Left and right wheel, arm and jaw of each robot as `Motors` has them, shape (worlds, 4) or (4,).

        Raises:
            ValueError: An array of another shape, or with values that are not finite.
        """
        self._drive(self._all("motors", motors, (4,)))
        threads = threads_for(len(self._bodies.robots) // BLOCKS_A_THREAD)
        share_out(advance_all, threads, self._bodies, np.zeros(1, np.int64), self._setting)

    def senses(self) -> BatchSenses:
        """What the robots sense now."""
        proximity = np.stack([self._row(at.PROXIMITY + n) for n in range(8)], axis=1)
        rows = (at.PULSES_LEFT, at.PULSES_RIGHT, at.ARM_READ, at.JAW_READ, at.PRESENT)
        return BatchSenses(proximity.astype(np.int64), *(self._row(row).astype(np.int64) for row in rows))

    def poses(self) -> Floats:
        """Where the robots truly are: x mm, y mm, heading in radians, shape (worlds, 3)."""
        return np.stack([self._row(row) for row in (at.X, at.Y, at.HEADING)], axis=1)

    def food_places(self) -> Floats:
        """Where the food truly is: x mm, y mm, and 1 where it is lifted, shape (worlds, foods, 3)."""
        held, raised = self._row(at.HELD), self._row(at.ARM) < ARM_ON_FLOOR
        lifted = (held[:, None] == np.arange(self.foods)) & raised[:, None]
        return np.stack([self._food_rows(at.FOOD_X), self._food_rows(at.FOOD_Y), lifted], axis=2)

    def held(self) -> NDArray[np.int64]:
        """Number of the food in each gripper, -1 without."""
        return self._row(at.HELD).astype(np.int64)

    def scene(self) -> BatchScene:
        """What the cameras report now."""
        robots = np.stack([self._row(row) for row in (at.OWN_X, at.OWN_Y, at.OWN_DEGREES)], axis=1)
        x = np.concatenate((self._food_rows(at.TRACK_X), self._food_rows(at.GHOST_X)), axis=1)
        y = np.concatenate((self._food_rows(at.TRACK_Y), self._food_rows(at.GHOST_Y)), axis=1)
        labels = np.concatenate((self._food_rows(at.TRACK), self._food_rows(at.GHOST)), axis=1)
        found = self._food_rows(at.TRACK_FOUND) != 0
        return BatchScene(
            robots,
            self._row(at.OWN_FOUND) != 0,
            labels.astype(np.int64),
            np.stack((x, y), axis=2),
            np.concatenate((found, np.zeros_like(found)), axis=1),
        )

    def _drive(self, motors: Floats) -> None:
        """Take commands as a Khepera does: `applicable` of `robots.khepera` for all."""
        wheels = np.clip(np.floor(motors[:, :2] + 0.5), -MAX_SPEED, MAX_SPEED)
        arm = np.floor(np.clip(motors[:, 2], ARM_RAISED, ARM_DOWN) + 0.5)
        jaw = np.where(motors[:, 3] > JAW_OPEN / 2, JAW_OPEN, JAW_CLOSED)
        for row, values in (
            (at.LEFT, wheels[:, 0]),
            (at.RIGHT, wheels[:, 1]),
            (at.ARM_TO, arm),
            (at.JAW_TO, jaw),
        ):
            self._bodies.robots[:, row * LANES : (row + 1) * LANES] = values.reshape(-1, LANES)

    def _row(self, row: int) -> Floats:
        return self._bodies.robots[:, row * LANES : (row + 1) * LANES].reshape(-1)[: self.num_worlds]

    def _food_rows(self, row: int) -> Floats:
        rows = self._bodies.food.reshape(-1, self.foods, at.FOOD_ROWS, LANES)[:, :, row]
        return rows.transpose(0, 2, 1).reshape(-1, self.foods)[: self.num_worlds]

    def _all(self, name: str, values: ArrayLike, shape: tuple[int, ...]) -> Floats:
        """An array with one row a lane; lanes beyond the last world repeat it."""
        array = np.asarray(values, np.float64)
        if array.shape not in (shape, (self.num_worlds, *shape)):
            raise ValueError(
                f"{name} has shape {array.shape}; allowed: {shape} or {(self.num_worlds, *shape)}"
            )
        if not np.isfinite(array).all():
            raise ValueError(f"{name} has values that are not finite; allowed: finite numbers")
        whole = np.empty((self._bodies.robots.shape[0] * LANES, *shape))
        whole[: self.num_worlds] = array
        whole[self.num_worlds :] = array if array.shape == shape else array[-1]
        return whole
