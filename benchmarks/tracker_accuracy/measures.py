"""Errors, losses and swapped labels of observations."""

import math
from collections.abc import Iterable, Sequence
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Estimate, wilson
from tracker_accuracy.observations import Observation

REVERSED = 90.0
"""Degrees of error from which a heading counts as reversed."""


class Errors(NamedTuple):
    """Errors of found regions that nothing hides.

    Attributes:
        offsets: Of centres in pixels, shape (regions, 2).
        turns: Of headings in degrees, reversed ones left out.
        reversals: Number of reversed headings.
    """

    offsets: NDArray[np.float64]
    turns: NDArray[np.float64]
    reversals: int

    @property
    def distances(self) -> NDArray[np.float64]:
        """Of centres, in pixels."""
        return np.hypot(self.offsets[:, 0], self.offsets[:, 1])

    @property
    def jitter(self) -> tuple[float, float]:
        """Standard deviation of centres along one axis in pixels, and of headings in degrees; nan without any."""
        along, turns = self.offsets.ravel(), self.turns
        return float(along.std()) if len(along) else math.nan, float(turns.std()) if len(turns) else math.nan


class Losses(NamedTuple):
    """Losses of things that nothing hides.

    Attributes:
        exposed: Rounds in which a thing that was found one round before could be lost.
        lost: Rounds among them in which it was lost.
        lengths: Rounds of each loss that ended while nothing hid the thing.
    """

    exposed: int
    lost: int
    lengths: tuple[int, ...]

    @property
    def rate(self) -> Estimate:
        """Losses a round with Wilson's interval, which treats losses as independent."""
        return wilson(self.lost, self.exposed)


def errors(rows: Iterable[Observation]) -> Errors:
    """Errors of all regions that were found and that nothing hides."""
    found = [row for row in rows if row.found and row.clear]
    offsets = np.array([(row.dx, row.dy) for row in found], np.float64).reshape(-1, 2)
    turns = np.array([row.turn for row in found if row.turn is not None], np.float64)
    reversed_ = np.abs(turns) > REVERSED
    return Errors(offsets, turns[~reversed_], int(reversed_.sum()))


def losses(rows: Iterable[Observation], cable: bool) -> Losses:
    """Losses that began with, or without, a cable over the thing."""
    exposed = lost = 0
    lengths: list[int] = []
    for track in _by_thing(rows):
        begun: int | None = None
        for before, now in pairwise(track):
            if now.frame != before.frame + 1 or not (before.clear and now.clear):
                begun = None
                continue
            if before.found and now.cable == cable:
                exposed += 1
                if not now.found:
                    lost += 1
                    begun = now.frame
            elif not before.found and now.found and begun is not None:
                lengths.append(now.frame - begun)
            if now.found:
                begun = None
    return Losses(exposed, lost, tuple(lengths))


def swapped_labels(rows: Iterable[Observation]) -> int:
    """How often a label went from one thing to another within an attempt."""
    swaps = 0
    things: dict[tuple[str, int, int, int], tuple[str, int]] = {}
    for row in sorted(rows, key=lambda r: (r.camera, r.training, r.frame)):
        if row.found:
            thing = (row.kind, row.thing)
            label = (row.camera, row.training, row.frame // 100_000, row.label)
            swaps += things.get(label, thing) != thing
            things[label] = thing
    return swaps


def _by_thing(rows: Iterable[Observation]) -> Iterable[Sequence[Observation]]:
    """The observations of each thing in each training, in the order of frames."""

    def thing(row: Observation) -> tuple[str, int, str, int]:
        return row.camera, row.training, row.kind, row.thing

    for _, track in groupby(sorted(rows, key=lambda r: (thing(r), r.frame)), thing):
        yield list(track)
