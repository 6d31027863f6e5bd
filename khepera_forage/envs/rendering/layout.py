"""Where everything goes: the arenas on the left, one panel a robot beside them, all as large as fits."""

import math
from typing import NamedTuple

from khepera_forage.sim.arena import Arena

GAP = 16
"""Pixels around and between things."""
HEADER = 62
FOOTER = 34
WIDEST = 1400
"""Pixels across a picture, for as long as the panels stay legible."""
TALLEST = 760
"""Pixels of a picture between header and footer, likewise."""
LARGEST_SCALE = 1.3
"""Pixels a millimetre at most."""
SURROUNDINGS = 30.0
"""mm of surroundings shown outside the walls."""

WIDE_PANEL = (430, 350)
"""Size of a panel of two columns at text scale 1; if there is room it is made higher, never lower."""
TALL_PANEL = (296, 540)
"""Size of a panel of one column."""
TEXT_SCALES = (1.2, 1.15, 1.1, 1.05, 1.0, 0.95, 0.9, 0.85, 0.8)


class Box(NamedTuple):
    """A rectangle in pixels of the picture, y down."""

    left: int
    top: int
    width: int
    height: int


class Layout(NamedTuple):
    """Where everything goes in a picture.

    Attributes:
        size: Width and height of the picture, both even, as encoders of films demand.
        arena: What shows the arenas.
        scale: Pixels a millimetre in it.
        west: x in mm at the left side of `arena`.
        north: y in mm at its upper side.
        panels: One a robot.
        columns: Columns within each panel, 1 or 2.
        text: Scale of the panels' text.
    """

    size: tuple[int, int]
    arena: Box
    scale: float
    west: float
    north: float
    panels: tuple[Box, ...]
    columns: int
    text: float

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Column and row of the picture that show a place in mm."""
        return (
            self.arena.left + math.floor((x - self.west) * self.scale),
            self.arena.top + math.floor((self.north - y) * self.scale),
        )


def arrange(arenas: tuple[Arena, ...], robots: int) -> Layout:
    """The best of many arrangements: large arenas, large text, little empty space.

    Raises:
        ValueError: No arena.
    """
    if not arenas:
        raise ValueError("no arenas to show; allowed: at least one")
    bounds = [arena.bounds for arena in arenas]
    x1, y1 = min(b[0] for b in bounds), min(b[1] for b in bounds)
    x2, y2 = max(b[2] for b in bounds), max(b[3] for b in bounds)
    ground = _Ground(
        x2 - x1 + 2 * SURROUNDINGS,
        y2 - y1 + 2 * SURROUNDINGS,
        x1 - SURROUNDINGS,
        y2 + SURROUNDINGS,
        upwards=bounds[-1][1] > bounds[0][1],
    )
    candidates = (
        _fitted(ground, robots, across, columns, text)
        for text in TEXT_SCALES
        for columns in (2, 1)
        for across in range(1, max(robots, 1) + 1)
    )
    return max(candidates, key=lambda candidate: candidate[0])[1]


class _Ground(NamedTuple):
    """All arenas with their surroundings, in mm, and whether the later ones stand above the earlier."""

    width: float
    height: float
    west: float
    north: float
    upwards: bool


def _fitted(ground: _Ground, robots: int, across: int, columns: int, text: float) -> tuple[float, Layout]:
    """The arrangement with so many panels side by side, of so many columns each, and what it is worth."""
    down = math.ceil(robots / across)
    panel = [round(side * text) for side in (WIDE_PANEL if columns == 2 else TALL_PANEL)]
    # Room for the panels, with the gap that sets them apart from the arenas.
    aside = across * (panel[0] + GAP) if robots else 0
    needed = down * (panel[1] + GAP) - GAP
    room = WIDEST - 2 * GAP - aside
    scale = max(0.2, min(LARGEST_SCALE, room / ground.width, max(TALLEST, needed) / ground.height))
    shown = (round(ground.width * scale), round(ground.height * scale))
    body = max(shown[1], needed)
    width, height = 2 * GAP + shown[0] + aside, HEADER + body + FOOTER
    tall = (body - (down - 1) * GAP) // max(down, 1)
    slots = [
        Box(
            2 * GAP + shown[0] + i % across * (panel[0] + GAP),
            HEADER + i // across * (tall + GAP),
            panel[0],
            tall,
        )
        for i in range(robots)
    ]
    layout = Layout(
        size=(width + width % 2, height + height % 2),
        arena=Box(GAP, HEADER + (body - shown[1]) // 2, *shown),
        scale=scale,
        west=ground.west,
        north=ground.north,
        # In one column beside arenas that are stacked upwards, every panel then stands beside its own arena.
        panels=tuple(reversed(slots) if ground.upwards and across == 1 else slots),
        columns=columns,
        text=text,
    )
    used = (shown[0] * shown[1] + across * down * panel[0] * panel[1]) / ((width - 2 * GAP) * body)
    # Beyond the limits a picture quickly loses worth, but with many robots some picture there must be.
    excess = max(width / WIDEST, 1.0) * max(body / TALLEST, 1.0)
    return min(text, 1.1) * scale * used / excess**4, layout
