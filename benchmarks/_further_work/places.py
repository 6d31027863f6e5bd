"""Recall in the corridor by where the food lay: nearer home than in training, about as far, or further out."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from _further_work.measures import DELIVERED, SCORE, conditions_of, means_table, pick
from _further_work.rows import Recalled
from khepera_forage.thesis.tables import Table

NEARER, ABOUT, FURTHER = "nearer home", "about as in training", "further out"
PLACES = {NEARER: (-math.inf, -5.0), ABOUT: (-5.0, 15.0), FURTHER: (15.0, math.inf)}
"""Pixels beyond the mark of figure 5.1, from and up to but without; the same as in the experiment on variety."""


def at(rows: Sequence[Recalled], place: str) -> list[Recalled]:
    """The recalls in the corridor whose food lay at one of `PLACES`."""
    low, high = PLACES[place]
    return [row for row in pick(rows, arena="corridor") if low <= row.beyond < high]


def places_table(rows: Sequence[Recalled], amount: int, rng: np.random.Generator) -> Table:
    """Score and food delivered of every condition at every place, after so many training episodes."""
    shown = [
        replace(row, condition=f"{condition}; food {place}")
        for condition in conditions_of(rows)
        for place in PLACES
        for row in at(pick(rows, condition, amount), place)
    ]
    return means_table(
        "places",
        "Where the food lay",
        "Recall in the corridor by how far from home the food lay: more than 5 pixels of 5 mm nearer than the mark of "
        "figure 5.1, at least 15 pixels further out, or between.",
        "episodes",
        shown,
        (SCORE, DELIVERED),
        rng,
    )
