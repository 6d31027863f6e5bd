"""The rule of retracking (`vision.association`) for the food of one robot's world.

Most frames show every object near the track that showed it before, and nothing else is about: those are done for many
worlds at once. Whatever else may happen (a loss, a track without food, food that is seen again) goes through the rule
in full, one world at a time. Both come to what `Tracks` comes to; a test feeds them the same frames.
"""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack, packed
from khepera_forage.robots.khepera import FOOD_RADIUS
from khepera_forage.sim.compiled import parameters as setting
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.camera import covered
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.vision.association import GATE
from khepera_forage.vision.scene import MM_PER_PIXEL

_SURE = 5.0
"""Standard deviations of jitter by which a place must be clear of a marker to count as visible."""
_NEAR, _STRAY = 2.0, 1.0
"""Pixels from its last place, and pixels of jitter, within which an object cannot be taken for another: two objects
are at least 7 pixels apart."""
_STEADY = 0.25
"""Jitter in pixels up to which that holds."""
_SLOW = at.SCRATCH
_OWNER = at.SCRATCH + 1
"""The first of as many rows as there may be food: the slot whose track shows it."""


@kernel
def track(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    foods: int,
    noise: NDArray[np.float64],
) -> None:
    """Bring the tracks of every world of a block up to the frame just taken."""
    jitter = noise[setting.POSITION_JITTER]
    unsteady = 1.0 if jitter > _STEADY else 0.0
    clear = FOOD_RADIUS + _SURE * jitter * MM_PER_PIXEL
    for i in range(LANES):
        w[_SLOW * LANES + i] = max(unsteady, s[at.GHOSTS * LANES + i])
    for food in range(foods):
        base = food * at.FOOD_ROWS * LANES
        for i in range(LANES):
            seen = f[base + at.SEEN * LANES + i] != 0.0
            odd = f[base + at.LOST * LANES + i] != 0.0 or (seen and not _plain(f, base + i))
            w[_SLOW * LANES + i] = 1.0 if odd else w[_SLOW * LANES + i]
    for food in range(foods):
        base = food * at.FOOD_ROWS * LANES
        for i in range(LANES):
            usual = w[_SLOW * LANES + i] == 0.0
            seen = usual and f[base + at.SEEN * LANES + i] != 0.0
            x, y = f[base + at.TRACK_X * LANES + i], f[base + at.TRACK_Y * LANES + i]
            empty = usual and not seen and not covered(x * MM_PER_PIXEL, y * MM_PER_PIXEL, clear, s, i)
            f[base + at.TRACK_X * LANES + i] = f[base + at.SEEN_X * LANES + i] if seen else x
            f[base + at.TRACK_Y * LANES + i] = f[base + at.SEEN_Y * LANES + i] if seen else y
            found = f[base + at.TRACK_FOUND * LANES + i]
            f[base + at.TRACK_FOUND * LANES + i] = (1.0 if seen else 0.0) if usual else found
            f[base + at.TRACK * LANES + i] = -1.0 if empty else f[base + at.TRACK * LANES + i]
            f[base + at.NOTE * LANES + i] = -1.0 if empty else f[base + at.NOTE * LANES + i]
    for n in range(pack(w, _SLOW, at.MARK, 0)):
        _assign(s, w, f, foods, packed(w, at.MARK, n), clear, unsteady == 0.0)


@inline
def _plain(f: NDArray[np.float64], there: int) -> bool:
    """Whether an object's own track, found in the last frame, is so near that it shows no other, nor another it."""
    x, y = f[there + at.SEEN_X * LANES], f[there + at.SEEN_Y * LANES]
    dx, dy = x - f[there + at.TRACK_X * LANES], y - f[there + at.TRACK_Y * LANES]
    off_x = x - f[there + at.FOOD_X * LANES] / MM_PER_PIXEL
    off_y = y - f[there + at.FOOD_Y * LANES] / MM_PER_PIXEL
    return bool(
        f[there + at.TRACK_FOUND * LANES] != 0.0
        and dx * dx + dy * dy <= _NEAR * _NEAR
        and off_x * off_x + off_y * off_y <= _STRAY * _STRAY
    )


@inline
def _assign(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    foods: int,
    i: int,
    clear: float,
    steady: bool,
) -> None:
    """The rule in full: the best pair of track and detection first, then the next best."""
    gate = GATE * GATE
    taken = 0  # bit by bit: tracks of the foods, then ghosts
    shown = 0
    left = 0
    for food in range(foods):
        there = food * at.FOOD_ROWS * LANES + i
        if f[there + at.SEEN * LANES] == 0.0:
            continue
        if steady and _plain(f, there):
            taken |= 1 << food
            shown |= 1 << food
            w[(_OWNER + food) * LANES + i] = food
        else:
            left += 1
    for _ in range(left):
        best, rank, chosen, which = np.inf, 2, -1, -1
        for slot in range(2 * foods):
            label, x, y, found = _track(f, foods, slot, i)
            if label < 0.0 or taken >> slot & 1:
                continue
            own_rank = 0 if found != 0.0 else 1
            for food in range(foods):
                there = food * at.FOOD_ROWS * LANES + i
                if f[there + at.SEEN * LANES] == 0.0 or shown >> food & 1:
                    continue
                dx, dy = x - f[there + at.SEEN_X * LANES], y - f[there + at.SEEN_Y * LANES]
                squared = dx * dx + dy * dy
                if squared <= gate and (own_rank < rank or (own_rank == rank and squared < best)):
                    best, rank, chosen, which = squared, own_rank, slot, food
        if chosen < 0:
            break
        taken |= 1 << chosen
        shown |= 1 << which
        w[(_OWNER + which) * LANES + i] = chosen
    for slot in range(2 * foods):
        label, x, y, _ = _track(f, foods, slot, i)
        if label >= 0.0 and not taken >> slot & 1 and _visible(s, f, foods, i, x, y, clear):
            _write(f, foods, slot, i, -1.0, x, y, -1.0)
    # Every track that shows food goes where the food is; what stood there makes way.
    for food in range(foods):
        there = food * at.FOOD_ROWS * LANES + i
        if shown >> food & 1:
            slot = int(w[(_OWNER + food) * LANES + i])
            if slot != food:
                _swap(f, foods, food, slot, i)
                for later in range(food + 1, foods):
                    if shown >> later & 1 and w[(_OWNER + later) * LANES + i] == food:
                        w[(_OWNER + later) * LANES + i] = slot
            f[there + at.TRACK_X * LANES] = f[there + at.SEEN_X * LANES]
            f[there + at.TRACK_Y * LANES] = f[there + at.SEEN_Y * LANES]
            f[there + at.TRACK_FOUND * LANES] = 1.0
    _start(s, f, foods, i, shown)
    ghosts = 0.0
    for food in range(foods):
        there = food * at.FOOD_ROWS * LANES + i
        if f[there + at.SEEN * LANES] == 0.0:
            f[there + at.TRACK_FOUND * LANES] = 0.0
        ghosts += 1.0 if f[there + at.GHOST * LANES] >= 0.0 else 0.0
    s[at.GHOSTS * LANES + i] = ghosts


