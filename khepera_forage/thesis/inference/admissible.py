"""Which laboratories could have been the thesis's: the teacher must be able to do what the thesis says of it.

Only the teacher and training are looked at, no learner.
"""

import math
from typing import NamedTuple

import numpy as np

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.rollouts.compiled.recalls import TEACHER, WITHOUT_ORIENTING, Episodes, run_recalls
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.thesis.design import THESIS
from khepera_forage.thesis.inference.prior import Laboratory

FORAGES = 256
"""Of the teacher, in each arena."""
WITHOUT = 64
"""Forages without orienting, in each arena."""
EPISODES = 64
"""Attempts at a training episode."""
DELIVERED = 0.98
"""Share of the food that the teacher brings home, at least."""
FASTEST = {"corridor": 65, "rectangle": 205}
"""Steps of the fastest recalls in tables A.1 to A.7, without lines that contradict themselves: a learner is not faster
than the teacher can be."""
LUCK = 1.1
"""How much slower than that the fastest of the forages may be, since these need not include the fastest possible."""
COMPLETE = 0.5
""""Quite frequent" (5.3.1): share of attempts at a training episode that are complete, at least."""
ARENAS = {cell.arena: (cell.foods, cell.limit) for cell in THESIS}
"""Food objects and limit by arena (5.4.1.1, 5.4.2.1)."""


class Check(NamedTuple):
    """What was found of a laboratory.

    Attributes:
        reason: Why it is not admissible; empty if it is.
        delivered: Share of the food that the teacher brought home: corridor, rectangle. Not a number if not looked at.
        fastest: Steps of its fastest forage: corridor, rectangle.
        complete: Share of attempts at a training episode that were complete.
    """

    reason: str
    delivered: tuple[float, float]
    fastest: tuple[float, float]
    complete: float


def check(laboratory: Laboratory, seed: int, effort: int = 1) -> Check:
    """Whether a laboratory is admissible; what costs least is looked at first, until a reason is found.

    Args:
        laboratory: Decisions and noise.
        seed: Of the forages.
        effort: How many times as many forages and attempts. A set at the edge of what is admissible may pass a check
            and fail the next one.
    """
    delivered, fastest = [math.nan, math.nan], [math.nan, math.nan]

    def result(reason: str, complete: float = math.nan) -> Check:
        return Check(reason, (delivered[0], delivered[1]), (fastest[0], fastest[1]), complete)

    for k, (arena, (foods, _)) in enumerate(ARENAS.items()):
        forages = _forages(laboratory, arena, TEACHER, effort * FORAGES, seed)
        delivered[k] = float(forages.delivered.sum() / (effort * FORAGES * foods))
        fastest[k] = float(forages.steps.min())
        if delivered[k] < DELIVERED:
            return result(f"the teacher fails in the {arena}")
        if fastest[k] > LUCK * FASTEST[arena]:
            return result(f"too slow in the {arena}")
    for arena in ARENAS:
        if _forages(laboratory, arena, WITHOUT_ORIENTING, effort * WITHOUT, seed).delivered.any():
            return result(f"no ORIENT is needed in the {arena}")
    complete = _complete(laboratory, effort * EPISODES, seed)
    return result("" if complete >= COMPLETE else "training is seldom complete", complete)


def _forages(laboratory: Laboratory, arena: str, policy: int, count: int, seed: int) -> Episodes:
    """Forages from random starts, each with a seed of its own."""
    foods, limit = ARENAS[arena]
    return run_recalls(
        checked_arena(arena, laboratory.decisions),
        None,
        np.full(count, policy),
        seed,
        foods=foods,
        limit=limit,
        noise=laboratory.noise,
        decisions=laboratory.decisions,
    )


def _complete(laboratory: Laboratory, episodes: int, seed: int) -> float:
    """Share of attempts at a training episode that are complete."""
    try:
        trained = train_learners(
            episodes, seed=seed, noise=laboratory.noise, decisions=laboratory.decisions, attempts=10
        )
    except (IncompleteTrainingError, ValueError):  # a mark where robot or food does not fit
        return 0.0
    return float(np.mean(trained.attempts.complete))
