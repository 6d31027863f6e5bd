"""Films: every format can be read again, and an error leaves an existing file as it was."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.envs.rendering.film import CODECS, save_film

pytest.importorskip("cv2")
FRAMES = [np.full((48, 64, 3), 40 * k, np.uint8) for k in range(5)]


@pytest.mark.parametrize("ending", CODECS)
def test_films_have_all_frames_and_their_colours(ending: str, tmp_path: Path) -> None:
    import cv2

    frames = [frame.copy() for frame in FRAMES]
    for frame in frames:
        frame[:, :, 0] = 200  # red
    film = cv2.VideoCapture(str(save_film(frames, tmp_path / f"film{ending}", 10.0)))
    assert film.get(cv2.CAP_PROP_FPS) == pytest.approx(10.0)
    shown: list[NDArray[Any]] = []
    while (read := film.read())[0]:
        shown.append(cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB))
    assert len(shown) == len(frames)
    for one, other in zip(shown, frames, strict=True):
        assert np.abs(one.astype(int).mean(axis=(0, 1)) - other.astype(int).mean(axis=(0, 1))).max() < 12


@pytest.mark.parametrize("ending", [".gif", ".mp4", ".avi"])
def test_error_leaves_an_existing_film(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"film{ending}"
    path.write_bytes(b"earlier")
    with pytest.raises(ValueError, match=r"frame 1 is \(2, 2, 3\), frame 0 is"):
        save_film([FRAMES[0], np.zeros((2, 2, 3), np.uint8)], path, 10.0)
    assert path.read_bytes() == b"earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_other_endings_and_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match=r"film is 'film.mov'; allowed: a name that ends in .gif, .mp4, .avi"
    ):
        save_film(FRAMES, "film.mov", 10.0)
    with pytest.raises(OSError, match="nowhere"):
        save_film(FRAMES, tmp_path / "nowhere" / "film.mp4", 10.0)
