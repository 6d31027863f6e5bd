"""The display that windows open on."""

import os

import pygame

INVISIBLE_DRIVERS = ("offscreen", "dummy")
"""Video drivers of SDL whose windows are invisible."""


def open_display() -> None:
    """Get the display ready for a window.

    Raises:
        OSError: There is none. SDL would then open an invisible window, which is only accepted if the environment
            variable SDL_VIDEODRIVER is set.
    """
    try:
        pygame.display.init()
    except pygame.error as error:
        raise OSError(f"no display to open a window on: {error}") from None
    if pygame.display.get_driver() in INVISIBLE_DRIVERS and not os.environ.get("SDL_VIDEODRIVER"):
        pygame.display.quit()
        raise OSError(
            "no display to open a window on (SDL would draw off screen); run it on a desktop, or set DISPLAY or "
            "WAYLAND_DISPLAY"
        )
