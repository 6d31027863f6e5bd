"""Animated GIFs from frames."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from khepera_forage.extras import require
from khepera_forage.files import replacing

if TYPE_CHECKING:
    import PIL.Image

MIN_DIFFERENCE = 10
"""Least difference of two colours of the palette in red, green or blue."""
PALETTE_FRAMES = 16
"""Number of frames from which the palette is made."""


def save_gif(frames: Sequence[NDArray[np.uint8]], path: str | os.PathLike[str], fps: float = 10.0) -> Path:
    """Write frames as an endlessly repeating GIF; after an error an existing file is unchanged.

    Args:
        frames: Pictures of one size, uint8, height x width x 3.
        path: Path of the file; its folder must exist.
        fps: Frames per second, rounded to a frame duration in whole hundredths of a second, at least two.

    Returns:
        The path.

    Raises:
        ValueError: No frames, a frame of another type or size, or a rate that is not positive.
        DependencyNotInstalled: Pillow is not installed.
    """
    check_frames(frames, fps)
    require("an animated GIF", "render")
    import PIL.Image

    path = Path(path)
    palette = _palette([frames[i] for i in _palette_frames(len(frames))])
    # With one palette and no dithering, static parts are equal from frame to frame and take no bytes.
    pictures = (_picture(f).quantize(palette=palette, dither=PIL.Image.Dither.NONE) for f in frames)
    with replacing(path) as partial:
        next(pictures).save(
            partial,
            format="GIF",
            save_all=True,
            append_images=pictures,
            duration=max(2, round(100 / fps)) * 10,
            loop=0,
            optimize=True,
        )
    return path


def check_frames(frames: Sequence[NDArray[np.uint8]], fps: float) -> None:
    """Check what a film is made of.

    Raises:
        ValueError: No frames, a frame of another type or size, or a rate that is not positive.
    """
    if not 0 < fps < float("inf"):
        raise ValueError(f"fps is {fps!r}; allowed: a positive number of frames per second")
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
                f"frame {number} is {frame.shape}, frame 0 is {frames[0].shape}; allowed: one size, not empty"
            )


def _picture(frame: NDArray[np.uint8]) -> "PIL.Image.Image":
    import PIL.Image

    return PIL.Image.fromarray(np.ascontiguousarray(frame))


def _palette_frames(count: int) -> list[int]:
    """Indices of at most `PALETTE_FRAMES` evenly spaced frames, including the first."""
    chosen = min(count, PALETTE_FRAMES)
    return [i * count // chosen for i in range(chosen)]


def _palette(frames: Sequence[NDArray[np.uint8]]) -> "PIL.Image.Image":
    """One palette for all frames: the most frequent colours, without near duplicates.

    A median cut would spend most entries on the half-tones of letters, and change the colours of flat areas.
    """
    import PIL.Image

    combined = _picture(np.concatenate(frames))
    counts = cast(
        "list[tuple[int, tuple[int, int, int]]]", combined.getcolors(combined.width * combined.height)
    )
    remaining = np.array([colour for _, colour in sorted(counts, reverse=True)], np.int16)
    chosen: list[int] = []
    while len(remaining) and len(chosen) < 3 * 256:
        chosen.extend(remaining[0].tolist())
        remaining = remaining[np.abs(remaining - remaining[0]).max(axis=1) >= MIN_DIFFERENCE]
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette(chosen)
    return palette
