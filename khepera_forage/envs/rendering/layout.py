"""Where everything goes: the arenas on the left, one panel a robot beside them, all as large as fits."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from khepera_forage.worlds.arena import Arena

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
"""Size of a panel of two columns at text scale 1; panels are never drawn lower than this, in proportion."""
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
    ground = (x2 - x1 + 2 * SURROUNDINGS, y2 - y1 + 2 * SURROUNDINGS)
    corner = (x1 - SURROUNDINGS, y2 + SURROUNDINGS)
    upwards = bounds[-1][1] > bounds[0][1]
    return max(_candidates(ground, corner, upwards, robots), key=lambda candidate: candidate[0])[1]


def _candidates(
    ground: tuple[float, float], corner: tuple[float, float], upwards: bool, robots: int
) -> Iterator[tuple[float, Layout]]:
    """Every arrangement with its worth."""
    for text in TEXT_SCALES if robots else (1.0,):
        for inner, (width, height) in ((2, WIDE_PANEL), (1, TALL_PANEL)):
            for across in range(1, max(robots, 1) + 1):
                down = math.ceil(robots / across)
                # The panels' block, with the gap that sets it apart from the arenas.
                block = (
                    across * (round(width * text) + GAP) if robots else 0,
                    down * (round(height * text) + GAP),
                )
                yield _fitted(ground, corner, upwards, robots, across, inner, text, block)


def _fitted(
    ground: tuple[float, float],
    corner: tuple[float, float],
    upwards: bool,
    robots: int,
    across: int,
    inner: int,
    text: float,
    block: tuple[int, int],
) -> tuple[float, Layout]:
    room = WIDEST - 2 * GAP - block[0]
    scale = max(0.2, min(LARGEST_SCALE, room / ground[0], max(TALLEST, block[1] - GAP) / ground[1]))
    shown = (round(ground[0] * scale), round(ground[1] * scale))
    body = max(shown[1], block[1] - GAP)
    width, height = 2 * GAP + shown[0] + block[0], HEADER + body + FOOTER
    down = math.ceil(robots / across)
    card = (block[0] // across - GAP, (body - (down - 1) * GAP) // max(down, 1)) if robots else (0, 0)
    west = GAP + shown[0] + GAP
    slots = [
        Box(west + i % across * (card[0] + GAP), HEADER + i // across * (card[1] + GAP), *card)
        for i in range(robots)
    ]
    # In one column beside arenas that are stacked upwards, every panel then stands beside its own arena.
    panels = tuple(reversed(slots) if upwards and across == 1 else slots)
    arena = Box(GAP, HEADER + (body - shown[1]) // 2, *shown)
    layout = Layout((width + width % 2, height + height % 2), arena, scale, *corner, panels, inner, text)
    used = (shown[0] * shown[1] + (block[0] - across * GAP) * (block[1] - down * GAP)) / (
        (width - 2 * GAP) * body
    )
    excess = max(width / WIDEST, 1.0) * max(body / TALLEST, 1.0)
    return min(text, 1.1) * scale * used / excess**4, layout
