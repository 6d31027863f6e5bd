"""The renderer of the environments: draws views as arrays or in a window."""

import os
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.rendering.view import View
from khepera_forage.extras import require

if TYPE_CHECKING:
    from khepera_forage.envs.rendering.picture import Painter
    from khepera_forage.envs.rendering.window import Window

RENDER_MODES = ("human", "rgb_array")


class Renderer:
    """Draws views as arrays or in a window.

    In mode "rgb_array" no display is used, and equal views give equal pictures. In mode "human" the first view opens
    a window, and `draw` waits so that `fps` is kept. After the user has closed the window, `draw` does nothing.

    A copy, by `copy` or `pickle`, is a new renderer with the same mode and rate.

    Attributes:
        mode: "rgb_array" or "human".
        fps: Frames per second in a window.

    Raises:
        ValueError: Another mode, or a rate that is not positive.
        DependencyNotInstalled: pygame is not installed.
    """

    def __init__(self, mode: str, fps: float = 10) -> None:
        if mode not in RENDER_MODES:
            raise ValueError(f"render mode is {mode!r}; allowed: {', '.join(map(repr, RENDER_MODES))}")
        if not 0 < fps < float("inf"):
            raise ValueError(f"fps is {fps!r}; allowed: a positive number of frames per second")
        _require_pygame()
        self.mode = mode
        self.fps = fps
        self._painter: Painter | None = None
        self._window: Window | None = None

    def __reduce__(self) -> tuple[type["Renderer"], tuple[str, float]]:
        return type(self), (self.mode, self.fps)

    @property
    def closed_by_user(self) -> bool:
        """Whether the user closed the window; False again after `close`."""
        return self._window is not None and self._window.closed_by_user

    def draw(self, view: View) -> NDArray[np.uint8] | None:
        """Draw the view.

        Returns:
            In mode "rgb_array" a new uint8 array, height x width x 3; otherwise None.

        Raises:
            ValueError: The view has no arena.
        """
        if self.closed_by_user:
            return None
        from khepera_forage.envs.rendering.picture import Painter, to_array

        if self._painter is None:
            self._painter = Painter()
        picture = self._painter.paint(view)
        if self.mode == "rgb_array":
            return to_array(picture)
        if self._window is None:
            from khepera_forage.envs.rendering.window import Window

            self._window = Window(self.fps)
        self._window.show(picture, view.title)
        return None

    def close(self) -> None:
        """Close the window and release all surfaces; a second call does nothing, and `draw` opens a new window."""
        window, self._window, self._painter = self._window, None, None
        if window is not None:
            window.close()


def _require_pygame() -> None:
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # a library does not print
    require("rendering", "render")
