"""Why 'orient with food' is missed: what votes when the robot has come next to food with its arm still raised.

It is the moment on which failures hang (5.4.1.2). No simulation is needed to look at it: the votes of an imitator
are a function of its experience and of where the food lies.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.robots.khepera import ARM_RAISED
from khepera_forage.rollouts.rows import STATES
from khepera_forage.task.states import NEXT_TO_FOOD, Behaviour, FoodType, StateVector
from khepera_forage.thesis.statistics import bootstrap, ratio, replications, tally
from khepera_forage.thesis.tables import Column, Table, Value

BEYOND = (-10, 0, 10, 20, 40, 60)
"""Pixels by which the food lies further from home than in training."""
_ARRIVING = (NEXT_TO_FOOD - 2, NEXT_TO_FOOD - 1, NEXT_TO_FOOD)
"""Pixels to the food at which a robot first finds itself next to it."""


@dataclass(frozen=True, slots=True)
class VoteRow:
    """Confidence levels of one imitator on arriving next to food.

    Attributes:
        replication: Number of the repetition of the whole design.
        episodes: Training episodes the imitator had.
        file_id: The thesis' name of its training files.
        beyond: Pixels by which the food lies further from home than in training, on the line of training.
        orient: Confidence level of ORIENT WITH FOOD, which is correct.
        move_slowly: Of MOVE SLOWLY.
        search: Of SEARCH FOR FOOD.
    """

    replication: int
    episodes: int
    file_id: str
    beyond: int
    orient: float
    move_slowly: float
    search: float


def arrivals(training_distance: int) -> NDArray[np.int64]:
    """What a robot perceives on arriving next to food, for food at several distances from home.

    Args:
        training_distance: Pixels between food and home in training.

    Returns:
        State vectors, of shape (distances, ways of arriving, 5), in the order of `BEYOND`.
    """
    return np.array(
        [
            [
                StateVector(0, training_distance + beyond + food, FoodType.UNKNOWN, ARM_RAISED, food)
                for food in _ARRIVING
            ]
            for beyond in BEYOND
        ]
    )


def levels_of(imitator: NearestNeighbourImitator, vectors: NDArray[np.int64]) -> NDArray[np.float64]:
    """Confidence levels (4.6.2) of the ten behaviours, in the last axis.

    Args:
        imitator: Fitted.
        vectors: State vectors in the last axis, of any shape before it.
    """
    levels = np.zeros((*vectors.shape[:-1], STATES))
    for place in np.ndindex(vectors.shape[:-1]):
        for behaviour, level in imitator.confidence_levels(StateVector(*vectors[place].tolist())).items():
            levels[place][behaviour] = level
    return levels


def votes(levels: NDArray[np.float64], replication: int, episodes: int, file_id: str) -> list[VoteRow]:
    """What one imitator says to `arrivals`.

    Args:
        levels: Its confidence levels of the ten behaviours, of shape (distances, ways of arriving, 10).
        replication: For the rows.
        episodes: For the rows.
        file_id: For the rows.
    """
    asked = (Behaviour.ORIENT_WITH_FOOD, Behaviour.MOVE_SLOWLY, Behaviour.SEARCH_FOR_FOOD)
    means = levels.mean(axis=1)
    return [
        VoteRow(replication, episodes, file_id, beyond, *(round(float(mean[b]), 6) for b in asked))
        for beyond, mean in zip(BEYOND, means, strict=True)
    ]


def vote_table(rows: Sequence[VoteRow], rng: np.random.Generator) -> Table:
    """Mean confidence level of ORIENT by place of the food and amount of training.

    Args:
        rows: Of one noise condition.
        rng: Draws the resamples.
    """
    episodes = sorted({row.episodes for row in rows})
    lines: list[tuple[Value, ...]] = []
    for beyond in BEYOND:
        levels: list[Value] = []
        for count in episodes:
            cell = [row for row in rows if (row.beyond, row.episodes) == (beyond, count)]
            sums = tally(cell, replications(cell), lambda row: 100 * row.orient, lambda row: 1.0)
            levels.append(bootstrap(sums, ratio, rng))
        if levels:
            lines.append((f"{beyond:+d}" if beyond else "0", *levels))
    return Table(
        "votes",
        "Why 'orient with food' is missed",
        "Confidence level (%) of 'orient with food' at the moment a robot arrives next to food with its arm still "
        "raised, by how many pixels further from home the food lies than in training. In training the arm is "
        "lowered as soon as the robot orients, so an episode adds one or two such vectors beside some twenty of "
        "'move slowly' and 'search'; and as start, food and home lie on one line, all of these are about equally "
        "far from a robot next to food that lies further out: the vote is then a draw among them.",
        (Column("pixels beyond"), *(Column(f"{count} episodes", 1, estimate=True) for count in episodes)),
        lines,
    )
