"""Rounds and beginnings of episodes in blocks of worlds: the kernels of `TaskBatch` and of `episodes`."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance, inline, kernel, sequence
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.compilation.work_queue import take
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.food_tracking import update
from khepera_forage.envs.compiled.parameters import Rules
from khepera_forage.envs.compiled.placement import place_all
from khepera_forage.envs.compiled.task import command_motors, drive, perceive, remember
from khepera_forage.envs.compiled.worlds import Worlds, worlds_of
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.numbers import upper, word
from khepera_forage.sim.compiled.parameters import Setting
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.compiled.stepping import advance_block, stand
from khepera_forage.task.identification import drawn_type
from khepera_forage.vision.scene import MM_PER_PIXEL

_PLACES, _TYPES = np.uint64(1 << 40), np.uint64(1 << 41)


@inline
def begin_episode(worlds: Worlds, i: int, setting: Setting, rules: Rules) -> bool:
    """Put robot and food of one world in random places; its first frame is taken in the coming round.

    Returns:
        Whether there was room.
    """
    keys, f, t, q = worlds.bodies.keys, worlds.bodies.food, worlds.tasks, worlds.registers
    foods = setting.foods
    key, round_ = keys[body.KEY * LANES + i], keys[body.ROUND * LANES + i]
    x, y, heading = place_all(f, i, foods, word(key, _PLACES + round_), setting.walls, rules.arena)
    stand(worlds.bodies, i, x, y, heading, setting)
    for row in range(at.TASK_ROWS):
        if row != at.EPISODE:
            t[row * LANES + i] = 0.0
    t[at.HELD * LANES + i] = -1.0
    types = word(key, _TYPES + round_)
    for food in range(foods):
        mine, there = food * at.TASK_FOOD_ROWS * LANES + i, food * body.FOOD_ROWS * LANES + i
        for row in range(at.TASK_FOOD_ROWS):
            q[mine + row * LANES] = 0.0
        q[mine + at.PLACE_X * LANES] = f[there + body.FOOD_X * LANES] / MM_PER_PIXEL
        q[mine + at.PLACE_Y * LANES] = f[there + body.FOOD_Y * LANES] / MM_PER_PIXEL
        draw = upper(word(types, np.uint64(food)))
        q[mine + at.TYPE * LANES] = drawn_type(draw, rules.odds[0], rules.odds[1]).value
    return bool(x == x)


@kernel
def decide(t: NDArray[np.float64], s: NDArray[np.float64]) -> None:
    """Count the step, and whether the teacher would do the same."""
    for i in range(LANES):
        counts = 1.0 - s[body.NEW * LANES + i]
        right = t[at.BEHAVIOUR * LANES + i] == t[at.STATE * LANES + i]
        t[at.STEPS * LANES + i] += counts
        t[at.CORRECT * LANES + i] += counts if right else 0.0


@sequence
def carry_out(worlds: Worlds, setting: Setting, rules: Rules) -> None:
    """One round of bodies and task in every world of a block, once the motors are commanded; and what it is worth."""
    s, w, f = worlds.bodies.robots, worlds.bodies.work, worlds.bodies.food
    t, q = worlds.tasks, worlds.registers
    remember(s, t)
    for i in range(LANES):
        t[at.REWARD * LANES + i] = t[at.POISON_HOME * LANES + i] - t[at.DELIVERED * LANES + i]
        t[at.FRESH * LANES + i] = s[body.NEW * LANES + i]
    advance_block(worlds.bodies, setting)
    update(s, w, f, t, q, setting.foods, rules.place)
    perceive(s, w, t, rules.place, rules.walls)
    limit = rules.limit
    for i in range(LANES):
        fresh = t[at.FRESH * LANES + i] != 0.0
        delivered = t[at.DELIVERED * LANES + i]
        change = t[at.REWARD * LANES + i] + delivered - t[at.POISON_HOME * LANES + i]
        finished = not fresh and delivered == t[at.DELIVERABLE * LANES + i]
        late = not fresh and t[at.STEPS * LANES + i] >= limit
        t[at.REWARD * LANES + i] = 0.0 if fresh else change - 1.0 / limit
        t[at.TERMINATED * LANES + i] = 1.0 if finished else 0.0
        t[at.TRUNCATED * LANES + i] = 1.0 if late and not finished else 0.0


@inline
def _put(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    q: NDArray[np.float64],
    i: int,
    foods: int,
    pose: NDArray[np.float64],
    places: NDArray[np.float64],
) -> None:
    """Stand robot and food where they were asked to; what is not a number stays where it was drawn."""
    if pose[0] == pose[0]:
        s[body.X * LANES + i], s[body.Y * LANES + i], s[body.HEADING * LANES + i] = pose[0], pose[1], pose[2]
        s[body.COS * LANES + i], s[body.SIN * LANES + i] = cosine_sine(pose[2])
    for food in range(foods):
        if places[food, 0] == places[food, 0]:
            there, mine = food * body.FOOD_ROWS * LANES + i, food * at.TASK_FOOD_ROWS * LANES + i
            f[there + body.FOOD_X * LANES], f[there + body.FOOD_Y * LANES] = places[food, 0], places[food, 1]
            q[mine + at.PLACE_X * LANES] = places[food, 0] / MM_PER_PIXEL
            q[mine + at.PLACE_Y * LANES] = places[food, 1] / MM_PER_PIXEL


@kernel
def play_block(
    worlds: Worlds,
    setting: Setting,
    rules: Rules,
    actions: NDArray[np.float64],
    waiting: NDArray[np.bool_] | NDArray[np.float64],
    pose: NDArray[np.float64],
    places: NDArray[np.float64],
) -> None:
    """One round in a block by given actions; lanes that wait begin an episode instead."""
    s, t = worlds.bodies.robots, worlds.tasks
    for i in range(LANES):
        if waiting[i]:
            begin_episode(worlds, i, setting, rules)
            _put(s, worlds.bodies.food, worlds.registers, i, setting.foods, pose, places)
    if actions.shape[1] == 1:
        for i in range(LANES):
            t[at.BEHAVIOUR * LANES + i] = actions[i, 0]
        decide(t, s)
        drive(s, t, rules.place)
    else:
        command_motors(s, t, rules.place, actions)
        decide(t, s)
    carry_out(worlds, setting, rules)


@entrance
def play_all(
    thread: int,
    worlds: Worlds,
    begun: NDArray[np.int64],
    setting: Setting,
    rules: Rules,
    actions: NDArray[np.float64],
    waiting: NDArray[np.bool_],
    pose: NDArray[np.float64],
    places: NDArray[np.float64],
) -> None:
    """One round in every block that no other thread has taken; see `play_block`."""
    block = take(begun)
    while block < worlds.tasks.shape[0]:
        lanes, some = slice(block * LANES, (block + 1) * LANES), worlds_of(worlds, block, thread)
        play_block(some, setting, rules, actions[lanes], waiting[lanes], pose, places)
        block = take(begun)
