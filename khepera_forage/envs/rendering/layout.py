"""Layout of a picture: the arenas on the left, one panel per robot beside them, all as large as possible."""

import math
from typing import NamedTuple

from khepera_forage.sim.arena import Arena

GAP = 16
"""Pixels around and between arenas and panels."""
HEADER = 62
FOOTER = 34
MAX_WIDTH = 1400
"""Greatest width of a picture in pixels; exceeded only when the panels would become illegible."""
MAX_HEIGHT = 760
"""Greatest height in pixels between header and footer; exceeded likewise."""
MAX_SCALE = 1.3
"""Greatest number of pixels per mm."""
MARGIN = 30.0
"""mm shown outside the walls."""

WIDE_PANEL = (430, 350)
"""Width and least height of a panel with two columns at text scale 1."""
TALL_PANEL = (296, 540)
"""Width and least height of a panel with one column at text scale 1."""
TEXT_SCALES = (1.2, 1.15, 1.1, 1.05, 1.0, 0.95, 0.9, 0.85, 0.8)


class Box(NamedTuple):
    """A rectangle in pixels of the picture, y down."""

    left: int
    top: int
    width: int
    height: int


class Layout(NamedTuple):
    """Positions and sizes of all parts of a picture.

    Attributes:
        size: Width and height of the picture, both even, as video encoders require.
        arena: The part that shows the arenas.
        scale: Pixels per mm in `arena`.
        left: x in mm at the left side of `arena`.
        top: y in mm at the upper side of `arena`.
        panels: One per robot.
        columns: Columns in each panel, 1 or 2.
        text_scale: Scale of the panels' text.
    """

    size: tuple[int, int]
    arena: Box
    scale: float
    left: float
    top: float
    panels: tuple[Box, ...]
    columns: int
    text_scale: float

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Column and row of the picture that show a position in mm."""
        return (
            self.arena.left + math.floor((x - self.left) * self.scale),
            self.arena.top + math.floor((self.top - y) * self.scale),
        )


def arrange(arenas: tuple[Arena, ...], robots: int) -> Layout:
    """The best of many layouts, with large arenas, large text and little empty space.

    Args:
        arenas: At least one.
        robots: Number of panels.

    Raises:
        ValueError: No arena.
    """
    if not arenas:
        raise ValueError("no arenas to show; allowed: at least one")
    bounds = [arena.bounds for arena in arenas]
    x1, y1 = min(b[0] for b in bounds), min(b[1] for b in bounds)
    x2, y2 = max(b[2] for b in bounds), max(b[3] for b in bounds)
    ground = _Ground(
        x2 - x1 + 2 * MARGIN,
        y2 - y1 + 2 * MARGIN,
        x1 - MARGIN,
        y2 + MARGIN,
        upwards=bounds[-1][1] > bounds[0][1],
    )
    candidates = (
        _candidate(ground, robots, across, columns, text_scale)
        for text_scale in TEXT_SCALES
        for columns in (2, 1)
        for across in range(1, max(robots, 1) + 1)
    )
    return max(candidates, key=lambda candidate: candidate[0])[1]


class _Ground(NamedTuple):
    """All arenas with their margin, in mm, and whether later arenas lie above earlier ones."""

    width: float
    height: float
    left: float
    top: float
    upwards: bool


def _candidate(
    ground: _Ground, robots: int, across: int, columns: int, text_scale: float
) -> tuple[float, Layout]:
    """A layout and its quality.

    Args:
        ground: The arenas.
        robots: Number of panels.
        across: Number of panels side by side.
        columns: Columns in each panel.
        text_scale: Scale of the panels' text.
    """
    down = math.ceil(robots / across)
    panel = [round(side * text_scale) for side in (WIDE_PANEL if columns == 2 else TALL_PANEL)]
    # Width of the panels, including the gap between them and the arenas.
    panels_width = across * (panel[0] + GAP) if robots else 0
    panels_height = down * (panel[1] + GAP) - GAP
    room = MAX_WIDTH - 2 * GAP - panels_width
    scale = max(0.2, min(MAX_SCALE, room / ground.width, max(MAX_HEIGHT, panels_height) / ground.height))
    arena = (round(ground.width * scale), round(ground.height * scale))
    body = max(arena[1], panels_height)
    width, height = 2 * GAP + arena[0] + panels_width, HEADER + body + FOOTER
    panel_height = (body - (down - 1) * GAP) // max(down, 1)
    panels = [
        Box(
            2 * GAP + arena[0] + i % across * (panel[0] + GAP),
            HEADER + i // across * (panel_height + GAP),
            panel[0],
            panel_height,
        )
        for i in range(robots)
    ]
    layout = Layout(
        size=(width + width % 2, height + height % 2),
        arena=Box(GAP, HEADER + (body - arena[1]) // 2, *arena),
        scale=scale,
        left=ground.left,
        top=ground.top,
        # Arenas that are stacked upwards have their panels in the same order, each beside its own arena.
        panels=tuple(reversed(panels) if ground.upwards and across == 1 else panels),
        columns=columns,
        text_scale=text_scale,
    )
    used = (arena[0] * arena[1] + across * down * panel[0] * panel[1]) / ((width - 2 * GAP) * body)
    # Oversize reduces the quality strongly, but does not exclude a layout: many robots need it.
    excess = max(width / MAX_WIDTH, 1.0) * max(body / MAX_HEIGHT, 1.0)
    return min(text_scale, 1.1) * scale * used / excess**4, layout
