"""Where pictures go: to an array, to a window, or into a film.

pygame and Pillow (extra `render`) and OpenCV (extra `camera`) are imported when they are first needed.
"""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.rendering.view import View
from khepera_forage.extras import require
from khepera_forage.files import has_utf8_name, replacing

if TYPE_CHECKING:
    import PIL.Image
    import pygame

    from khepera_forage.envs.rendering.picture import Painter

RENDER_MODES = ("human", "rgb_array")

CODECS = {".mp4": "mp4v", ".avi": "MJPG"}
"""Of films that OpenCV writes, by the ending of their names."""
FILM_EXTRAS = {".gif": "render", **dict.fromkeys(CODECS, "camera")}
"""The extra that writes each format, by the ending of the name."""
MIN_DIFFERENCE = 10
"""Least difference of two colours of a GIF's palette in red, green or blue."""
PALETTE_FRAMES = 16
"""Number of frames from which the palette is made."""


class Screen:
    """Shows the pictures of one environment.

    In mode "rgb_array" no display is used, and equal views give equal pictures. In mode "human" the first picture opens
    a window, and `show` waits until the round is over. After the user has closed the window, `show` does nothing.

    A copy, by `copy` or `pickle`, is a new screen with the same mode and duration.

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
        self._round_duration = round_duration
        self._painter: Painter | None = None
        self._window: pygame.Surface | None = None
        self._clock: pygame.time.Clock
        self._closed_by_user = False

    def __reduce__(self) -> tuple[type["Screen"], tuple[str | None, float]]:
        return type(self), (self._mode, self._round_duration)

    def show(self, view: Callable[[], View]) -> NDArray[np.uint8] | None:
        """Draw a picture.

        Args:
            view: Creates the view; called only if a picture is drawn.

        Returns:
            In mode "rgb_array" a new uint8 array, height x width x 3; otherwise None.

        Raises:
            DependencyNotInstalled: pygame is not installed.
            ValueError: The view has no arena.
        """
        if self._mode is None:
            gym.logger.warn("render() without a render_mode; make the environment with render_mode='rgb_array'")
            return None
        if self._closed_by_user:
            return None
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # a library does not print
        require("rendering", "render")
        from khepera_forage.envs.rendering.picture import Painter, to_array

        if self._painter is None:
            self._painter = Painter()
        shown = view()
        picture = self._painter.paint(shown)
        if self._mode == "rgb_array":
            return to_array(picture)
        self._show_in_window(picture, shown.title)
        return None

    def close(self) -> None:
        """Close the window and release all surfaces; a second call does nothing, and `show` opens a new window."""
        window, self._window, self._painter, self._closed_by_user = self._window, None, None, False
        if window is not None:
            import pygame

            pygame.display.quit()

    def _show_in_window(self, picture: "pygame.Surface", title: str) -> None:
        """Show a picture, then wait until the next one is due."""
        import pygame

        if self._window is None:
            self._clock = pygame.time.Clock()
            try:
                open_display()
            except OSError as error:
                gym.logger.warn(f"{error}. Nobody sees this window")
        if self._window is None or self._window.get_size() != picture.get_size():
            pygame.display.init()
            self._window = pygame.display.set_mode(picture.get_size())
        pygame.display.set_caption(title or "khepera_forage")
        self._window.blit(picture, (0, 0))
        pygame.display.flip()
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self.close()
            self._closed_by_user = True
        else:
            self._clock.tick(1 / self._round_duration)


def open_display() -> None:
    """Get the display ready for a window.

    Raises:
        OSError: There is none. SDL would then open an invisible window, which is only accepted if the environment
            variable SDL_VIDEODRIVER is set.
    """
    import pygame

    try:
        pygame.display.init()
    except pygame.error as error:
        raise OSError(f"no display to open a window on: {error}") from None
    if pygame.display.get_driver() in ("offscreen", "dummy") and not os.environ.get("SDL_VIDEODRIVER"):
        pygame.display.quit()
        raise OSError(
            "no display to open a window on (SDL would draw off screen); run it on a desktop, or set DISPLAY or "
            "WAYLAND_DISPLAY"
        )


def save_film(frames: Sequence[NDArray[np.uint8]], path: str | os.PathLike[str], fps: float) -> Path:
    """Write frames as a film; after an error an existing file is unchanged.

    Args:
        frames: Pictures of one size, uint8, height x width x 3, red, green, blue.
        path: Path of the file, which ends in .gif, .mp4 or .avi; its folder must exist.
        fps: Frames per second. A GIF shows each frame for whole hundredths of a second, at least two.

    Returns:
        The path.

    Raises:
        ValueError: Another ending, no frames, a frame of another type or size, or a rate that is not positive.
        OSError: The file cannot be written.
        DependencyNotInstalled: What writes the format is not installed.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in FILM_EXTRAS:
        raise ValueError(f"film is {str(path)!r}; allowed: a name that ends in {', '.join(FILM_EXTRAS)}")
    _check_frames(frames, fps)
    require(f"a film {kind}", FILM_EXTRAS[kind])
    with replacing(path) as partial:
        if kind == ".gif":
            _write_gif(frames, partial, fps)
        elif not has_utf8_name(partial) or not _write_video(frames, partial, fps, CODECS[kind]):
            raise OSError(
                f"{path}: OpenCV cannot write a film there; allowed: a name in UTF-8, in a folder that exists"
            )
    return path


