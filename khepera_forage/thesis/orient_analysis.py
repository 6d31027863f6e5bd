"""Why 'orient with food' is missed: the imitator's confidence in it when a robot arrives next to food (5.4.1.2).

No simulation is needed. The confidence levels (4.6.2) depend only on the imitator's experience and on the state vector,
which follows from the place of the food.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Sample, Table, Value, combined, pick, table_of
from khepera_forage.robots.khepera import ARM_RAISED
from khepera_forage.rollouts.rows import STATES
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.task.states import Behaviour, FoodType, StateVector
from khepera_forage.thesis.design import training_distance

if TYPE_CHECKING:
    from khepera_forage.policies import NearestNeighbourImitator

PIXELS_BEYOND = (-10, 0, 10, 20, 40, 60)
"""Places of the food: pixels further from home than in training, on the line of training."""
_STEP = 3
"""Pixels that a robot covers at most in the round in which it arrives next to food."""


@dataclass(frozen=True, slots=True)
class OrientRow:
    """Mean confidence levels of one imitator on arriving next to food at one place.

    Attributes:
        beyond: Pixels by which the food lies further from home than in training.
        orient: Confidence level of ORIENT WITH FOOD, which is correct.
    """

    replication: int
    episodes: int
    file_id: str
    beyond: int
    orient: float
    move_slowly: float
    search: float
    decisions: str = ""


def arrival_vectors(decisions: Decisions) -> NDArray[np.int64]:
    """State vectors of arriving next to food, shape (places of `PIXELS_BEYOND`, distances to the food, 5)."""
    food_to_home = round(training_distance(decisions))
    farther = decisions.equal_distance == "farther state"
    next_to_food = math.ceil(decisions.next_to_food) - 1 if farther else math.floor(decisions.next_to_food)
    return np.array(
        [
            [
                StateVector(0, food_to_home + beyond + food, FoodType.UNKNOWN, ARM_RAISED, food)
                for food in range(next_to_food - _STEP + 1, next_to_food + 1)
            ]
            for beyond in PIXELS_BEYOND
        ]
    )


def imitator_levels(imitator: "NearestNeighbourImitator", vectors: NDArray[np.int64]) -> NDArray[np.float64]:
    """Confidence levels (4.6.2) of the ten behaviours for state vectors, each in the last axis."""
    flat = vectors.reshape(-1, vectors.shape[-1])
    levels = np.zeros((len(flat), STATES))
    levels[:, imitator.classes_] = imitator.predict_proba(flat)
    return levels.reshape(*vectors.shape[:-1], STATES)


def orient_rows(
    levels: NDArray[np.float64], replication: int, episodes: int, file_id: str, decisions: Decisions
) -> list[OrientRow]:
    """The rows of one imitator from its confidence levels for `arrival_vectors`, one for each place."""
    text = decisions_text(decisions)
    shown = (Behaviour.ORIENT_WITH_FOOD, Behaviour.MOVE_SLOWLY, Behaviour.SEARCH_FOR_FOOD)
    rows = []
    for beyond, mean in zip(PIXELS_BEYOND, levels.mean(axis=1), strict=True):
        orient, move_slowly, search = (round(float(mean[behaviour]), 6) for behaviour in shown)
        rows.append(OrientRow(replication, episodes, file_id, beyond, orient, move_slowly, search, text))
    return rows


def orient_table(rows: Sequence[OrientRow], rng: np.random.Generator) -> Table:
    """Mean confidence level of ORIENT WITH FOOD by place of the food and number of training episodes."""
    episodes = sorted({row.episodes for row in rows})
    lines: list[dict[str, Value]] = []
    for beyond in PIXELS_BEYOND if episodes else ():
        line: dict[str, Value] = {"pixels beyond": f"{beyond:+d}" if beyond else "0"}
        for count in episodes:
            cell = pick(rows, beyond=beyond, episodes=count)
            line[f"{count} episodes"] = combined([(1.0, Sample(cell, lambda row: 100 * row.orient))], rng)
        lines.append(line)
    return table_of(
        "orient",
        "Why 'orient with food' is missed",
        "Confidence level (%) of 'orient with food' when a robot arrives next to food with its arm still raised, by "
        "how many pixels further from home the food lies than in training. In training the arm is lowered as soon as "
        "the robot orients, so that an episode records only a few such vectors, against many of 'move slowly' and "
        "'search for food'. Start, food and home lie on one line in training. If the food lies further "
        "from home, many of these vectors are therefore equally near, and the behaviour is drawn among them.",
        lines,
    )
