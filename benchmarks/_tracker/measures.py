"""Errors, losses and slips of identity, from sights."""

import math
from collections.abc import Iterable, Sequence
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from _tracker.sights import Sight
from khepera_forage.thesis.statistics import Estimate, wilson

REVERSED = 90.0
"""Degrees of error beyond which a heading counts as the wrong way round."""


class Errors(NamedTuple):
    """Of found regions: distance of centres in pixels, headings in degrees (the reversed ones left out)."""

    centre: NDArray[np.float64]
    heading: NDArray[np.float64]
    reversals: int


class Losses(NamedTuple):
    """Losses of things that nothing hides.

    Attributes:
        exposed: Rounds in which a thing found a round ago could be lost.
        lost: In how many it was.
        lengths: Rounds of each loss that ended while the thing was clear to see.
    """

    exposed: int
    lost: int
    lengths: tuple[int, ...]

    @property
    def rate(self) -> Estimate:
        """Losses a round, with Wilson's interval; losses are taken for independent."""
        if self.exposed == 0:
            return Estimate(math.nan, math.nan, math.nan)
        return wilson(self.lost, self.exposed)


def errors(rows: Iterable[Sight]) -> Errors:
    """Errors of what was found and clear to see."""
    found = [row for row in rows if row.found and row.clear]
    turns = np.array([row.turn for row in found if not math.isnan(row.turn)])
    back = np.abs(turns) > REVERSED
    centre = np.array([math.hypot(row.dx, row.dy) for row in found])
    return Errors(centre, np.abs(turns[~back]), int(back.sum()))


def jitter(rows: Iterable[Sight]) -> tuple[float, float]:
    """Standard deviation of the centre along one axis in pixels, and of the heading in degrees; nan without any."""
    found = [row for row in rows if row.found and row.clear]
    along = np.array([value for row in found for value in (row.dx, row.dy)])
    turns = np.array([row.turn for row in found if abs(row.turn) <= REVERSED])
    return float(along.std()) if len(along) else math.nan, float(turns.std()) if len(turns) else math.nan


def losses(rows: Iterable[Sight], cable: bool) -> Losses:
    """Losses that began with, or without, a cable over the thing."""
    exposed = lost = 0
    lengths: list[int] = []
    for track in _tracks(rows):
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


def relabelled(rows: Iterable[Sight]) -> int:
    """How often one label went from one thing to another: an identity swapped."""
    swaps = 0
    whose: dict[tuple[str, int, int, int], tuple[str, int]] = {}
    for row in sorted(rows, key=lambda r: (r.camera, r.drive, r.frame)):
        if row.found:
            thing = (row.kind, row.thing)
            label = (row.camera, row.drive, row.frame // 100_000, row.label)
            swaps += whose.get(label, thing) != thing
            whose[label] = thing
    return swaps


def share(part: int, whole: int) -> Estimate:
    """In percent, with Wilson's interval."""
    if whole == 0:
        return Estimate(math.nan, math.nan, math.nan)
    return Estimate(*(100 * value for value in wilson(part, whole)))


def _tracks(rows: Iterable[Sight]) -> Iterable[Sequence[Sight]]:
    """The sights of each thing of each drive, in the order of frames."""

    def whose(row: Sight) -> tuple[str, int, str, int]:
        return row.camera, row.drive, row.kind, row.thing

    for _, track in groupby(sorted(rows, key=lambda r: (whose(r), r.frame)), whose):
        yield list(track)
