"""`OneWorld`: the batch's world on its own, advanced by a kernel of one lane.

All of it lies in one flat array, so that a call hands over one argument: for numba every further array is a tenth of
a microsecond, and a step of the kernel takes less than one.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance, inline
from khepera_forage.compilation.widths import at_width
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.parameters import Rules
from khepera_forage.envs.compiled.rounds import play_block
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.bodies import Bodies
from khepera_forage.sim.compiled.parameters import Setting

Floats = NDArray[np.float64]
FOODS, WALLS, CORNERS, LIMIT, NUMBERS, HEAD = range(6)
"""What the array begins with; `NUMBERS` is how many an action has: 1, a behaviour, or 4, motors."""
_WALL, _SITE_WALL, _CORNER, _NOISE, _PLACE, _ARENA, _ODDS = 8, 5, 2, 14, 9, 7, 3
"""Numbers of a wall in mm, of one in pixels, of a corner, and of each of the arrays of `Setting` and `Rules`."""


class Given(NamedTuple):
    """What a round is to do.

    Attributes:
        action: One behaviour or four motor values, shape (1, n).
        fresh: 1 where a new episode begins instead, shape (1,).
        pose: Where the robot then stands, mm and radians; not a number for a random place.
        places: Where the food then lies, mm, shape (foods, 2).
    """

    action: Floats
    fresh: Floats
    pose: Floats
    places: Floats


@inline
def parts_of(memory: Floats) -> tuple[Worlds, Setting, Rules, Given]:
    """The parts of the array, as views: in Python and in the kernel."""
    foods, walls, corners = int(memory[FOODS]), int(memory[WALLS]), int(memory[CORNERS])
    numbers = int(memory[NUMBERS])
    a = HEAD
    b = a + body.KEY_ROWS
    keys = memory[a:b].view(np.uint64)
    c = b + body.ROBOT_ROWS
    d = c + foods * body.FOOD_ROWS
    e = d + at.TASK_ROWS
    f = e + foods * at.TASK_FOOD_ROWS
    w = f + body.WORK_ROWS
    worlds = Worlds(Bodies(memory[b:c], memory[c:d], keys, memory[f:w]), memory[d:e], memory[e:f])
    g = w + walls * _WALL
    h = g + corners * _CORNER
    i = h + _NOISE
    setting = Setting(
        foods, memory[w:g].reshape(walls, _WALL), memory[g:h].reshape(corners, _CORNER), memory[h:i]
    )
    j = i + _PLACE
    k = j + walls * _SITE_WALL
    m = k + _ARENA
    n = m + _ODDS
    site_walls = memory[j:k].reshape(walls, _SITE_WALL)
    rules = Rules(memory[i:j], site_walls, memory[k:m], memory[m:n], int(memory[LIMIT]))
    o = n + numbers
    p = o + 1
    q = p + 3
    r = q + 2 * foods
    given = Given(memory[n:o].reshape(1, numbers), memory[o:p], memory[p:q], memory[q:r].reshape(foods, 2))
    return worlds, setting, rules, given


def _memory_of(setting: Setting, rules: Rules, numbers: int) -> Floats:
    """An array with everything that never changes in its place, and zeros elsewhere."""
    foods, walls, corners = setting.foods, setting.walls.shape[0], setting.corners.shape[0]
    state = body.KEY_ROWS + body.ROBOT_ROWS + at.TASK_ROWS + foods * (body.FOOD_ROWS + at.TASK_FOOD_ROWS)
    state += body.WORK_ROWS
    return np.concatenate(
        (
            (foods, walls, corners, rules.limit, numbers),
            np.zeros(state),
            *(part.ravel() for part in (setting.walls, setting.corners, setting.noise)),
            *(part.ravel() for part in (rules.place, rules.walls, rules.arena, rules.odds)),
            np.zeros(numbers + 1 + 3 + 2 * foods),
        )
    )


class OneWorld:
    """One world of recalls: what `TaskBatch` is for many. World 0 of a seed is the same in both.

    Args:
        setting: What holds for the bodies.
        rules: What holds for the task.
        numbers: How many an action has: 1, a behaviour, or 4, motors.

    Attributes:
        memory: All of it; `play` advances it.
        worlds: Its rows, one number each.
        given: What the coming round is to do.
    """

    def __init__(self, setting: Setting, rules: Rules, numbers: int) -> None:
        self.__setstate__(_memory_of(setting, rules, numbers))

    def __getstate__(self) -> Floats:
        return self.memory

    def __setstate__(self, memory: Floats) -> None:
        self.memory = memory
        self.worlds, _, _, self.given = parts_of(memory)


_play_alone = at_width(play_block, 1)


@entrance
def play(memory: Floats) -> None:
    """One round of a `OneWorld`, given its memory."""
    worlds, setting, rules, given = parts_of(memory)
    _play_alone(worlds, setting, rules, given.action, given.fresh, given.pose, given.places)
