"""The register's rule in full, for one world at a time: which object each track shows."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.envs.compiled import compiled_rules  # noqa: F401 (the first is needed before any kernel)
from khepera_forage.envs.compiled import rows as at
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.identification import at_home
from khepera_forage.task.perception import _OUTSIDE


@inline
def _slot(foods: int, slot: int) -> tuple[int, int, int, int]:
    """Rows of a track's label, x, y and note: those of the foods, then the ghosts."""
    if slot < foods:
        base = slot * body.FOOD_ROWS * LANES
        return (
            base + body.TRACK * LANES,
            base + body.TRACK_X * LANES,
            base + body.TRACK_Y * LANES,
            base + body.NOTE * LANES,
        )
    base = (slot - foods) * body.FOOD_ROWS * LANES
    return (
        base + body.GHOST * LANES,
        base + body.GHOST_X * LANES,
        base + body.GHOST_Y * LANES,
        base + body.GHOST_NOTE * LANES,
    )


@inline
def _within(x: float, y: float, place: NDArray[np.float64]) -> bool:
    left, below, right, above = (
        place[5] - _OUTSIDE,
        place[6] - _OUTSIDE,
        place[7] + _OUTSIDE,
        place[8] + _OUTSIDE,
    )
    return bool(left <= x and x <= right and below <= y and y <= above)


@inline
def tie(
    f: NDArray[np.float64],
    t: NDArray[np.float64],
    q: NDArray[np.float64],
    foods: int,
    i: int,
    place: NDArray[np.float64],
) -> None:
    """Tie new tracks to objects, follow them, and see which lie at home: the register's rule, oldest track first."""
    held = int(t[at.HELD * LANES + i])
    last = -1.0
    # Lost tracks, ghosts among them, tell nothing of where an object is.
    for _ in range(foods):
        there, oldest = -1, np.inf
        for slot in range(foods):
            base = slot * body.FOOD_ROWS * LANES + i
            label = f[base + body.TRACK * LANES]
            if last < label and label < oldest and f[base + body.TRACK_FOUND * LANES] != 0.0:
                there, oldest = base, label
        if there < 0:
            break
        last = oldest
        x, y = f[there + body.TRACK_X * LANES], f[there + body.TRACK_Y * LANES]
        if not _within(x, y, place):
            continue
        if f[there + body.NOTE * LANES] < 0.0:
            f[there + body.NOTE * LANES] = _nearest_untied(f, q, foods, i, x, y)
        k = int(f[there + body.NOTE * LANES])
        if k < 0 or k == held:
            continue
        mine = k * at.TASK_FOOD_ROWS * LANES + i
        q[mine + at.CARRIED * LANES] = 0.0
        q[mine + at.PLACE_X * LANES], q[mine + at.PLACE_Y * LANES] = x, y
        if q[mine + at.HOME * LANES] == 0.0 and at_home(x, y, place[0], place[1], place[2]):
            q[mine + at.HOME * LANES] = 1.0
            q[mine + at.KNOWN * LANES] = q[mine + at.TYPE * LANES]
    for slot in range(2 * foods):
        label_row, x_row, y_row, note_row = _slot(foods, slot)
        if f[label_row + i] < 0.0 or not _within(f[x_row + i], f[y_row + i], place):
            f[note_row + i] = -1.0


@inline
def _nearest_untied(
    f: NDArray[np.float64], q: NDArray[np.float64], foods: int, i: int, x: float, y: float
) -> float:
    """The nearest object that no track shows, or that was carried since; -1 without."""
    tied = 0
    for slot in range(2 * foods):
        label_row, _, _, note_row = _slot(foods, slot)
        if f[label_row + i] >= 0.0 and f[note_row + i] >= 0.0:
            tied |= 1 << int(f[note_row + i])
    best, nearest = np.inf, -1.0
    for k in range(foods):
        mine = k * at.TASK_FOOD_ROWS * LANES + i
        if tied >> k & 1 and q[mine + at.CARRIED * LANES] == 0.0:
            continue
        dx, dy = q[mine + at.PLACE_X * LANES] - x, q[mine + at.PLACE_Y * LANES] - y
        if dx * dx + dy * dy < best:
            best, nearest = dx * dx + dy * dy, float(k)
    return nearest


@inline
def pick_among_all(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    t: NDArray[np.float64],
    q: NDArray[np.float64],
    foods: int,
    i: int,
    place: NDArray[np.float64],
) -> None:
    """The nearest candidate of one world, ghosts included, whatever object each track is tied to."""
    best = np.inf
    t[at.FOOD_SEEN * LANES + i] = t[at.FOOD_X * LANES + i] = t[at.FOOD_Y * LANES + i] = 0.0
    for slot in range(2 * foods):
        label_row, x_row, y_row, note_row = _slot(foods, slot)
        k = int(f[note_row + i])
        settled = k >= 0 and q[k * at.TASK_FOOD_ROWS * LANES + at.SETTLED * LANES + i] != 0.0
        dx, dy = f[x_row + i] - s[body.OWN_X * LANES + i], f[y_row + i] - s[body.OWN_Y * LANES + i]
        squared = dx * dx + dy * dy
        candidate = f[label_row + i] >= 0.0 and not settled and _within(f[x_row + i], f[y_row + i], place)
        if candidate and squared < best:
            best = squared
            t[at.FOOD_SEEN * LANES + i] = 1.0
            t[at.FOOD_X * LANES + i], t[at.FOOD_Y * LANES + i] = f[x_row + i], f[y_row + i]
