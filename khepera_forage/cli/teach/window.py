"""The window in which a person teaches; needs a display and pygame (extra `render`)."""

import os
import time

from khepera_forage.cli.teach.keys import KeyEvent
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.caption import Caption

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import pygame

from khepera_forage.envs.rendering.keyboard import KeyboardPainter
from khepera_forage.envs.rendering.output import open_display

MAX_SCREEN_SHARE = 0.92
"""Largest share of the screen's width or height that the window takes when it opens."""
POLL_MILLISECONDS = 200
"""Longest wait for an event; between waits Python handles a Ctrl-C in the shell."""


class TeachingWindow:
    """A resizable window that shows pictures and waits for keys; the picture is scaled to the window.

    Raises:
        OSError: There is no display (see `envs.rendering.output`).
    """

    def __init__(self) -> None:
        open_display()
        self._painter = KeyboardPainter()
        self._picture = pygame.Surface((1, 1))

    def show(self, view: View, caption: Caption) -> None:
        """Show a picture with a caption under it; the first call opens the window."""
        self._picture = self._painter.paint(view, caption)
        if pygame.display.get_surface() is None:
            width, height = pygame.display.get_desktop_sizes()[0]
            room = round(MAX_SCREEN_SHARE * width), round(MAX_SCREEN_SHARE * height)
            pygame.display.set_mode(_fitted(self._picture.get_size(), room), pygame.RESIZABLE)
            pygame.display.set_caption("khepera-forage teach")
        self._refresh()

    def wait(self, timeout: float | None = None) -> KeyEvent | None:
        """Wait for the next key that is pressed or released; None after `timeout` seconds."""
        until = None if timeout is None else time.monotonic() + timeout
        while True:
            left = POLL_MILLISECONDS
            if until is not None:
                left = max(0, min(left, round(1000 * (until - time.monotonic()))))
            event = pygame.event.wait(left) if left else pygame.event.poll()
            if event.type == pygame.QUIT:
                return KeyEvent("escape", True)
            if event.type in (pygame.KEYDOWN, pygame.KEYUP):
                # pygame names the keypad digits [0] to [9].
                return KeyEvent(pygame.key.name(event.key).strip("[]"), event.type == pygame.KEYDOWN)
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
        size = _fitted(picture.get_size(), screen.get_size())
        if size != picture.get_size():
            picture = pygame.transform.smoothscale(picture, size)
        screen.fill(picture.get_at((0, 0)))
        screen.blit(picture, picture.get_rect(center=screen.get_rect().center))
        pygame.display.flip()


def _fitted(picture: tuple[int, int], room: tuple[int, int]) -> tuple[int, int]:
    """The size of a picture, scaled down to fit the room; the proportions stay the same."""
    scale = min(1.0, room[0] / picture[0], room[1] / picture[1])
    return max(1, round(scale * picture[0])), max(1, round(scale * picture[1]))
