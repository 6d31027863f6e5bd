"""Pictures and films of the environments: every value of a view is visible, and films can be read again."""

import copy
import pickle
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pygame
import pytest
import shapely
from numpy.typing import NDArray
from PIL import Image

from khepera_forage.envs.rendering import FoodView, RobotView, Screen, View, save_film
from khepera_forage.envs.rendering.output import CODECS
from khepera_forage.envs.rendering.picture import MAX_HEIGHT, MAX_WIDTH, PictureLayout, arrange
from khepera_forage.sim.arena import Arena, Pose, copies
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector
from khepera_forage.vision.scene import MM_PER_PIXEL, Region
from tests.arenas import BLOCKS
from tests.version_0_1 import CORRIDOR, RECTANGLE

LEARNER = RobotView(
    pose=Pose(150.0, 115.0, 0.3),
    holes=2,
    arm=215,
    jaw=200,
    proximity=(0, 100, 900, 300, 20, 0, 0, 1023),
    name="learner",
    vector=StateVector(0, 80, 0, 215, 44),
    state=State.SEARCH,
    executed=Behaviour.SEARCH_FOR_FOOD,
    confidence=(0.75, 0.25, 0, 0, 0, 0, 0, 0, 0, 0),
)
VIEW = View((CORRIDOR,), (LEARNER,), (FoodView(370.0, 115.0),), step=3, limit=500, score=100.0, title="Corridor")


def region(x: float, y: float, holes: int, found: bool = True) -> Region:
    return Region(0, x / MM_PER_PIXEL, y / MM_PER_PIXEL, holes, 20, found, False, 0, 0, 0, 0)


@pytest.fixture
def screen() -> Iterator[Screen]:
    screen = Screen("rgb_array", 0.1)
    yield screen
    screen.close()


def draw(screen: Screen, view: View) -> NDArray[np.uint8]:
    frame = screen.show(lambda: view)
    assert frame is not None
    return frame


def patch(layout: PictureLayout, frame: NDArray[np.uint8], x: float, y: float, reach: float) -> NDArray[np.uint8]:
    """The square of pixels around a position in mm."""
    (left, top), (right, bottom) = layout.pixel(x - reach, y + reach), layout.pixel(x + reach, y - reach)
    return frame[top : bottom + 1, left : right + 1]


def test_equal_views_give_equal_new_pictures_in_any_order(screen: Screen) -> None:
    busy = VIEW._replace(
        arenas=(RECTANGLE,),
        robots=(LEARNER._replace(separated=True, tracked=False, arm=255, jaw=0),),
        regions=(region(100, 100, 2), region(300, 300, 1, found=False), region(370, 200, 0, found=False)),
        foods=tuple(FoodView(100.0 * kind + 100, 400.0, kind, kind > 1, kind > 2) for kind in FoodType),
    )
    other = Screen("rgb_array", 0.1)
    first = draw(screen, VIEW)
    assert first.dtype == np.uint8
    assert first.shape[2:] == (3,)
    kept = first.copy()
    np.testing.assert_array_equal(draw(screen, busy), draw(other, busy))
    first[:] = 0
    pygame.quit()  # as Gymnasium's own environments do when they are closed
    for again in (screen, other, copy.deepcopy(screen), pickle.loads(pickle.dumps(screen))):
        np.testing.assert_array_equal(draw(again, VIEW), kept)
    other.close()


CHANGES: list[dict[str, Any]] = [
    *({"arm": 255}, {"jaw": 0}, {"holes": 1}, {"proximity": (0,) * 8}, {"name": "learner 7"}),
    *({"vector": StateVector(1, 80, 0, 215, 44)}, {"vector": None}, {"state": State.AT_HOME_NO_FOOD}),
    *({"heard": Behaviour.GO_HOME}, {"heard": Behaviour.WAIT}, {"executed": Behaviour.WAIT}, {"executed": None}),
    *({"correct": Behaviour.GO_HOME}, {"confidence": None}, {"separated": True}, {"tracked": False}),
    {"has_gripper": False},
]


@pytest.mark.parametrize("change", CHANGES, ids="-".join)
def test_every_attribute_of_a_robot_is_visible(screen: Screen, change: dict[str, Any]) -> None:
    plain = draw(screen, VIEW)
    changed = draw(screen, VIEW._replace(robots=(LEARNER._replace(**change),)))
    assert changed.shape == plain.shape
    assert not np.array_equal(changed, plain)


def test_food_types_differ_by_more_than_colour(screen: Screen) -> None:
    layout = arrange((CORRIDOR,), 1)
    symbols = []
    for kind in FoodType:
        frame = draw(screen, VIEW._replace(foods=(FoodView(250.0, 180.0, kind),)))
        around = patch(layout, frame, 250.0, 180.0, 9.0).astype(int)
        symbols.append(np.abs(around - 255).max(axis=2) < 60)
    assert all(not np.array_equal(a, b) for i, a in enumerate(symbols) for b in symbols[:i])


@pytest.mark.parametrize("holes", [0, 1, 2])
def test_lost_regions_are_drawn_in_red(screen: Screen, holes: int) -> None:
    layout = arrange((CORRIDOR,), 1)

    def max_redness(regions: tuple[Region, ...]) -> int:
        around = patch(layout, draw(screen, VIEW._replace(regions=regions)), 280.0, 115.0, 70.0).astype(int)
        return int((around[..., 0] - np.maximum(around[..., 1], around[..., 2])).max())

    assert max_redness((region(280.0, 115.0, holes, found=False),)) > 60
    assert max_redness((region(280.0, 115.0, holes),)) < 20


