"""The picture for a person who teaches: the picture of the environment with a message and the ten keys under it."""

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.caption import Caption
from khepera_forage.envs.rendering.drawing import box, fitted, text_width, write
from khepera_forage.envs.rendering.panel import sentence_case
from khepera_forage.envs.rendering.picture import GAP, Painter
from khepera_forage.envs.rendering.view import View
from khepera_forage.task.states import Behaviour

COLUMNS = 5
MESSAGE_HEIGHT, ROW_HEIGHT = 36, 38
"""Heights in pixels of the message bar and of a row of keys."""
KEY_CAP = 28
"""Side of a key cap in pixels."""
LETTER_SIZE, NAME_SIZE, MESSAGE_SIZE, HINT_SIZE = 20, 18, 20, 16
"""Sizes of text."""


class KeyboardPainter:
    """Paints views with a caption under them."""

    def __init__(self) -> None:
        self._painter = Painter()
        self._view: View | None = None
        self._view_picture: pygame.Surface

    def paint(self, view: View, caption: Caption) -> pygame.Surface:
        """The picture of a view with its caption; a new surface.

        The view is painted only when it is another object than before, because captions change more often.

        Raises:
            ValueError: The view has no arena.
        """
        if view is not self._view:
            self._view_picture, self._view = self._painter.paint(view), view
        above = self._view_picture
        width, height = above.get_size()
        rows = -(-len(caption.letters) // COLUMNS)
        picture = pygame.Surface((width, height + MESSAGE_HEIGHT + rows * ROW_HEIGHT + GAP), 0, 32)
        picture.fill(above.get_at((0, height - 1)))
        picture.blit(above, (0, 0))
        self._draw_message(picture, caption, height)
        pitch = (width - 2 * GAP) / COLUMNS
        for number, behaviour in enumerate(caption.letters):
            row, column = divmod(number, COLUMNS)
            top = height + MESSAGE_HEIGHT + row * ROW_HEIGHT
            self._draw_key(picture, caption, behaviour, GAP + column * pitch, top, pitch)
        return picture

    def _draw_message(self, surface: pygame.Surface, caption: Caption, top: float) -> None:
        """The message, and the hint at the right if both fit."""
        ink, fill = (
            (palette.WARNING, palette.WARNING_FILL) if caption.warning else (palette.INK, palette.TRACK)
        )
        width, middle = surface.get_width() - 2 * GAP, top + (MESSAGE_HEIGHT - 8) / 2
        box(surface, (GAP, top, width, MESSAGE_HEIGHT - 8), fill, 6)
        message = fitted(caption.message, MESSAGE_SIZE, width - 24)
        write(surface, message, GAP + 12, middle, MESSAGE_SIZE, ink)
        used = text_width(message, MESSAGE_SIZE) + text_width(caption.hint, HINT_SIZE)
        if used + 60 <= width:
            right = GAP + width - 12
            write(surface, caption.hint, right, middle, HINT_SIZE, palette.MUTED, "right")

    def _draw_key(
        self,
        surface: pygame.Surface,
        caption: Caption,
        behaviour: Behaviour,
        left: float,
        top: float,
        width: float,
    ) -> None:
        """One key with the name of its behaviour: filled while it is held, outlined if it was chosen last."""
        middle, ink, muted = top + ROW_HEIGHT / 2, palette.INK, palette.MUTED
        cell = (left, top + 2, width - 8, ROW_HEIGHT - 4)
        if behaviour == caption.held:
            box(surface, cell, palette.TEACHER, 6)
            ink = muted = palette.CARD
        elif behaviour == caption.last:
            box(surface, cell, palette.CARD, 6, palette.TEACHER)
        cap = (left + 6, middle - KEY_CAP / 2, KEY_CAP, KEY_CAP)
        box(surface, cap, palette.CARD, 5, palette.MUTED)
        letter = caption.letters[behaviour].upper()
        write(surface, letter, left + 6 + KEY_CAP / 2, middle, LETTER_SIZE, palette.INK, "centre")
        write(surface, str(int(behaviour)), left + 12 + KEY_CAP, middle, HINT_SIZE, muted)
        name = fitted(sentence_case(behaviour.name), NAME_SIZE, width - KEY_CAP - 42)
        write(surface, name, left + 27 + KEY_CAP, middle, NAME_SIZE, ink)
