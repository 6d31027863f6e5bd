"""A window that shows pictures and waits for keys and clicks; needs a display and pygame (extra `render`)."""

import os
import time

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
import pygame

from khepera_forage.envs.rendering.output import open_display

MAX_SCREEN_SHARE = 0.92
"""Largest share of the screen's width or height that the window takes when it opens."""
POLL_MILLISECONDS = 200
"""Longest wait for an event; between waits Python handles a Ctrl-C in the shell."""


class Window:
    """A resizable window that shows one picture after the other, scaled down where it is too small for them.

    Attributes:
        clicks: Where the user clicked since the list was cleared, in pixels of the picture: u to the right, v down. The
            middle of the upper left pixel is (0.5, 0.5).

    Raises:
        OSError: There is no display (see `envs.rendering.output`).
    """

    def __init__(self) -> None:
        open_display()
        self.clicks: list[tuple[float, float]] = []
        self._picture = pygame.Surface((1, 1))

    def show_picture(self, picture: pygame.Surface, title: str) -> None:
        """Show a picture; the first call opens the window."""
        self._picture = picture
        if pygame.display.get_surface() is None:
            width, height = pygame.display.get_desktop_sizes()[0]
            room = round(MAX_SCREEN_SHARE * width), round(MAX_SCREEN_SHARE * height)
            pygame.display.set_mode(_shrunk(picture.get_size(), room), pygame.RESIZABLE)
        pygame.display.set_caption(title)
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
            if event.type == pygame.MOUSEBUTTONDOWN and event.button == 1:
                place = self._place()
                scale = self._picture.get_width() / place.width
                u, v = event.pos[0] + 0.5 - place.left, event.pos[1] + 0.5 - place.top
                self.clicks.append((scale * u, scale * v))
            if event.type in (pygame.WINDOWEXPOSED, pygame.WINDOWSIZECHANGED):
                self._refresh()
            if event.type == pygame.NOEVENT and until is not None and time.monotonic() >= until:
                return None

    def close(self) -> None:
        """Close the window."""
        pygame.display.quit()

    def _place(self) -> pygame.Rect:
        """Where the picture is in the window: in the middle, scaled down if it is too large."""
        place = pygame.Rect((0, 0), _shrunk(self._picture.get_size(), pygame.display.get_window_size()))
        place.center = pygame.Rect((0, 0), pygame.display.get_window_size()).center
        return place

    def _refresh(self) -> None:
        screen, picture = pygame.display.get_surface(), self._picture
        if screen is None:
            return
        place = self._place()
        if place.size != picture.get_size():
            picture = pygame.transform.smoothscale(picture, place.size)
        screen.fill(picture.get_at((0, 0)))
        screen.blit(picture, place)
        pygame.display.flip()


def _shrunk(picture: tuple[int, int], room: tuple[int, int]) -> tuple[int, int]:
    """The size of a picture, scaled down to fit the room; the proportions stay the same."""
    scale = min(1.0, room[0] / picture[0], room[1] / picture[1])
    return max(1, round(scale * picture[0])), max(1, round(scale * picture[1]))