def test_extreme_values_are_drawn(screen: Screen) -> None:
    stray = LEARNER._replace(
        pose=Pose(1e9, float("nan"), 50.0), proximity=(-5, 2000), arm=0, jaw=999, confidence=(2.0,), name="x\0\n" * 200
    )
    title, unknown = "A title\nof many words " * 30, StateVector(1, -1, 9, 0, 10**6)
    views = (
        View((BLOCKS,)),
        View((BLOCKS,), (stray, LEARNER), title=title, limit=0, step=10**12, score=-20.0),
        View((CORRIDOR,), (LEARNER._replace(vector=unknown, state=State.UNKNOWN),)),
    )
    for view in views:
        assert draw(screen, view).size


def test_other_modes_and_no_arena_are_refused_and_no_mode_makes_no_view(screen: Screen) -> None:
    with pytest.raises(ValueError, match=r"'ansi'; allowed: None, 'human', 'rgb_array'"):
        Screen("ansi", 0.1)
    with pytest.raises(ValueError, match="at least one"):
        draw(screen, View(()))
    assert draw(screen, VIEW).size
    with pytest.warns(UserWarning, match="without a render_mode"):
        assert Screen(None, 0.1).show(lambda: pytest.fail("made a view")) is None


@pytest.mark.parametrize("robots", [1, 2, 3, 4, 5, 8])
@pytest.mark.parametrize("arena", [CORRIDOR, RECTANGLE], ids=lambda arena: arena.name)
def test_arena_and_panels_do_not_overlap(arena: Arena, robots: int) -> None:
    layout = arrange(copies(arena, robots), robots)
    assert layout.size[0] % 2 == layout.size[1] % 2 == 0
    if robots <= 5:
        assert layout.size[0] <= MAX_WIDTH + 2
        assert layout.size[1] <= MAX_HEIGHT + 210  # five rectangles are in two rows
    boxes = [shapely.box(a.left, a.top, a.left + a.width, a.top + a.height) for a in (layout.arena, *layout.panels)]
    assert len(boxes) == robots + 1
    assert all(shapely.box(0, 0, *layout.size).covers(box) for box in boxes)
    assert all(one.intersection(other).area == 0 for one, other in combinations(boxes, 2))
    for shown in copies(arena, robots):
        for x, y in shown.walls:
            column, row = layout.pixel(x, y)
            assert 0 <= column - layout.arena.left < layout.arena.width
            assert 0 <= row - layout.arena.top < layout.arena.height


# ---------------------------------------------------------------- films


@pytest.mark.parametrize("ending", CODECS)
def test_films_have_all_frames_and_their_colours(ending: str, tmp_path: Path) -> None:
    cv2 = pytest.importorskip("cv2")
    frames = [np.full((48, 64, 3), (200, 40 * k, 40 * k), np.uint8) for k in range(5)]  # red
    film = cv2.VideoCapture(str(save_film(frames, tmp_path / f"film{ending}", 10.0)))
    assert film.get(cv2.CAP_PROP_FPS) == pytest.approx(10.0)
    shown: list[NDArray[Any]] = []
    while (read := film.read())[0]:
        shown.append(cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB))
    assert len(shown) == len(frames)
    for one, other in zip(shown, frames, strict=True):
        assert np.abs(one.mean(axis=(0, 1)) - other.mean(axis=(0, 1))).max() < 12


def test_gif_has_the_frames(screen: Screen, tmp_path: Path) -> None:
    moved = [LEARNER._replace(pose=Pose(100.0 + 30 * i, 115.0, 0.0)) for i in range(4)]
    frames = [draw(screen, VIEW._replace(robots=(robot,), step=i)) for i, robot in enumerate(moved)]
    path = save_film(frames, tmp_path / "animation.gif", fps=5)
    assert list(tmp_path.iterdir()) == [path]
    with Image.open(path) as gif:
        assert gif.size == (frames[0].shape[1], frames[0].shape[0])
        assert getattr(gif, "n_frames") == 4  # noqa: B009  only animated pictures have it
        assert (gif.info["duration"], gif.info["loop"]) == (200, 0)
        for number, frame in enumerate(frames):
            gif.seek(number)
            error = np.abs(np.asarray(gif.convert("RGB")).astype(int) - frame)
            assert error.mean() < 0.5
            assert (error.max(axis=2) > 60).mean() < 0.001


FRAME = np.zeros((4, 4, 3), np.uint8)


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ([], "no frames"),
        ([np.zeros((4, 4, 3))], "float64"),
        ([np.zeros((4, 4), np.uint8)], r"\(4, 4\)"),
        ([np.zeros((4, 4, 4), np.uint8)], r"\(4, 4, 4\)"),
        ([np.zeros((0, 4, 3), np.uint8)], "not empty"),
        ([FRAME, np.zeros((4, 5, 3), np.uint8)], "one size"),
        ([None], "NoneType"),
    ],
)
def test_invalid_frames_endings_and_folders_are_named_and_the_old_file_is_kept(
    tmp_path: Path, frames: list[NDArray[np.uint8]], words: str
) -> None:
    (tmp_path / "animation.gif").write_text("old")
    with pytest.raises(ValueError, match=words):
        save_film(frames, tmp_path / "animation.gif", fps=10)
    with pytest.raises(ValueError, match="fps"):
        save_film([FRAME], tmp_path / "animation.gif", fps=0)
    with pytest.raises(ValueError, match=r"film is 'film.mov'; allowed: a name that ends in .gif, .mp4, .avi"):
        save_film([FRAME], "film.mov", 10.0)
    for name in ("nowhere/film.mp4", "not\udcffutf-8.avi"):
        with pytest.raises(OSError, match=f"{name}: OpenCV cannot write a film there; allowed: a name in UTF-8"):
            save_film([FRAME], tmp_path / name, 10.0)
    assert (tmp_path / "animation.gif").read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1
