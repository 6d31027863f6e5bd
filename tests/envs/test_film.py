"""Films: every format can be read again, and an error leaves an existing file as it was."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from khepera_forage.envs.rendering import FoodView, RobotView, View, save_film
from khepera_forage.envs.rendering.output import CODECS
from khepera_forage.envs.rendering.picture import Painter, to_array
from khepera_forage.sim.arena import Pose
from tests.version_0_1 import CORRIDOR

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


def test_other_endings_and_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match=r"film is 'film.mov'; allowed: a name that ends in .gif, .mp4, .avi"
    ):
        save_film(FRAMES, "film.mov", 10.0)
    with pytest.raises(OSError, match="nowhere"):
        save_film(FRAMES, tmp_path / "nowhere" / "film.mp4", 10.0)


def test_gif_has_the_frames(tmp_path: Path) -> None:
    painter = Painter()
    robot = RobotView(Pose(0.0, 0.0, 0.0), 2, 215, 200, (0, 100, 900, 300, 20, 0, 0, 1023), "learner")
    robots = [robot._replace(pose=Pose(100.0 + 30 * i, 115.0, 0.0)) for i in range(4)]
    food = FoodView(370.0, 115.0)
    views = [View((CORRIDOR,), (moved,), (food,), step=i, limit=9) for i, moved in enumerate(robots)]
    frames = [to_array(painter.paint(view)) for view in views]
    path = save_film(frames, tmp_path / "animation.gif", fps=5)
    assert list(tmp_path.iterdir()) == [path]
    with Image.open(path) as gif:
        assert gif.size == (frames[0].shape[1], frames[0].shape[0])
        assert getattr(gif, "n_frames") == 4  # noqa: B009  only animated pictures have it
        assert gif.info["duration"] == 200
        assert gif.info["loop"] == 0
        for number, frame in enumerate(frames):
            gif.seek(number)
            error = np.abs(np.asarray(gif.convert("RGB")).astype(int) - frame)
            assert error.mean() < 0.5
            assert (error.max(axis=2) > 60).mean() < 0.001


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ([], "no frames"),
        ([np.zeros((4, 4, 3))], "float64"),
        ([np.zeros((4, 4), np.uint8)], r"\(4, 4\)"),
        ([np.zeros((4, 4, 4), np.uint8)], r"\(4, 4, 4\)"),
        ([np.zeros((0, 4, 3), np.uint8)], "not empty"),
        ([np.zeros((4, 4, 3), np.uint8), np.zeros((4, 5, 3), np.uint8)], "one size"),
        ([None], "NoneType"),
    ],
)
def test_invalid_frames_are_refused_and_the_old_file_is_kept(
    tmp_path: Path, frames: list[NDArray[np.uint8]], words: str
) -> None:
    (tmp_path / "animation.gif").write_text("old")
    with pytest.raises(ValueError, match=words):
        save_film(frames, tmp_path / "animation.gif", fps=10)
    with pytest.raises(ValueError, match="fps"):
        save_film([np.zeros((4, 4, 3), np.uint8)], tmp_path / "animation.gif", fps=0)
    assert (tmp_path / "animation.gif").read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1
