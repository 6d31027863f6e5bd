"""What becomes of the food (`task.food_tracking`), in every world of a block.

Mostly every track shows the object it is tied to, and nothing is odd: those worlds are done together. Where a track is
new, or shows another object than its place in memory says, the register's rule runs in full, one world at a time. A
track's tie is the number noted beside it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack, packed
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.envs.compiled import compiled_rules  # noqa: F401 (the first is needed before any kernel)
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.ties import pick_among_all, tie
from khepera_forage.robots.khepera import Motors, Senses
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.food_tracking import _GRIPPER
from khepera_forage.task.identification import at_home, explored
from khepera_forage.task.perception import _OUTSIDE
from khepera_forage.task.states import FoodType

_GRIP_X, _GRIP_Y, _ODD, _NEAREST, _EXPLORED, _LANE = (body.SCRATCH + n for n in range(6))
_UNKNOWN, _POISONOUS = float(FoodType.UNKNOWN), float(FoodType.POISONOUS)


@kernel
def update(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    t: NDArray[np.float64],
    q: NDArray[np.float64],
    foods: int,
    place: NDArray[np.float64],
) -> None:
    """Take in what one round has brought, and pick the nearest candidate food and the type of what is gripped.

    Args:
        s: The robots' rows.
        w: The work rows.
        f: The food's rows.
        t: The task's rows.
        q: The register's rows of the food.
        foods: Number of food objects in a world.
        place: What a robot knows of its arena.
    """
    _grip(s, w, t, q, foods)
    x1, y1, x2, y2 = place[5] - _OUTSIDE, place[6] - _OUTSIDE, place[7] + _OUTSIDE, place[8] + _OUTSIDE
    home_x, home_y, home_radius = place[0], place[1], place[2]
    for i in range(LANES):
        w[_ODD * LANES + i] = s[body.GHOSTS * LANES + i]
    for food in range(foods):
        base, mine = food * body.FOOD_ROWS * LANES, food * at.TASK_FOOD_ROWS * LANES
        for i in range(LANES):
            x, y = f[base + body.TRACK_X * LANES + i], f[base + body.TRACK_Y * LANES + i]
            inside = x1 <= x and x <= x2 and y1 <= y and y <= y2
            note = f[base + body.NOTE * LANES + i]
            odd = f[base + body.TRACK * LANES + i] >= 0.0 and (note != food or not inside)
            w[_ODD * LANES + i] = 1.0 if odd else w[_ODD * LANES + i]
    for food in range(foods):
        base, mine = food * body.FOOD_ROWS * LANES, food * at.TASK_FOOD_ROWS * LANES
        for i in range(LANES):
            x, y = f[base + body.TRACK_X * LANES + i], f[base + body.TRACK_Y * LANES + i]
            lies = (
                w[_ODD * LANES + i] == 0.0
                and f[base + body.TRACK_FOUND * LANES + i] != 0.0
                and t[at.HELD * LANES + i] != food
            )
            q[mine + at.CARRIED * LANES + i] = 0.0 if lies else q[mine + at.CARRIED * LANES + i]
            q[mine + at.PLACE_X * LANES + i] = x if lies else q[mine + at.PLACE_X * LANES + i]
            q[mine + at.PLACE_Y * LANES + i] = y if lies else q[mine + at.PLACE_Y * LANES + i]
            home = lies and at_home(x, y, home_x, home_y, home_radius)
            known = q[mine + at.KNOWN * LANES + i]
            comes = home and q[mine + at.HOME * LANES + i] == 0.0
            q[mine + at.KNOWN * LANES + i] = q[mine + at.TYPE * LANES + i] if comes else known
            q[mine + at.HOME * LANES + i] = 1.0 if home else q[mine + at.HOME * LANES + i]
    odd_ones = pack(w, _ODD, _LANE, 0)
    for n in range(odd_ones):
        tie(f, t, q, foods, packed(w, _LANE, n), place)
    _count_and_pick(s, w, f, t, q, foods)
    for n in range(odd_ones):
        pick_among_all(s, f, t, q, foods, packed(w, _LANE, n), place)


@inline
def _grip(
    s: NDArray[np.float64], w: NDArray[np.float64], t: NDArray[np.float64], q: NDArray[np.float64], foods: int
) -> None:
    """Which object is in the gripper, and whether it has been explored."""
    for i in range(LANES):
        c, d = cosine_sine(s[body.OWN_DEGREES * LANES + i] * (math.pi / 180.0))
        w[_GRIP_X * LANES + i] = s[body.OWN_X * LANES + i] + _GRIPPER * c
        w[_GRIP_Y * LANES + i] = s[body.OWN_Y * LANES + i] + _GRIPPER * d
        before = _senses(
            t[at.BEFORE_PRESENT * LANES + i], t[at.BEFORE_ARM * LANES + i], t[at.BEFORE_JAW * LANES + i]
        )
        after = _senses(
            s[body.PRESENT * LANES + i], s[body.ARM_READ * LANES + i], s[body.JAW_READ * LANES + i]
        )
        applied = Motors(s[body.LEFT * LANES + i], s[body.RIGHT * LANES + i], 0, 0)
        w[_EXPLORED * LANES + i] = 1.0 if explored(before, after, applied) else 0.0
        # Picked below: the nearest of all objects when something is newly in the barrier.
        w[_NEAREST * LANES + i] = np.inf
        new = s[body.PRESENT * LANES + i] == 0.0 or t[at.HELD * LANES + i] < 0.0
        t[at.HELD * LANES + i] = -1.0 if new else t[at.HELD * LANES + i]
        w[_ODD * LANES + i] = 1.0 if new and s[body.PRESENT * LANES + i] != 0.0 else 0.0
    for food in range(foods):
        mine = food * at.TASK_FOOD_ROWS * LANES
        for i in range(LANES):
            dx = q[mine + at.PLACE_X * LANES + i] - w[_GRIP_X * LANES + i]
            dy = q[mine + at.PLACE_Y * LANES + i] - w[_GRIP_Y * LANES + i]
            squared = dx * dx + dy * dy
            nearer = w[_ODD * LANES + i] != 0.0 and squared < w[_NEAREST * LANES + i]
            w[_NEAREST * LANES + i] = squared if nearer else w[_NEAREST * LANES + i]
            t[at.HELD * LANES + i] = food if nearer else t[at.HELD * LANES + i]
    for food in range(foods):
        mine = food * at.TASK_FOOD_ROWS * LANES
        for i in range(LANES):
            held = t[at.HELD * LANES + i] == food
            known = q[mine + at.KNOWN * LANES + i]
            told = held and known == _UNKNOWN and w[_EXPLORED * LANES + i] != 0.0
            q[mine + at.PLACE_X * LANES + i] = (
                w[_GRIP_X * LANES + i] if held else q[mine + at.PLACE_X * LANES + i]
            )
            q[mine + at.PLACE_Y * LANES + i] = (
                w[_GRIP_Y * LANES + i] if held else q[mine + at.PLACE_Y * LANES + i]
            )
            q[mine + at.CARRIED * LANES + i] = 1.0 if held else q[mine + at.CARRIED * LANES + i]
            q[mine + at.KNOWN * LANES + i] = q[mine + at.TYPE * LANES + i] if told else known


@inline
def _senses(present: float, arm: float, jaw: float) -> Senses:
    return Senses((0, 0, 0, 0, 0, 0, 0, 0), 0, 0, int(arm), int(jaw), int(present))


@inline
def _count_and_pick(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    t: NDArray[np.float64],
    q: NDArray[np.float64],
    foods: int,
) -> None:
    """How much is delivered, which type is in the gripper, and the nearest candidate.

    The last as it is where every track shows the object of its place in memory.
    """
    for i in range(LANES):
        t[at.DELIVERED * LANES + i] = 0.0
        t[at.POISON_HOME * LANES + i] = 0.0
        t[at.DELIVERABLE * LANES + i] = foods
        t[at.FOOD_TYPE * LANES + i] = _UNKNOWN
        w[_NEAREST * LANES + i] = np.inf
        t[at.FOOD_SEEN * LANES + i] = 0.0
        t[at.FOOD_X * LANES + i] = 0.0
        t[at.FOOD_Y * LANES + i] = 0.0
    for food in range(foods):
        base, mine = food * body.FOOD_ROWS * LANES, food * at.TASK_FOOD_ROWS * LANES
        for i in range(LANES):
            known, home = q[mine + at.KNOWN * LANES + i], q[mine + at.HOME * LANES + i]
            poison = 1.0 if known == _POISONOUS else 0.0
            held = t[at.HELD * LANES + i] == food
            t[at.DELIVERED * LANES + i] += home * (1.0 - poison)
            t[at.POISON_HOME * LANES + i] += home * poison
            t[at.DELIVERABLE * LANES + i] -= poison
            t[at.FOOD_TYPE * LANES + i] = known if held else t[at.FOOD_TYPE * LANES + i]
            settled = home != 0.0 or (poison != 0.0 and not held)
            q[mine + at.SETTLED * LANES + i] = 1.0 if settled else 0.0
            x, y = f[base + body.TRACK_X * LANES + i], f[base + body.TRACK_Y * LANES + i]
            dx, dy = x - s[body.OWN_X * LANES + i], y - s[body.OWN_Y * LANES + i]
            squared = dx * dx + dy * dy
            candidate = f[base + body.TRACK * LANES + i] >= 0.0 and not settled
            nearer = candidate and squared < w[_NEAREST * LANES + i]
            w[_NEAREST * LANES + i] = squared if nearer else w[_NEAREST * LANES + i]
            t[at.FOOD_SEEN * LANES + i] = 1.0 if nearer else t[at.FOOD_SEEN * LANES + i]
            t[at.FOOD_X * LANES + i] = x if nearer else t[at.FOOD_X * LANES + i]
            t[at.FOOD_Y * LANES + i] = y if nearer else t[at.FOOD_Y * LANES + i]