def _check_frames(frames: Sequence[NDArray[np.uint8]], fps: float) -> None:
    if not 0 < fps < float("inf"):
        raise ValueError(f"fps is {fps!r}; allowed: a positive number of frames per second")
    if len(frames) == 0:
        raise ValueError("no frames; allowed: at least one")
    for number, frame in enumerate(frames):
        what = f"{frame.dtype} {frame.shape}" if isinstance(frame, np.ndarray) else type(frame).__name__
        if not what.startswith("uint8 ") or frame.ndim != 3 or frame.shape[2] != 3 or frame.size == 0:
            raise ValueError(f"frame {number} is {what}; allowed: uint8 arrays, height x width x 3, not empty")
        if frame.shape != frames[0].shape:
            raise ValueError(f"frame {number} is {frame.shape}, frame 0 is {frames[0].shape}; allowed: one size")


def _write_video(frames: Sequence[NDArray[np.uint8]], path: Path, fps: float, codec: str) -> bool:
    """Write a film with OpenCV; False if the file cannot be opened."""
    import cv2

    height, width = frames[0].shape[:2]
    film = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), fps, (width, height))
    if not film.isOpened():
        return False
    for frame in frames:
        film.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    film.release()
    return True


def _write_gif(frames: Sequence[NDArray[np.uint8]], path: Path, fps: float) -> None:
    """Write an endlessly repeating GIF with one palette and no dithering, so that static parts take no bytes."""
    from PIL import Image

    chosen = min(len(frames), PALETTE_FRAMES)
    palette = _palette([frames[i * len(frames) // chosen] for i in range(chosen)])
    pictures = (
        Image.fromarray(np.ascontiguousarray(frame)).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    next(pictures).save(
        path,
        format="GIF",
        save_all=True,
        append_images=pictures,
        duration=max(2, round(100 / fps)) * 10,
        loop=0,
        optimize=True,
    )


def _palette(frames: Sequence[NDArray[np.uint8]]) -> "PIL.Image.Image":
    """One palette for all frames: the most frequent colours, without near duplicates.

    A median cut would spend most entries on the half-tones of letters, and change the colours of flat areas.
    """
    from PIL import Image

    combined = Image.fromarray(np.concatenate(frames))
    counts = cast("list[tuple[int, tuple[int, int, int]]]", combined.getcolors(combined.width * combined.height))
    remaining = np.array([colour for _, colour in sorted(counts, reverse=True)], np.int16)
    chosen: list[int] = []
    while len(remaining) and len(chosen) < 3 * 256:
        chosen.extend(remaining[0].tolist())
        remaining = remaining[np.abs(remaining - remaining[0]).max(axis=1) >= MIN_DIFFERENCE]
    palette = Image.new("P", (1, 1))
    palette.putpalette(chosen)
    return palette
