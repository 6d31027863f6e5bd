"""Parameters: the records that all worlds of a batch have in common."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.geometry.walls import wall_of
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.records import constants_dtype, corner_dtype, wall_dtype
from khepera_forage.sim.layout_checks import cable_anchor
from khepera_forage.sim.world import Timing


class Parameters(NamedTuple):
    """What is the same in every world of a batch.

    Attributes:
        foods: Number of food objects in a world.
        walls: `wall_dtype`, one record a wall.
        corners: `corner_dtype`, one record a corner that points into the floor.
        constants: `constants_dtype`, shape (1,). Kernels read them at run time: another value compiles nothing.
        arenas: `arena_dtype`, one record an arena, if worlds are in different ones: walls and corners are then those
            of all arenas. Otherwise an empty tuple.
    """

    foods: int
    walls: NDArray[Any]
    corners: NDArray[Any]
    constants: NDArray[Any]
    arenas: Any = ()


def parameters_of(
    arena: Arena,
    foods: int,
    noise: Noise | str | None = None,
    *,
    holes: int,
    timing: Timing,
    wheel_speed: float = 1.0,
    anchor: tuple[float, float] | None = None,
) -> Parameters:
    """The parameters of worlds in one arena.

    Args:
        arena: The arena of every world.
        foods: Number of food objects in a world.
        noise: By default `Noise.laboratory()`.
        holes: Holes of the robots' marker, 1 or 2.
        timing: Duration of a round, and speeds of arm and jaw.
        wheel_speed: Share of the commanded speed that wheels reach.
        anchor: Where the cable hangs from, mm; by default above the middle of the arena.
    """
    constants = np.zeros(1, constants_dtype)
    _write_noise(constants, checked_noise(noise), holes)
    constants["anchor_x"], constants["anchor_y"] = cable_anchor([arena]) if anchor is None else anchor
    constants["wheel_speed"] = wheel_speed
    for name, value in timing._asdict().items():
        constants[name] = value
    return Parameters(
        foods, _walls_of(arena), np.array([(x, y) for x, y, _, _ in arena.corners], corner_dtype), constants
    )


def _walls_of(arena: Arena) -> NDArray[Any]:
    names, walls = wall_dtype.names or (), map(wall_of, arena.segments)
    return np.array([tuple(getattr(wall, name) for name in names) for wall in walls], wall_dtype)


def _write_noise(constants: NDArray[Any], noise: Noise, holes: int) -> None:
    for name in (
        *("wheel_slip", "wheel_bias", "proximity_gain", "proximity_floor"),
        *("position_jitter", "heading_jitter", "reversal_rate", "loss_rate_food", "cable_loss_factor"),
    ):
        constants[name] = getattr(noise, name)
    constants["loss_rate_marker"] = noise.loss_rate_one_hole if holes == 1 else noise.loss_rate_two_holes
    constants["loss_end"] = 1.0 / noise.loss_rounds
