"""Training episodes of teachers and learners wholly inside the kernel: attempts, until an episode is complete (5.2)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance, inline, kernel
from khepera_forage.compilation.work_queue import take
from khepera_forage.envs.compiled.parameters import Rules
from khepera_forage.envs.compiled.rounds import carry_out
from khepera_forage.envs.compiled.worlds import Worlds, worlds_of
from khepera_forage.rollouts.compiled import pair_rows as pair
from khepera_forage.rollouts.compiled.pairing import (
    drive_pair,
    judge,
    keep_company,
    record,
    share_types,
    speak,
)
from khepera_forage.rollouts.compiled.training_placement import Marks, forget, place_side
from khepera_forage.sim.compiled.numbers import word
from khepera_forage.sim.compiled.parameters import Setting
from khepera_forage.sim.compiled.rows import LANES

_ONE, _TYPES = np.uint64(1), np.uint64(1 << 20)


class Terms(NamedTuple):
    """How long is tried.

    Attributes:
        patience: Rounds of separation after which an attempt is given up.
        attempts: Incomplete attempts after which an episode is.
    """

    patience: int
    attempts: int


class Records(NamedTuple):
    """What is written down of training episodes, one row each.

    Attributes:
        vectors: Those of the last attempt, shape (episodes, rounds, `VECTOR_COLUMNS`), as many as its account says.
        accounts: One line an attempt, shape (episodes, attempts, `ACCOUNT_COLUMNS`).
        tried: How many attempts there were.
        free: Whether robots and food found room on their marks.
    """

    vectors: NDArray[np.int16]
    accounts: NDArray[np.int32]
    tried: NDArray[np.int64]
    free: NDArray[np.bool_]


@inline
def _setting_of(setting: Setting, side: int) -> Setting:
    """That of one side, of the stacked settings of both."""
    return Setting(setting.foods, setting.walls[side], setting.corners[side], setting.noise[side])


@inline
def _rules_of(rules: Rules, side: int) -> Rules:
    """Those of one side, of the stacked rules of both."""
    return Rules(rules.place[side], rules.walls[side], rules.arena[side], rules.odds, rules.limit)


@kernel
def _begin(
    pairs: Worlds,
    c: NDArray[np.float64],
    i: int,
    setting: Setting,
    rules: Rules,
    marks: Marks,
    key: np.uint64,
) -> bool:
    """Begin an attempt in one lane; returns whether there was room."""
    forget(c, i)
    free = True
    for side in range(pair.SIDES):
        own = word(key, np.uint64(side))
        worlds, types = worlds_of(pairs, side, 0), word(key, _TYPES)
        placed = place_side(worlds, i, side, own, _setting_of(setting, side), rules.odds, types, marks)
        free = free and placed
    return free


@kernel
def _train(
    pairs: Worlds,
    c: NDArray[np.float64],
    setting: Setting,
    rules: Rules,
    marks: Marks,
    terms: Terms,
    episode_keys: NDArray[np.uint64],
    begun: NDArray[np.int64],
    records: Records,
) -> None:
    """Train episodes in one block of pairs, until there are none left that no thread has taken."""
    episodes = episode_keys.shape[0]
    teachers = worlds_of(pairs, pair.TEACHER, 0)
    learners = worlds_of(pairs, pair.LEARNER, 0)
    place, learners_place = rules.place[pair.TEACHER], rules.place[pair.LEARNER]
    training = 0
    for i in range(LANES):
        # A lane with nothing to do stays as it was made: at rest, far from anything.
        c[pair.OVER * LANES + i] = 1.0
        c[pair.COMPLETE * LANES + i] = 1.0
        c[pair.EPISODE * LANES + i] = -1.0
    over = True
    while over or training > 0:
        if over:
            for i in range(LANES):
                if c[pair.OVER * LANES + i] == 0.0:
                    continue
                episode = int(c[pair.EPISODE * LANES + i])
                attempt = int(c[pair.ATTEMPT * LANES + i]) + 1
                if episode >= 0:
                    _write_down(c, i, episode, attempt, records)
                if c[pair.COMPLETE * LANES + i] != 0.0 or attempt == terms.attempts:
                    coming = take(begun)
                    training += (1 if coming < episodes else 0) - (1 if episode >= 0 else 0)
                    episode, attempt = coming if coming < episodes else -1, 0
                c[pair.EPISODE * LANES + i], c[pair.ATTEMPT * LANES + i] = episode, attempt
                c[pair.OVER * LANES + i] = 0.0
                if episode >= 0:
                    key = word(episode_keys[episode], np.uint64(attempt))
                    if not _begin(pairs, c, i, setting, rules, marks, key):
                        records.free[episode] = False
        speak(teachers, learners, c)
        record(learners.tasks, c, int(learners_place[4]), records.vectors)
        for side in range(pair.SIDES):
            worlds = worlds_of(pairs, side, 0)
            drive_pair(worlds.bodies.robots, worlds.tasks, c, rules.place[side], side == pair.LEARNER)
            if side == pair.LEARNER:
                share_types(teachers.registers, learners.registers, setting.foods)
            carry_out(worlds, _setting_of(setting, side), _rules_of(rules, side))
        share_types(learners.registers, teachers.registers, setting.foods)
        keep_company(teachers.bodies.robots, learners.bodies.robots, c, place, learners_place)
        over = judge(teachers, learners, c, setting.foods, place[2], rules.limit, terms.patience)


@inline
def _write_down(c: NDArray[np.float64], i: int, episode: int, attempt: int, records: Records) -> None:
    """The account of an attempt that has ended."""
    account = records.accounts[episode, attempt - 1]
    account[pair.ACCOUNT_ROUNDS] = int(c[pair.ROUNDS * LANES + i])
    account[pair.ACCOUNT_VECTORS] = int(c[pair.VECTORS * LANES + i])
    account[pair.ACCOUNT_SEPARATIONS] = int(c[pair.SEPARATIONS * LANES + i])
    account[pair.ACCOUNT_COMPLETE] = int(c[pair.COMPLETE * LANES + i])
    records.tried[episode] = attempt


@entrance
def train_all(
    thread: int,
    pairs: Worlds,
    company: NDArray[np.float64],
    setting: Setting,
    rules: Rules,
    marks: Marks,
    terms: Terms,
    episode_keys: NDArray[np.uint64],
    begun: NDArray[np.int64],
    records: Records,
) -> None:
    """Train episodes in the block of one thread, until all are taken."""
    worlds = worlds_of(pairs, thread, thread)
    _train(worlds, company[thread], setting, rules, marks, terms, episode_keys, begun, records)
