"""Who decides in each lane of a block, what is decided, and the account of it: teacher, imitators, chance."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.policies import ballot
from khepera_forage.policies.ballot import BEHAVIOURS, Memories, draw, plane_key, vote
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.numbers import upper, word
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.states import CLOSE_TO_FOOD, Behaviour

TEACHER, UNIFORM = -1, -2
"""Policies that need no memory: the teacher, and every behaviour equally likely; from 0 on, imitators."""

# Rows of an account: who decides; by state how many rounds, and how many in which the teacher would have done something
# else; rounds of ORIENT WITH FOOD with no food near that the teacher would not have; ties, and conflicts among them.
POLICY, ROUNDS, WRONG, GHOSTS, TIES, CONFLICTS, ACCOUNT_ROWS = 0, 1, 11, 21, 22, 23, 24

# Columns of a lane's ballot, behind the votes of each behaviour: their sum, and on which state vector (-1: none yet).
TOTAL, ASKED, BALLOT_COLUMNS = BEHAVIOURS, BEHAVIOURS + 1, BEHAVIOURS + 2
_BEYOND = 1 << 16  # pixels

_DRAWS, _POLICY = np.uint64(body.DRAWS), np.uint64(body.DRAW_POLICY)
_ORIENT = float(Behaviour.ORIENT_WITH_FOOD)


class Decisions(NamedTuple):
    """Who decides, and what came of it: one row of an array a thread, or the arrays of one.

    Attributes:
        accounts: `ACCOUNT_ROWS` rows.
        ballots: One row a lane, `BALLOT_COLUMNS` each; a state vector that stays is not voted on again.
    """

    accounts: NDArray[np.float64]
    ballots: NDArray[np.int64]


def empty_decisions(threads: int) -> Decisions:
    """Room for the block that each thread plays."""
    return Decisions(
        np.zeros((threads, ACCOUNT_ROWS * LANES)), np.zeros((threads, LANES, BALLOT_COLUMNS), np.int64)
    )


@inline
def decisions_of(decisions: Decisions, thread: int) -> Decisions:
    """Those of one thread."""
    return Decisions(decisions.accounts[thread], decisions.ballots[thread])


for _function in (plane_key, ballot._below, ballot._poll, vote, draw):
    inline(_function)


@kernel
def choose(
    worlds: Worlds,
    diagonal: int,
    memories: Memories,
    decisions: Decisions,
) -> None:
    """Decide on a behaviour in every lane.

    Args:
        worlds: Of the block.
        diagonal: Of the arena, pixels: no distance seems longer to an imitator, as in `BehavioursEnv`.
        memories: Of all imitators.
        decisions: Of the block; the account gets ties and conflicts.
    """
    accounts, ballots = decisions.accounts, decisions.ballots
    s, t, keys = worlds.bodies.robots, worlds.tasks, worlds.bodies.keys
    # States and behaviours stand one to one (4.4.1).
    for i in range(LANES):
        t[at.BEHAVIOUR * LANES + i] = t[at.STATE * LANES + i]
    for i in range(LANES):
        policy = int(accounts[POLICY * LANES + i])
        if policy == TEACHER or s[body.NEW * LANES + i] != 0.0:  # before the first frame nothing is perceived
            continue
        number = keys[body.ROUND * LANES + i] * _DRAWS + _POLICY
        chance = upper(word(keys[body.KEY * LANES + i], number))
        if policy == UNIFORM:
            t[at.BEHAVIOUR * LANES + i] = int(chance * BEHAVIOURS)
            continue
        vector = (
            int(t[at.PRESENCE * LANES + i]),
            min(int(t[at.HOME_DISTANCE * LANES + i]), diagonal),
            int(t[at.VECTOR_TYPE * LANES + i]),
            int(t[at.VECTOR_ARM * LANES + i]),
            min(int(t[at.FOOD_DISTANCE * LANES + i]), diagonal),
        )
        presence, home, food_type, arm, food = vector
        asked = (plane_key(presence, food_type, arm) * _BEYOND + home) * _BEYOND + food
        counts = ballots[i]
        if counts[ASKED] != asked:
            counts[TOTAL] = vote(memories, policy, vector, diagonal, counts)
            counts[ASKED] = asked
        total = counts[TOTAL]
        behaviour = draw(counts, total, chance)
        t[at.BEHAVIOUR * LANES + i] = behaviour
        accounts[TIES * LANES + i] += 1.0 if total > 1 else 0.0
        accounts[CONFLICTS * LANES + i] += 1.0 if counts[behaviour] < total else 0.0


@kernel
def account(worlds: Worlds, decisions: Decisions) -> None:
    """Note what kind of round it is, and whether the teacher would do the same."""
    s, t, accounts = worlds.bodies.robots, worlds.tasks, decisions.accounts
    for i in range(LANES):
        state, counts = int(t[at.STATE * LANES + i]), 1.0 - s[body.NEW * LANES + i]
        wrong = t[at.BEHAVIOUR * LANES + i] != t[at.STATE * LANES + i]
        accounts[(ROUNDS + state) * LANES + i] += counts
        accounts[(WRONG + state) * LANES + i] += counts if wrong else 0.0
    for i in range(LANES):
        ghost = (
            t[at.BEHAVIOUR * LANES + i] == _ORIENT
            and t[at.STATE * LANES + i] != _ORIENT
            and t[at.FOOD_DISTANCE * LANES + i] > CLOSE_TO_FOOD
            and s[body.NEW * LANES + i] == 0.0
        )
        accounts[GHOSTS * LANES + i] += 1.0 if ghost else 0.0
