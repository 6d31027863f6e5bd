"""Whole episodes inside the kernel, whoever decides: no Python runs in between.

A lane takes the next of all episodes whenever it has ended one: no thread waits for another before there are none left.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance, inline, kernel, sequence
from khepera_forage.compilation.work_queue import take
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.parameters import Rules
from khepera_forage.envs.compiled.rounds import begin_episode, carry_out, decide
from khepera_forage.envs.compiled.task import drive
from khepera_forage.envs.compiled.worlds import Worlds, worlds_of
from khepera_forage.policies.ballot import Memories
from khepera_forage.rollouts.compiled.policy_kernel import (
    ACCOUNT_ROWS,
    ASKED,
    POLICY,
    TEACHER,
    Decisions,
    account,
    choose,
    decisions_of,
)
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.parameters import Setting
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.states import FoodType

_POISONOUS = float(FoodType.POISONOUS)
# Columns of `Outcomes.sums`; the last is the first of those of the account, but for who decides.
STEPS, CORRECT, DELIVERED, POISON_HOME, DELIVERABLE, ACCOUNT = range(6)
SUMS = ACCOUNT + ACCOUNT_ROWS - 1


class Plan(NamedTuple):
    """Which episodes are to be played, one element each.

    Attributes:
        keys: Of the world that each is.
        policies: Who decides: `TEACHER`, `UNIFORM`, or the number of a memory.
        begun: A single number: how many were taken by all threads.
    """

    keys: NDArray[np.uint64]
    policies: NDArray[np.int64]
    begun: NDArray[np.int64]


class Outcomes(NamedTuple):
    """What became of the episodes, one row each.

    Attributes:
        sums: `SUMS` columns.
        places: The start's x, y and heading, then x and y of each food object; mm and radians.
        brought: Whether each food object is home and not poisonous.
    """

    sums: NDArray[np.int32]
    places: NDArray[np.float64]
    brought: NDArray[np.bool_]


def empty_outcomes(episodes: int, foods: int) -> Outcomes:
    """Room for some episodes."""
    return Outcomes(
        np.zeros((episodes, SUMS), np.int32),
        np.zeros((episodes, 3 + 2 * foods)),
        np.zeros((episodes, foods), np.bool_),
    )


@sequence
def _play(
    worlds: Worlds,
    setting: Setting,
    rules: Rules,
    memories: Memories,
    plan: Plan,
    decisions: Decisions,
    outcomes: Outcomes,
) -> None:
    """Play episodes in one block, until there are none left that no thread has taken."""
    s, t = worlds.bodies.robots, worlds.tasks
    diagonal = int(rules.place[4])
    playing = 0
    for i in range(LANES):
        playing += _next(worlds, i, setting, rules, plan, decisions, outcomes)
    while playing > 0:
        choose(worlds, diagonal, memories, decisions)
        account(worlds, decisions)
        decide(t, s)
        drive(s, t, rules.place)
        carry_out(worlds, setting, rules)
        for i in range(LANES):
            if t[at.TERMINATED * LANES + i] == 0.0 and t[at.TRUNCATED * LANES + i] == 0.0:
                continue
            episode = int(t[at.EPISODE * LANES + i])
            if episode >= 0:
                _note(worlds, i, setting.foods, decisions.accounts, episode, outcomes)
                playing -= 1
            playing += _next(worlds, i, setting, rules, plan, decisions, outcomes)


@kernel
def _next(
    worlds: Worlds,
    i: int,
    setting: Setting,
    rules: Rules,
    plan: Plan,
    decisions: Decisions,
    outcomes: Outcomes,
) -> int:
    """Begin an episode in a lane, one that does not count when none is left; returns how many begin that count."""
    s, f, last = worlds.bodies.robots, worlds.bodies.food, plan.keys.shape[0] - 1
    episode = take(plan.begun)
    counts = episode <= last
    worlds.tasks[at.EPISODE * LANES + i] = episode if counts else -1
    worlds.bodies.keys[body.KEY * LANES + i] = plan.keys[min(episode, last)]
    worlds.bodies.keys[body.ROUND * LANES + i] = 0
    begin_episode(worlds, i, setting, rules)
    for row in range(ACCOUNT_ROWS):
        decisions.accounts[row * LANES + i] = 0
    decisions.ballots[i, ASKED] = -1
    decisions.accounts[POLICY * LANES + i] = plan.policies[episode] if counts else TEACHER
    if counts:
        for k, row in enumerate((body.X, body.Y, body.HEADING)):
            outcomes.places[episode, k] = s[row * LANES + i]
        for food in range(setting.foods):
            there = food * body.FOOD_ROWS * LANES + i
            outcomes.places[episode, 3 + 2 * food] = f[there + body.FOOD_X * LANES]
            outcomes.places[episode, 4 + 2 * food] = f[there + body.FOOD_Y * LANES]
    return 1 if counts else 0


@inline
def _note(
    worlds: Worlds, i: int, foods: int, accounts: NDArray[np.float64], episode: int, outcomes: Outcomes
) -> None:
    """What has become of an episode that is over."""
    t, q, sums = worlds.tasks, worlds.registers, outcomes.sums
    for column, row in enumerate((at.STEPS, at.CORRECT, at.DELIVERED, at.POISON_HOME, at.DELIVERABLE)):
        sums[episode, column] = int(t[row * LANES + i])
    for row in range(1, ACCOUNT_ROWS):
        sums[episode, ACCOUNT + row - 1] = int(accounts[row * LANES + i])
    for food in range(foods):
        mine = food * at.TASK_FOOD_ROWS * LANES + i
        poison = q[mine + at.KNOWN * LANES] == _POISONOUS
        outcomes.brought[episode, food] = q[mine + at.HOME * LANES] != 0.0 and not poison


@entrance
def play_out(
    thread: int,
    worlds: Worlds,
    setting: Setting,
    rules: Rules,
    memories: Memories,
    plan: Plan,
    decisions: Decisions,
    outcomes: Outcomes,
) -> None:
    """Play episodes in the block of one thread, until all are taken."""
    mine = worlds_of(worlds, thread, thread)
    _play(mine, setting, rules, memories, plan, decisions_of(decisions, thread), outcomes)
