"""The window in which a person teaches; needs a display and pygame (extra `render`)."""

import os
import time

from khepera_forage.cli.teach import LETTERS, Caption
from khepera_forage.envs.rendering import View, palette
from khepera_forage.task.states import Behaviour

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import pygame

from khepera_forage.envs.rendering.drawing import box, fitted, text_width, write
from khepera_forage.envs.rendering.output import open_display
from khepera_forage.envs.rendering.panel import sentence_case
from khepera_forage.envs.rendering.picture import GAP, Painter

MAX_SCREEN_SHARE = 0.92
"""Largest share of the screen's width or height that the window takes when it opens."""
POLL_MILLISECONDS = 200
"""Longest wait for an event; between waits Python handles a Ctrl-C in the shell."""
COLUMNS = 5
OTHER_KEYS = "Space: repeat · Backspace: begin again · Esc: end"
"""Written beside the message, if both fit."""
MESSAGE_HEIGHT, ROW_HEIGHT = 36, 38
"""Heights in pixels of the message bar and of a row of keys."""
KEY_CAP = 28
"""Side of a key cap in pixels."""
LETTER_SIZE, NAME_SIZE, MESSAGE_SIZE, HINT_SIZE = 20, 18, 20, 16
"""Sizes of text."""


class TeachingWindow:
    """A resizable window that shows pictures and waits for keys; the picture is scaled to the window.

    Raises:
        OSError: There is no display (see `envs.rendering.output`).
    """

    def __init__(self) -> None:
        open_display()
        self._painter = Painter()
        self._picture = pygame.Surface((1, 1))

    def show(self, view: View, caption: Caption) -> None:
        """Show a picture with a caption under it; the first call opens the window."""
        self._picture = with_caption(self._painter.paint(view), caption)
        if pygame.display.get_surface() is None:
            width, height = pygame.display.get_desktop_sizes()[0]
            room = round(MAX_SCREEN_SHARE * width), round(MAX_SCREEN_SHARE * height)
            pygame.display.set_mode(_shrunk(self._picture.get_size(), room), pygame.RESIZABLE)
            pygame.display.set_caption("khepera-forage teach")
        self._refresh()

    def wait(self, timeout: float | None = None) -> tuple[str, bool] | None:
        """Wait for the next key that is pressed (True) or released; None after `timeout` seconds.

        The key is a letter, a digit, or a name such as "space"; closing the window counts as "escape".
        """
        until = None if timeout is None else time.monotonic() + timeout
        while True:
            left = POLL_MILLISECONDS
            if until is not None:
                left = max(0, min(left, round(1000 * (until - time.monotonic()))))
            event = pygame.event.wait(left) if left else pygame.event.poll()
            if event.type == pygame.QUIT:
                return "escape", True
            if event.type in (pygame.KEYDOWN, pygame.KEYUP):
                # pygame names the keypad digits [0] to [9].
                return pygame.key.name(event.key).strip("[]"), event.type == pygame.KEYDOWN
            if event.type in (pygame.WINDOWEXPOSED, pygame.WINDOWSIZECHANGED):
                self._refresh()
            if event.type == pygame.NOEVENT and until is not None and time.monotonic() >= until:
                return None

    def close(self) -> None:
        """Close the window."""
        pygame.display.quit()

    def _refresh(self) -> None:
        """Draw the picture in the middle of the window, scaled down if it is too large."""
        screen, picture = pygame.display.get_surface(), self._picture
        if screen is None:
            return
        size = _shrunk(picture.get_size(), screen.get_size())
        if size != picture.get_size():
            picture = pygame.transform.smoothscale(picture, size)
        screen.fill(picture.get_at((0, 0)))
        screen.blit(picture, picture.get_rect(center=screen.get_rect().center))
        pygame.display.flip()


def _shrunk(picture: tuple[int, int], room: tuple[int, int]) -> tuple[int, int]:
    """The size of a picture, scaled down to fit the room; the proportions stay the same."""
    scale = min(1.0, room[0] / picture[0], room[1] / picture[1])
    return max(1, round(scale * picture[0])), max(1, round(scale * picture[1]))


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
