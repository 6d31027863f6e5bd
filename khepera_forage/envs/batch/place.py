"""What every world of a batch knows of its arena, as plain arrays for the kernels."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.forager import site_of
from khepera_forage.worlds.arena import Arena


def site_array(arena: Arena) -> NDArray[np.float64]:
    """A `Site` without its walls, in pixels: home (x, y, radius), its opening, diagonal, bounds."""
    site = site_of(arena)
    return np.array(
        (site.home_x, site.home_y, site.home_radius, site.home_opening, site.diagonal, *site.bounds)
    )


def site_walls(arena: Arena) -> NDArray[np.float64]:
    """The walls of a `Site`, one a row."""
    return np.array(site_of(arena).walls)


def arena_array(arena: Arena) -> NDArray[np.float64]:
    """Bounds and home in mm, as `placing` has them."""
    return np.array((*arena.bounds, *arena.home, arena.home_radius))
