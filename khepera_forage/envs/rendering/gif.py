"""Films: frames to an animated GIF."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

if TYPE_CHECKING:
    import PIL.Image

APART = 10
"""Colours of the palette differ by at least this much in red, green or blue."""
SAMPLE = 16
"""Frames from which the palette is made."""


def save_gif(frames: Sequence[NDArray[np.uint8]], path: str | os.PathLike[str], fps: float = 10.0) -> Path:
    """Write frames as an endlessly repeating GIF; an existing file is replaced in one go, or left as it was.

    Args:
        frames: Pictures of one size, uint8, height x width x 3.
        path: Of the file; its folder exists.
        fps: Frames a second; the format keeps whole hundredths of a second, at least two of them.

    Returns:
        The path.

    Raises:
        ValueError: No frame, a frame that is not such a picture, or a rate that is not positive.
        DependencyNotInstalled: Pillow is missing.
    """
    _check(frames, fps)
    try:
        import PIL.Image
    except ImportError as error:
        raise DependencyNotInstalled(
            "Pillow is not installed; films need it: pip install khepera-forage[render]"
        ) from error
    path = Path(path)
    palette = _palette([frames[i] for i in _spread(len(frames))])
    # One palette and no dithering: what stands still is then equal from frame to frame, and costs no bytes.
    pictures = (_picture(f).quantize(palette=palette, dither=PIL.Image.Dither.NONE) for f in frames)
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        next(pictures).save(
            partial,
            format="GIF",
            save_all=True,
            append_images=pictures,
            duration=max(2, round(100 / fps)) * 10,
            loop=0,
            optimize=True,
        )
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
    return path


def _check(frames: Sequence[NDArray[np.uint8]], fps: float) -> None:
    if not 0 < fps < float("inf"):
        raise ValueError(f"fps is {fps!r}; allowed: a positive number of frames a second")
    if len(frames) == 0:
        raise ValueError("no frames; allowed: at least one")
    for number, frame in enumerate(frames):
        if (
            not isinstance(frame, np.ndarray)
            or frame.dtype != np.uint8
            or frame.ndim != 3
            or frame.shape[2] != 3
        ):
            what = f"{frame.dtype} {frame.shape}" if isinstance(frame, np.ndarray) else type(frame).__name__
            raise ValueError(f"frame {number} is {what}; allowed: a uint8 array, height x width x 3")
        if frame.size == 0 or frame.shape != frames[0].shape:
            raise ValueError(
                f"frame {number} is {frame.shape}, frame 0 {frames[0].shape}; allowed: one size, not empty"
            )


def _picture(frame: NDArray[np.uint8]) -> "PIL.Image.Image":
    import PIL.Image

    return PIL.Image.fromarray(np.ascontiguousarray(frame))


def _spread(count: int) -> list[int]:
    """At most `SAMPLE` of so many frames, evenly spread, the first among them."""
    chosen = min(count, SAMPLE)
    return [i * count // chosen for i in range(chosen)]


def _palette(frames: Sequence[NDArray[np.uint8]]) -> "PIL.Image.Image":
    """One palette for all the film: its most frequent colours, exactly, but none that nearly repeats another.

    A median cut would spend most entries on half-tones of letters, and shift the flat colours.
    """
    import PIL.Image

    sheet = _picture(np.concatenate(frames))
    counts = cast("list[tuple[int, tuple[int, int, int]]]", sheet.getcolors(sheet.width * sheet.height))
    left = np.array([colour for _, colour in sorted(counts, reverse=True)], np.int16)
    chosen: list[int] = []
    while len(left) and len(chosen) < 3 * 256:
        chosen.extend(left[0].tolist())
        left = left[np.abs(left - left[0]).max(axis=1) >= APART]
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette(chosen)
    return palette
