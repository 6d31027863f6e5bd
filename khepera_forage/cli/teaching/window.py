"""The window in which a person teaches: the only thing here that touches a display; it needs pygame."""

import os
import time

from khepera_forage.cli.teaching.keys import KeyEvent
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.caption import Caption

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import pygame

    from khepera_forage.envs.rendering.keyboard import KeyboardPainter
except ImportError as error:
    raise ImportError(
        "pygame is not installed; teaching needs it: pip install khepera-forage[render]"
    ) from error

UNSEEN = ("offscreen", "dummy")
"""Video drivers of SDL whose windows nobody sees."""
SHARE = 0.92
"""Of the screen that the window takes at most when it opens."""
LISTEN = 200
"""Milliseconds after which Python may look for a Ctrl-C in the shell."""


class TeachingWindow:
    """Shows pictures with the keys under them, and waits for keys.

    The picture is scaled to the window, which can be made smaller.

    Raises:
        OSError: There is no display. SDL would then open a window that nobody sees; that is only what somebody wants
            who has set SDL_VIDEODRIVER.
    """

    def __init__(self) -> None:
        try:
            pygame.display.init()
        except pygame.error as error:
            raise OSError(f"no display to open a window on: {error}") from None
        driver = pygame.display.get_driver()
        if driver in UNSEEN and not os.environ.get("SDL_VIDEODRIVER"):
            pygame.display.quit()
            raise OSError(
                "no display to open a window on (SDL would draw off screen); "
                "run it on a desktop, or set DISPLAY or WAYLAND_DISPLAY"
            )
        self._painter = KeyboardPainter()
        self._picture = pygame.Surface((1, 1))

    def show(self, view: View, caption: Caption) -> None:
        """Show a picture, and what stands under it; the first one opens the window."""
        self._picture = self._painter.paint(view, caption)
        if pygame.display.get_surface() is None:
            width, height = pygame.display.get_desktop_sizes()[0]
            room = round(SHARE * width), round(SHARE * height)
            pygame.display.set_mode(_fitted(self._picture.get_size(), room), pygame.RESIZABLE)
            pygame.display.set_caption("khepera-forage teach")
        self._refresh()

    def wait(self, timeout: float | None = None) -> KeyEvent | None:
        """The next key that goes down or up; None if none does within `timeout` seconds."""
        until = None if timeout is None else time.monotonic() + timeout
        while True:
            left = LISTEN if until is None else max(0, min(LISTEN, round(1000 * (until - time.monotonic()))))
            event = pygame.event.wait(left) if left else pygame.event.poll()
            if event.type == pygame.QUIT:
                return KeyEvent("escape", True)
            if event.type in (pygame.KEYDOWN, pygame.KEYUP):
                # The digits at the right of a keyboard are called [0] to [9].
                return KeyEvent(pygame.key.name(event.key).strip("[]"), event.type == pygame.KEYDOWN)
            if event.type in (pygame.WINDOWEXPOSED, pygame.WINDOWSIZECHANGED):
                self._refresh()
            if event.type == pygame.NOEVENT and until is not None and time.monotonic() >= until:
                return None

    def close(self) -> None:
        """Take the window off the screen."""
        pygame.display.quit()

    def _refresh(self) -> None:
        """The picture, as large as it fits, in the middle of the window."""
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
    """The size of a picture, or a smaller one that fits some room, its proportions kept."""
    scale = min(1.0, room[0] / picture[0], room[1] / picture[1])
    return max(1, round(scale * picture[0])), max(1, round(scale * picture[1]))
