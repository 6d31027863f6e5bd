"""What a person sees who teaches: the picture of the training, a message and the keys."""

import pygame

from khepera_forage.cli.teach import LETTERS, Caption
from khepera_forage.cli.window import Window
from khepera_forage.envs.rendering import View, palette
from khepera_forage.envs.rendering.drawing import box, fitted, text_width, write
from khepera_forage.envs.rendering.panel import sentence_case
from khepera_forage.envs.rendering.picture import GAP, Painter
from khepera_forage.task.states import Behaviour

OTHER_KEYS = "Space: repeat · Backspace: begin again · Esc: end"
"""Written beside the message, if both fit."""
COLUMNS, MESSAGE_HEIGHT, ROW_HEIGHT, KEY_CAP = 5, 36, 38, 28
"""Keys in a row; heights in pixels of the message bar and of a row, and the side of a key cap."""
LETTER_SIZE, NAME_SIZE, MESSAGE_SIZE, HINT_SIZE = 20, 18, 20, 16


class TeachingWindow(Window):
    """The window in which a person teaches."""

    def __init__(self) -> None:
        super().__init__()
        self._painter = Painter()
        self._painted: tuple[View, pygame.Surface] | None = None

    def show(self, view: View, caption: Caption) -> None:
        """Show a picture with a caption under it; the same view again costs a fifth of the time."""
        if self._painted is None or self._painted[0] is not view:
            self._painted = view, self._painter.paint(view)
        self.show_picture(with_caption(self._painted[1], caption), "khepera-forage teach")


def with_caption(above: pygame.Surface, caption: Caption) -> pygame.Surface:
    """A picture with its caption under it."""
    width, height = above.get_size()
    rows = -(-len(LETTERS) // COLUMNS)
    picture = pygame.Surface((width, height + MESSAGE_HEIGHT + rows * ROW_HEIGHT + GAP), 0, 32)
    picture.fill(above.get_at((0, height - 1)))
    picture.blit(above, (0, 0))
    _draw_message(picture, caption, height)
    pitch = (width - 2 * GAP) / COLUMNS
    for number, behaviour in enumerate(LETTERS):
        row, column = divmod(number, COLUMNS)
        top = height + MESSAGE_HEIGHT + row * ROW_HEIGHT
        _draw_key(picture, caption, behaviour, GAP + column * pitch, top, pitch)
    return picture


def _draw_message(picture: pygame.Surface, caption: Caption, top: float) -> None:
    ink, fill = (palette.WARNING, palette.WARNING_FILL) if caption.warning else (palette.INK, palette.TRACK)
    width, middle = picture.get_width() - 2 * GAP, top + (MESSAGE_HEIGHT - 8) / 2
    box(picture, (GAP, top, width, MESSAGE_HEIGHT - 8), fill, 6)
    message = fitted(caption.message, MESSAGE_SIZE, width - 24)
    write(picture, message, GAP + 12, middle, MESSAGE_SIZE, ink)
    if text_width(message, MESSAGE_SIZE) + text_width(OTHER_KEYS, HINT_SIZE) + 60 <= width:
        write(picture, OTHER_KEYS, GAP + width - 12, middle, HINT_SIZE, palette.MUTED, "right")


def _draw_key(
    picture: pygame.Surface, caption: Caption, behaviour: Behaviour, left: float, top: float, width: float
) -> None:
    """One key with the name of its behaviour: filled while it is held, outlined if it was chosen last."""
    middle, ink, muted = top + ROW_HEIGHT / 2, palette.INK, palette.MUTED
    cell = (left, top + 2, width - 8, ROW_HEIGHT - 4)
    if behaviour == caption.held:
        box(picture, cell, palette.TEACHER, 6)
        ink = muted = palette.CARD
    elif behaviour == caption.last:
        box(picture, cell, palette.CARD, 6, palette.TEACHER)
    box(picture, (left + 6, middle - KEY_CAP / 2, KEY_CAP, KEY_CAP), palette.CARD, 5, palette.MUTED)
    letter = LETTERS[behaviour].upper()
    write(picture, letter, left + 6 + KEY_CAP / 2, middle, LETTER_SIZE, palette.INK, "centre")
    write(picture, str(int(behaviour)), left + 12 + KEY_CAP, middle, HINT_SIZE, muted)
    name = fitted(sentence_case(behaviour.name), NAME_SIZE, width - KEY_CAP - 42)
    write(picture, name, left + 27 + KEY_CAP, middle, NAME_SIZE, ink)