@inline
def _start(s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int, shown: int) -> None:
    """New tracks for what continues none, in reading order."""
    for _ in range(foods):
        first = -1
        for food in range(foods):
            there = food * at.FOOD_ROWS * LANES + i
            if f[there + at.SEEN * LANES] != 0.0 and not shown >> food & 1:
                y = f[there + at.SEEN_Y * LANES]
                if first < 0 or y > f[first * at.FOOD_ROWS * LANES + i + at.SEEN_Y * LANES]:
                    first = food
        if first < 0:
            return
        shown |= 1 << first
        there = first * at.FOOD_ROWS * LANES + i
        if f[there + at.TRACK * LANES] >= 0.0:
            _swap(f, foods, first, _free_ghost(f, foods, i), i)
        label = s[at.NEXT_LABEL * LANES + i]
        s[at.NEXT_LABEL * LANES + i] = label + 1.0
        _write(f, foods, first, i, label, f[there + at.SEEN_X * LANES], f[there + at.SEEN_Y * LANES], -1.0)
        f[there + at.TRACK_FOUND * LANES] = 1.0


@inline
def _free_ghost(f: NDArray[np.float64], foods: int, i: int) -> int:
    """A slot without a track, or that of the oldest lost one should there be none."""
    oldest = foods
    for slot in range(foods, 2 * foods):
        if _track(f, foods, slot, i)[0] < _track(f, foods, oldest, i)[0]:
            oldest = slot
    return oldest


@inline
def _visible(
    s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int, x: float, y: float, clear: float
) -> bool:
    """Whether food at a place in the picture (pixels) would have shown in this frame."""
    x, y = x * MM_PER_PIXEL, y * MM_PER_PIXEL
    shows = not covered(x, y, clear, s, i)
    for food in range(foods):
        there = food * at.FOOD_ROWS * LANES + i
        dx, dy = x - f[there + at.FOOD_X * LANES], y - f[there + at.FOOD_Y * LANES]
        if f[there + at.LOST * LANES] != 0.0 and dx * dx + dy * dy <= 4 * FOOD_RADIUS * FOOD_RADIUS:
            shows = False
    return shows


@inline
def _track(f: NDArray[np.float64], foods: int, slot: int, i: int) -> tuple[float, float, float, float]:
    """Label, place and whether it was found, of a food's track or of a ghost."""
    if slot < foods:
        there = slot * at.FOOD_ROWS * LANES + i
        return (
            f[there + at.TRACK * LANES],
            f[there + at.TRACK_X * LANES],
            f[there + at.TRACK_Y * LANES],
            f[there + at.TRACK_FOUND * LANES],
        )
    there = (slot - foods) * at.FOOD_ROWS * LANES + i
    return f[there + at.GHOST * LANES], f[there + at.GHOST_X * LANES], f[there + at.GHOST_Y * LANES], 0.0


@inline
def _write(
    f: NDArray[np.float64], foods: int, slot: int, i: int, label: float, x: float, y: float, note: float
) -> None:
    first = at.TRACK if slot < foods else at.GHOST
    there = (slot if slot < foods else slot - foods) * at.FOOD_ROWS * LANES + i
    f[there + first * LANES] = label
    f[there + (first + 1) * LANES] = x
    f[there + (first + 2) * LANES] = y
    f[there + (at.NOTE if slot < foods else at.GHOST_NOTE) * LANES] = note


@inline
def _swap(f: NDArray[np.float64], foods: int, one: int, two: int, i: int) -> None:
    """Exchange what two slots hold."""
    label, x, y, _ = _track(f, foods, one, i)
    note = f[_note_at(foods, one, i)]
    other_label, other_x, other_y, _ = _track(f, foods, two, i)
    other_note = f[_note_at(foods, two, i)]
    _write(f, foods, one, i, other_label, other_x, other_y, other_note)
    _write(f, foods, two, i, label, x, y, note)


@inline
def _note_at(foods: int, slot: int, i: int) -> int:
    if slot < foods:
        return (slot * at.FOOD_ROWS + at.NOTE) * LANES + i
    return ((slot - foods) * at.FOOD_ROWS + at.GHOST_NOTE) * LANES + i
