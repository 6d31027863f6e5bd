"""Films: frames to an animated GIF."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

COLOURS = 128
"""In the palette that all frames share: enough for our flat colours and their edges, and half the bytes of 256."""


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
        from PIL import Image
    except ImportError as error:
        raise DependencyNotInstalled(
            "Pillow is not installed; films need it: pip install khepera-forage[render]"
        ) from error
    path = Path(path)
    pictures = [Image.fromarray(np.ascontiguousarray(frame)) for frame in frames]
    palette = _palette(pictures)
    # One palette and no dithering: what stands still is then equal from frame to frame, and costs no bytes.
    pictures = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        pictures[0].save(
            partial,
            format="GIF",
            save_all=True,
            append_images=pictures[1:],
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


def _palette(pictures: Sequence[Any]) -> Any:
    """A palette of all the film: from up to eight of its frames, evenly spread, side by side."""
    from PIL import Image

    chosen = [pictures[i * (len(pictures) - 1) // 7] for i in range(8)] if len(pictures) > 8 else pictures
    width, height = chosen[0].size
    sheet = Image.new("RGB", (width, height * len(chosen)))
    for row, picture in enumerate(chosen):
        sheet.paste(picture, (0, row * height))
    return sheet.quantize(colors=COLOURS, dither=Image.Dither.NONE)
