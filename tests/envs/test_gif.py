"""Animated GIFs of frames."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from khepera_forage.envs.rendering import FoodView, Renderer, RobotView, View, save_gif
from khepera_forage.sim.arena import Pose
from tests.version_0_1 import CORRIDOR


def test_gif_has_the_frames(tmp_path: Path) -> None:
    renderer = Renderer("rgb_array")
    robot = RobotView(Pose(0.0, 0.0, 0.0), 2, 215, 200, (0, 100, 900, 300, 20, 0, 0, 1023), "learner")
    robots = [robot._replace(pose=Pose(100.0 + 30 * i, 115.0, 0.0)) for i in range(4)]
    food = FoodView(370.0, 115.0)
    views = [View((CORRIDOR,), (moved,), (food,), step=i, limit=9) for i, moved in enumerate(robots)]
    frames = [frame for frame in map(renderer.draw, views) if frame is not None]
    renderer.close()
    path = save_gif(frames, tmp_path / "animation.gif", fps=5)
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


def test_gif_of_one_noncontiguous_frame(tmp_path: Path) -> None:
    frame = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    save_gif([frame[::-1]], str(tmp_path / "still.gif"), fps=1000)
    with Image.open(tmp_path / "still.gif") as gif:
        assert gif.size == (5, 4)


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
        save_gif(frames, tmp_path / "animation.gif", fps=10)
    with pytest.raises(ValueError, match="fps"):
        save_gif([np.zeros((4, 4, 3), np.uint8)], tmp_path / "animation.gif", fps=0)
    assert (tmp_path / "animation.gif").read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1
