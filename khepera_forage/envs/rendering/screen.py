"""The screen of an environment: its render mode, and a renderer created when it is first needed."""

from collections.abc import Callable

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.rendering.renderer import RENDER_MODES, Renderer
from khepera_forage.envs.rendering.view import View


class Screen:
    """Shows the pictures of one environment; a window opens with the first picture.

    Args:
        mode: One of `RENDER_MODES`, or None for an environment without pictures.
        round_duration: Seconds from one picture to the next in a window.

    Raises:
        ValueError: Another mode.
    """

    def __init__(self, mode: str | None, round_duration: float) -> None:
        if mode is not None and mode not in RENDER_MODES:
            raise ValueError(f"render_mode is {mode!r}; allowed: None, {', '.join(map(repr, RENDER_MODES))}")
        self._mode = mode
        self._fps = 1 / round_duration
        self._renderer: Renderer | None = None

    def show(self, view: Callable[[], View]) -> NDArray[np.uint8] | None:
        """Draw a picture: returned as an array in mode "rgb_array", shown in the window in mode "human".

        Args:
            view: Creates the view; called only if there is a render mode.
        """
        if self._mode is None:
            gym.logger.warn(
                "render() without a render_mode; make the environment with render_mode='rgb_array'"
            )
            return None
        if self._renderer is None:
            self._renderer = Renderer(self._mode, self._fps)
        return self._renderer.draw(view())

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
