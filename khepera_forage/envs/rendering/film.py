"""Films from frames: GIF, or formats that OpenCV writes."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.rendering.gif import check_frames, save_gif
from khepera_forage.extras import require
from khepera_forage.files import replacing

CODECS = {".mp4": "mp4v", ".avi": "MJPG"}
"""Of films that OpenCV writes (extra `camera`), by the ending of their names."""
FILM_EXTRAS = {".gif": "render", **dict.fromkeys(CODECS, "camera")}
"""The extra that writes each format, by the ending of the name."""


def save_film(frames: Sequence[NDArray[np.uint8]], path: str | os.PathLike[str], fps: float) -> Path:
    """Write frames as a film; after an error an existing file is unchanged.

    Args:
        frames: Pictures of one size, uint8, height x width x 3, red, green, blue.
        path: Path of the file, which ends in .gif, .mp4 or .avi; its folder must exist.
        fps: Frames per second.

    Returns:
        The path.

    Raises:
        ValueError: Another ending, no frames, a frame of another type or size, or a rate that is not positive.
        OSError: The file cannot be written.
        ImportError: What writes the format is not installed.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in FILM_EXTRAS:
        raise ValueError(f"film is {str(path)!r}; allowed: a name that ends in {', '.join(FILM_EXTRAS)}")
    if kind == ".gif":
        return save_gif(frames, path, fps)
    check_frames(frames, fps)
    require(f"a film {kind}", FILM_EXTRAS[kind])
    import cv2

    height, width = frames[0].shape[:2]
    with replacing(path) as partial:
        film = cv2.VideoWriter(str(partial), cv2.VideoWriter.fourcc(*CODECS[kind]), fps, (width, height))
        if not film.isOpened():
            raise OSError(f"{path}: OpenCV cannot write a film there")
        for frame in frames:
            film.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
        film.release()
    return path
