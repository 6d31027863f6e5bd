"""The key under a picture: what its colours and signs mean."""

from collections.abc import Callable

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.arena_layer import draw_food, draw_region
from khepera_forage.envs.rendering.layout import FOOTER, GAP
from khepera_forage.envs.rendering.lettering import Lettering
from khepera_forage.envs.rendering.pen import Pen
from khepera_forage.envs.rendering.view import FoodView
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Region

SCALE = 0.42
"""Pixels a millimetre of the signs."""
TEXT = 16
LABEL = 26
"""From a sign's left side to its label."""
SPACE = 18
"""Between a label and the next sign."""
MIDDLE = FOOTER / 2


def draw_key(width: int, panels: bool, lettering: Lettering) -> pygame.Surface:
    """A strip with all signs, in one line as far as it fits; those of panels only if there are any."""
    pen = Pen((width, FOOTER), SCALE, 0.0, FOOTER / SCALE)
    pen.surface.fill(palette.PAPER)
    entries = [*_food_signs(pen), *_camera_signs(pen)]
    labels: list[tuple[float, str]] = []
    x = float(GAP)
    for text, sign in entries:
        after = x + LABEL + lettering.width(text, TEXT)
        if after > width - GAP:
            break
        sign((x + 11) / SCALE)
        labels.append((x + LABEL, text))
        x = after + SPACE
    strip = pen.shrunk()
    for left, text in labels:
        lettering.write(strip, text, left, MIDDLE, TEXT, palette.FADED)
    if panels:
        _write_panel_signs(strip, x, lettering)
    return strip


def _food_signs(pen: Pen) -> list[tuple[str, Callable[[float], None]]]:
    def sign(kind: FoodType, delivered: bool = False) -> Callable[[float], None]:
        return lambda x: draw_food(pen, FoodView(x, MIDDLE / SCALE, kind, delivered=delivered))

    kinds = [(kind.name.capitalize(), sign(kind)) for kind in FoodType]
    return [("Unknown food", kinds[0][1]), *kinds[1:], ("Delivered", sign(FoodType.UNKNOWN, delivered=True))]


def _camera_signs(pen: Pen) -> list[tuple[str, Callable[[float], None]]]:
    def sign(found: bool) -> Callable[[float], None]:
        y = MIDDLE / SCALE / MM_PER_PIXEL
        return lambda x: draw_region(pen, Region(0, x / MM_PER_PIXEL, y, 0, 0, found, False, 0, 0, 0, 0, 0))

    return [("Seen by camera", sign(True)), ("Lost", sign(False))]


def _write_panel_signs(strip: pygame.Surface, x: float, lettering: Lettering) -> None:
    """How the list of behaviours marks what is the state's own, heard and executed."""
    limit = strip.get_width() - GAP
    x += SPACE
    for number, text in enumerate(("State's own", "Heard", "Executed")):
        width = lettering.width(text, TEXT)
        if x + width + 12 > limit:
            return
        if number == 0:
            lettering.dot(strip, x + 3, MIDDLE, 3, palette.INK)
            lettering.write(strip, text, x + 12, MIDDLE, TEXT, palette.FADED)
        else:
            fill, edge, ink = (
                (palette.CARD, palette.INK, palette.INK)
                if number == 1
                else (palette.TEACHER, None, palette.CARD)
            )
            lettering.box(strip, (x, MIDDLE - 8, width + 12, 16), fill, 5, edge)
            lettering.write(strip, text, x + 6, MIDDLE, TEXT, ink)
        x += width + 12 + SPACE
