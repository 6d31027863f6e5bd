"""The legend under a picture: meaning of its colours and symbols."""

from collections.abc import Callable

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.arena_layer import draw_food, draw_region
from khepera_forage.envs.rendering.canvas import Canvas
from khepera_forage.envs.rendering.layout import FOOTER, GAP
from khepera_forage.envs.rendering.text import TextRenderer
from khepera_forage.envs.rendering.view import FoodView
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region

SCALE = 0.42
"""Pixels per mm of the symbols."""
TEXT_SIZE = 16
LABEL_OFFSET = 26
"""Pixels from a symbol's left side to its label."""
SPACING = 18
"""Pixels between a label and the next symbol."""
MIDDLE = FOOTER / 2

DrawSymbol = Callable[[float], None]
"""Draws a symbol at x, in mm of the legend's canvas."""


def draw_legend(width: int, panels: bool, text: TextRenderer) -> pygame.Surface:
    """The legend as a strip of one line; entries that do not fit are left out.

    Args:
        width: Of the strip in pixels.
        panels: Whether the picture has panels; otherwise their entries are left out.
        text: Draws the labels.
    """
    canvas = Canvas((width, FOOTER), SCALE, 0.0, FOOTER / SCALE)
    canvas.surface.fill(palette.BACKGROUND)
    labels: list[tuple[float, str]] = []
    x = float(GAP)
    for label, draw_symbol in (*_food_symbols(canvas), *_camera_symbols(canvas)):
        right = x + LABEL_OFFSET + text.width(label, TEXT_SIZE)
        if right > width - GAP:
            break
        draw_symbol((x + 11) / SCALE)
        labels.append((x + LABEL_OFFSET, label))
        x = right + SPACING
    strip = canvas.downsampled()
    for left, label in labels:
        text.write(strip, label, left, MIDDLE, TEXT_SIZE, palette.MUTED)
    if panels:
        _draw_panel_symbols(strip, x, text)
    return strip


def _food_symbols(canvas: Canvas) -> list[tuple[str, DrawSymbol]]:
    def symbol(food_type: FoodType, delivered: bool = False) -> DrawSymbol:
        return lambda x: draw_food(canvas, FoodView(x, MIDDLE / SCALE, food_type, delivered=delivered))

    symbols = [(food_type.name.capitalize(), symbol(food_type)) for food_type in FoodType]
    delivered = symbol(FoodType.UNKNOWN, delivered=True)
    return [("Unknown food", symbols[0][1]), *symbols[1:], ("Delivered", delivered)]


def _camera_symbols(canvas: Canvas) -> list[tuple[str, DrawSymbol]]:
    def symbol(found: bool) -> DrawSymbol:
        y = MIDDLE / SCALE / MM_PER_PIXEL
        return lambda x: draw_region(
            canvas, Region(0, x / MM_PER_PIXEL, y, 0, 0, found, False, 0, 0, 0, 0, 0)
        )

    return [("Seen by camera", symbol(True)), ("Lost", symbol(False))]


def _draw_panel_symbols(strip: pygame.Surface, x: float, text: TextRenderer) -> None:
    """How a panel's list of behaviours marks the state's own, the heard and the executed behaviour."""
    right = strip.get_width() - GAP
    x += SPACING
    for number, label in enumerate(("State's own", "Heard", "Executed")):
        width = text.width(label, TEXT_SIZE)
        if x + width + 12 > right:
            return
        if number == 0:
            text.dot(strip, x + 3, MIDDLE, 3, palette.INK)
            text.write(strip, label, x + 12, MIDDLE, TEXT_SIZE, palette.MUTED)
        else:
            fill, edge, ink = (
                (palette.CARD, palette.INK, palette.INK)
                if number == 1
                else (palette.TEACHER, None, palette.CARD)
            )
            text.box(strip, (x, MIDDLE - 8, width + 12, 16), fill, 5, edge)
            text.write(strip, label, x + 6, MIDDLE, TEXT_SIZE, ink)
        x += width + 12 + SPACING
