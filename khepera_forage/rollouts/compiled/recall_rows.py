"""Recalls that ran in a batch, as the rows that the report is made of."""

from typing import Any

import numpy as np

from khepera_forage.rollouts.compiled.recalls import Episodes
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.sim.arena import Arena
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.vision.scene import MM_PER_PIXEL

_NUMBERS = (
    "correct",
    "steps",
    "score",
    "delivered",
    "poison_home",
    "orient_without_food",
    "ties",
    "conflicts",
)
_LISTS = ("food_delivered", "rounds_by_state", "wrong_by_state")


def recall_rows(
    played: Episodes, arena: Arena, own: dict[str, list[Any]], decisions: Decisions, **common: Any
) -> list[RecallRow]:
    """One row an episode.

    Args:
        played: From `run_recalls`.
        arena: Theirs.
        own: Fields of `RecallRow` that an episode cannot know, by name, one value each.
        decisions: Theirs.
        **common: Those that all have in common.
    """
    columns: dict[str, list[Any]] = dict(own)
    for name in _NUMBERS:
        columns[name] = getattr(played, name).tolist()
    for name in _LISTS:
        columns[name] = list(map(tuple, getattr(played, name).tolist()))
    columns["penalty"] = played.penalty.astype(int).tolist()
    home = np.array(arena.home)
    columns["start_x"], columns["start_y"] = _pixels(played.start[:, :2] - home).T.tolist()
    columns["start_heading"] = np.round(np.degrees(played.start[:, 2]), 1).tolist()
    foods = _pixels(played.foods - home)
    columns["food_x"], columns["food_y"] = (list(map(tuple, foods[:, :, k].tolist())) for k in (0, 1))
    common |= {"arena": arena.name, "foods": foods.shape[1], "decisions": decisions_text(decisions)}
    rows = zip(*columns.values(), strict=True)
    return [RecallRow(**common, **dict(zip(columns, row, strict=True))) for row in rows]


def _pixels(places: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.round(places / MM_PER_PIXEL, 2)
