"""What every world of a batch knows of its arena and of its task, as plain arrays for the kernels."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import FoodOdds, food_odds, the_arena, whole_number
from khepera_forage.envs.forager import site_of
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled.parameters import Setting, setting_of
from khepera_forage.sim.compiled.rows import MOST_FOODS
from khepera_forage.sim.layout_checks import check_seen


class Rules(NamedTuple):
    """What holds for the task in every world of a batch.

    Attributes:
        place: See `site_array`.
        walls: See `site_walls`.
        arena: See `arena_array`.
        odds: Of the food types that are drawn.
        limit: Steps after which an episode ends.
    """

    place: NDArray[np.float64]
    walls: NDArray[np.float64]
    arena: NDArray[np.float64]
    odds: NDArray[np.float64]
    limit: int


def rules_of(
    arena: Arena | str,
    foods: int,
    limit: int,
    noise: Noise | None,
    food_types: FoodOdds,
    wheel_speed: float = 1.0,
) -> tuple[Setting, Rules]:
    """What holds in the worlds of recalls, for the bodies and for the task.

    Args:
        arena: As for the environments.
        foods: Food objects in each world, 1 to 16.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles by default.
        food_types: One type, or odds by type.
        wheel_speed: Share of the commanded speed that wheels reach.

    Raises:
        ValueError: An argument out of range, or an arena that the camera does not see.
    """
    the = the_arena(arena)
    check_seen([the])
    if whole_number("foods", foods, 1) > MOST_FOODS:
        raise ValueError(f"foods is {foods!r}; allowed: 1 to {MOST_FOODS} in a batch")
    limit = whole_number("limit", limit, 1)
    rules = Rules(site_array(the), site_walls(the), arena_array(the), np.array(food_odds(food_types)), limit)
    return setting_of(the, foods, noise, wheel_speed=wheel_speed), rules


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
