"""The renderer of the environments: views in, pictures or a window out."""

import importlib
import os
from typing import TYPE_CHECKING

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from khepera_forage.envs.rendering.view import View

if TYPE_CHECKING:
    from khepera_forage.envs.rendering.painter import Painter
    from khepera_forage.envs.rendering.window import Window

MODES = ("rgb_array", "human")


class Renderer:
    """Draws views, as arrays or in a window.

    "rgb_array" touches no display, and equal views give equal pictures. "human" opens one window at the first
    view and keeps the pace; once somebody has closed it, further views are neither shown nor waited for.

    A copy, by `copy` or `pickle`, is a fresh renderer of the same mode and rate.

    Attributes:
        mode: "rgb_array" or "human".
        fps: Frames a second, in a window.

    Raises:
        ValueError: Another mode, or a rate that is not positive.
        DependencyNotInstalled: pygame is missing.
    """

    def __init__(self, mode: str, fps: float = 10) -> None:
        if mode not in MODES:
            raise ValueError(f"render mode is {mode!r}; allowed: {', '.join(map(repr, MODES))}")
        if not 0 < fps < float("inf"):
            raise ValueError(f"fps is {fps!r}; allowed: a positive number of frames a second")
        _require_pygame()
        self.mode = mode
        self.fps = fps
        self._painter: Painter | None = None
        self._window: Window | None = None

    def __reduce__(self) -> tuple[type["Renderer"], tuple[str, float]]:
        return type(self), (self.mode, self.fps)

    @property
    def dismissed(self) -> bool:
        """Whether somebody closed the window: nobody watches until the next `close`."""
        return self._window is not None and self._window.dismissed

    def draw(self, view: View) -> NDArray[np.uint8] | None:
        """The view as a fresh uint8 array, height x width x 3; or in the window, when nothing is returned.

        Raises:
            ValueError: The view has no arena.
        """
        if self.dismissed:
            return None
        if self._painter is None:
            from khepera_forage.envs.rendering.painter import Painter

            self._painter = Painter()
        picture = self._painter.paint(view)
        if self.mode == "rgb_array":
            return self._painter.pixels(picture)
        if self._window is None:
            from khepera_forage.envs.rendering.window import Window

            self._window = Window(self.fps)
        self._window.show(picture, view.title)
        return None

    def close(self) -> None:
        """Close the window and let go of all surfaces; a second call does nothing, and `draw` begins anew."""
        window, self._window, self._painter = self._window, None, None
        if window is not None:
            window.close()


def _require_pygame() -> None:
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # a library does not print
    try:
        importlib.import_module("pygame")
    except ImportError as error:
        raise DependencyNotInstalled(
            "pygame is not installed; rendering needs it: pip install khepera-forage[render]"
        ) from error
