"""The picture for a person at the keyboard: that of the environment, and under it a message and the ten keys."""

import pygame

from khepera_forage.envs.rendering import palette
from khepera_forage.envs.rendering.caption import Caption
from khepera_forage.envs.rendering.layout import GAP
from khepera_forage.envs.rendering.lettering import Lettering
from khepera_forage.envs.rendering.painter import Painter
from khepera_forage.envs.rendering.panel import phrase
from khepera_forage.envs.rendering.view import View
from khepera_forage.task.states import Behaviour

COLUMNS = 5
BAR, ROW = 36, 38
"""Heights in pixels of the message and of a row of keys."""
CAP = 28
"""Side of a key."""
KEY, NAME, MESSAGE, ASIDE = 20, 18, 20, 16
"""Sizes of text."""


class KeyboardPainter:
    """Paints views with a caption under them."""

    def __init__(self) -> None:
        self._painter = Painter()
        self._lettering = Lettering()
        self._view: View | None = None
        self._above: pygame.Surface

    def paint(self, view: View, caption: Caption) -> pygame.Surface:
        """The picture of a view with its caption; a fresh surface.

        A view that is the one before is not painted again: captions change with every key.

        Raises:
            ValueError: The view has no arena.
        """
        if view is not self._view:
            self._above, self._view = self._painter.paint(view), view
        above = self._above
        width, height = above.get_size()
        rows = -(-len(caption.letters) // COLUMNS)
        picture = pygame.Surface((width, height + BAR + rows * ROW + GAP), 0, 32)
        picture.fill(above.get_at((0, height - 1)))
        picture.blit(above, (0, 0))
        self._bar(picture, caption, height)
        pitch = (width - 2 * GAP) / COLUMNS
        for number, behaviour in enumerate(caption.letters):
            row, column = divmod(number, COLUMNS)
            self._key(picture, caption, behaviour, GAP + column * pitch, height + BAR + row * ROW, pitch)
        return picture

    def _bar(self, on: pygame.Surface, caption: Caption, top: float) -> None:
        """The message, and at the right what is said aside if both fit."""
        ink, fill = (
            (palette.WARNING, palette.WARNING_FILL) if caption.warning else (palette.INK, palette.TRACK)
        )
        width, middle = on.get_width() - 2 * GAP, top + (BAR - 8) / 2
        self._lettering.box(on, (GAP, top, width, BAR - 8), fill, 6)
        message = self._lettering.fitted(caption.message, MESSAGE, width - 24)
        self._lettering.write(on, message, GAP + 12, middle, MESSAGE, ink)
        used = self._lettering.width(message, MESSAGE) + self._lettering.width(caption.aside, ASIDE)
        if used + 60 <= width:
            right = GAP + width - 12
            self._lettering.write(on, caption.aside, right, middle, ASIDE, palette.FADED, "right")

    def _key(
        self,
        on: pygame.Surface,
        caption: Caption,
        behaviour: Behaviour,
        left: float,
        top: float,
        width: float,
    ) -> None:
        """One key with the name of its behaviour: filled while it is held, outlined if it was the last."""
        middle, ink, faded = top + ROW / 2, palette.INK, palette.FADED
        cell = (left, top + 2, width - 8, ROW - 4)
        if behaviour == caption.lit:
            self._lettering.box(on, cell, palette.TEACHER, 6)
            ink = faded = palette.CARD
        elif behaviour == caption.last:
            self._lettering.box(on, cell, palette.CARD, 6, palette.TEACHER)
        cap = (left + 6, middle - CAP / 2, CAP, CAP)
        self._lettering.box(on, cap, palette.CARD, 5, palette.FADED)
        letter = caption.letters[behaviour].upper()
        self._lettering.write(on, letter, left + 6 + CAP / 2, middle, KEY, palette.INK, "centre")
        self._lettering.write(on, str(int(behaviour)), left + 12 + CAP, middle, ASIDE, faded)
        name = self._lettering.fitted(phrase(behaviour.name), NAME, width - CAP - 42)
        self._lettering.write(on, name, left + 27 + CAP, middle, NAME, ink)
