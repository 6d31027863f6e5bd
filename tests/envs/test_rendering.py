"""The renderer: what it promises about arrays, displays, colours, windows and films."""

import copy
import pickle
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from khepera_forage.envs.rendering import FoodView, Renderer, RobotView, View, save_gif
from khepera_forage.envs.rendering.layout import MAX_HEIGHT, MAX_WIDTH, Layout, arrange
from khepera_forage.envs.rendering.palette import FLOOR, FOOD, Colour
from khepera_forage.sim.arena import CORRIDOR, RECTANGLE, Arena, Point, Pose, copies
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector
from khepera_forage.vision.scene import MM_PER_PIXEL, Region

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
VIEW = View(
    (CORRIDOR,), (LEARNER,), (FoodView(370.0, 115.0),), step=3, limit=500, score=100.0, title="Corridor"
)


def region(x: float, y: float, holes: int, found: bool = True) -> Region:
    return Region(0, x / MM_PER_PIXEL, y / MM_PER_PIXEL, holes, 20, found, False, 0, 0, 0, 0, 0)


@pytest.fixture
def renderer() -> Iterator[Renderer]:
    renderer = Renderer("rgb_array")
    yield renderer
    renderer.close()


def picture(renderer: Renderer, view: View) -> NDArray[np.uint8]:
    frame = renderer.draw(view)
    assert frame is not None
    return frame


def patch(layout: Layout, frame: NDArray[np.uint8], x: float, y: float, reach: float) -> NDArray[np.uint8]:
    """The square of pixels about a place in mm."""
    (left, top), (right, bottom) = layout.pixel(x - reach, y + reach), layout.pixel(x + reach, y - reach)
    return frame[top : bottom + 1, left : right + 1]


def is_colour(pixel: NDArray[np.uint8], colour: Colour) -> bool:
    """Equal but for what shrinking rounds off."""
    return bool(np.all(np.abs(pixel.astype(int) - colour) <= 3))


def in_python(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run code in a fresh interpreter with warnings as errors and no display settings but those given."""
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
    )


def test_frame_is_a_fresh_array(renderer: Renderer) -> None:
    first = picture(renderer, VIEW)
    assert first.dtype == np.uint8
    assert first.ndim == 3
    assert first.shape[2] == 3
    assert first.flags.writeable
    kept = first.copy()
    second = picture(renderer, VIEW)
    assert not np.shares_memory(first, second)
    second[:] = 0
    np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(picture(renderer, VIEW), kept)


def test_equal_views_give_equal_pictures_whatever_was_drawn_before(renderer: Renderer) -> None:
    busy = VIEW._replace(
        arenas=(RECTANGLE,),
        robots=(LEARNER._replace(separated=True, tracked=False, note="lost", arm=255, jaw=0),),
        regions=(region(100, 100, 2), region(300, 300, 1, found=False), region(370, 200, 0, found=False)),
        foods=tuple(FoodView(100.0 * kind + 100, 400.0, kind, kind > 1, kind > 2) for kind in FoodType),
    )
    other = Renderer("rgb_array")
    picture(renderer, VIEW)
    np.testing.assert_array_equal(picture(renderer, busy), picture(other, busy))
    np.testing.assert_array_equal(picture(renderer, VIEW), picture(other, VIEW))
    other.close()


def test_a_robot_that_moves_is_drawn_elsewhere_and_nothing_else_changes(renderer: Renderer) -> None:
    layout = arrange(VIEW.arenas, 1)
    before = picture(renderer, VIEW)
    after = picture(renderer, VIEW._replace(robots=(LEARNER._replace(pose=Pose(150.0, 60.0, 0.3)),)))
    rows, columns = np.nonzero((before != after).any(axis=2))
    assert len(rows) > 500
    left, top = layout.pixel(150.0 - 110.0, 115.0 + 110.0)
    right, bottom = layout.pixel(150.0 + 110.0, 60.0 - 110.0)
    assert left <= columns.min() <= columns.max() <= right
    assert top <= rows.min() <= rows.max() <= bottom


@pytest.mark.parametrize(
    "change",
    [
        {"arm": 255},
        {"jaw": 0},
        {"holes": 1},
        {"proximity": (0,) * 8},
        {"name": "learner 7"},
        {"vector": StateVector(1, 80, 0, 215, 44)},
        {"vector": None},
        {"state": State.AT_HOME_NO_FOOD},
        {"heard": Behaviour.GO_HOME},
        {"heard": Behaviour.WAIT},
        {"executed": Behaviour.WAIT},
        {"executed": None},
        {"confidence": None},
        {"separated": True},
        {"tracked": False},
        {"note": "five episodes"},
    ],
    ids=lambda change: "-".join(change),
)
def test_every_attribute_of_a_robot_shows(renderer: Renderer, change: dict[str, object]) -> None:
    plain = picture(renderer, VIEW)
    changed = picture(renderer, VIEW._replace(robots=(LEARNER._replace(**change),)))  # type: ignore[arg-type]
    assert changed.shape == plain.shape
    assert not np.array_equal(changed, plain)


@pytest.mark.parametrize(
    "change", [{"step": 4}, {"limit": None}, {"score": 90.0}, {"delivered": 1}, {"title": "Hall"}]
)
def test_every_figure_of_a_view_shows(renderer: Renderer, change: dict[str, object]) -> None:
    plain = picture(renderer, VIEW)
    changed = picture(renderer, VIEW._replace(**change))  # type: ignore[arg-type]
    assert changed.shape == plain.shape
    assert not np.array_equal(changed, plain)


@pytest.mark.parametrize("kind", list(FoodType))
def test_food_has_the_colour_of_its_type_where_it_lies(renderer: Renderer, kind: FoodType) -> None:
    layout = arrange((CORRIDOR,), 1)
    frame = picture(renderer, VIEW._replace(foods=(FoodView(250.0, 180.0, kind),)))
    column, row = layout.pixel(250.0 - 12.0, 180.0)  # clear of the sign in its middle
    assert is_colour(frame[row, column], FOOD[kind])
    column, row = layout.pixel(250.0 - 40.0, 180.0)
    assert is_colour(frame[row, column], FLOOR)


def test_food_types_differ_by_more_than_colour(renderer: Renderer) -> None:
    layout = arrange((CORRIDOR,), 1)
    signs = []
    for kind in FoodType:
        frame = picture(renderer, VIEW._replace(foods=(FoodView(250.0, 180.0, kind),)))
        around = patch(layout, frame, 250.0, 180.0, 9.0).astype(int)
        signs.append(np.abs(around - 255).max(axis=2) < 60)
    assert all(not np.array_equal(a, b) for i, a in enumerate(signs) for b in signs[:i])


@pytest.mark.parametrize("change", [{"lifted": True}, {"delivered": True}])
def test_food_lifted_or_delivered_looks_different(renderer: Renderer, change: dict[str, bool]) -> None:
    food = FoodView(250.0, 180.0, FoodType.PICKABLE)
    layout = arrange((CORRIDOR,), 1)
    plain, changed = (
        patch(layout, picture(renderer, VIEW._replace(foods=(f,))), 250.0, 180.0, 30.0)
        for f in (food, food._replace(**change))  # type: ignore[arg-type]
    )
    assert not np.array_equal(plain, changed)


@pytest.mark.parametrize("holes", [0, 1, 2])
def test_lost_regions_are_drawn_in_red(renderer: Renderer, holes: int) -> None:
    layout = arrange((CORRIDOR,), 1)

    def reddest(regions: tuple[Region, ...]) -> int:
        around = patch(layout, picture(renderer, VIEW._replace(regions=regions)), 280.0, 115.0, 70.0).astype(
            int
        )
        return int((around[..., 0] - np.maximum(around[..., 1], around[..., 2])).max())

    assert reddest((region(280.0, 115.0, holes, found=False),)) > 60
    assert reddest((region(280.0, 115.0, holes),)) < 20


@pytest.mark.parametrize("robots", [1, 2, 3, 4, 5, 8])
@pytest.mark.parametrize("arena", [CORRIDOR, RECTANGLE], ids=lambda arena: arena.name)
def test_nothing_overlaps(arena: Arena, robots: int) -> None:
    layout = arrange(copies(arena, robots), robots)
    assert layout.size[0] % 2 == layout.size[1] % 2 == 0
    if robots <= 5:
        assert layout.size[0] <= MAX_WIDTH + 2
        assert layout.size[1] <= MAX_HEIGHT + 210  # five rectangles stand in two rows
    boxes = [layout.arena, *layout.panels]
    assert len(boxes) == robots + 1
    for i, a in enumerate(boxes):
        assert a.left >= 0
        assert a.top >= 0
        assert a.left + a.width <= layout.size[0]
        assert a.top + a.height <= layout.size[1]
        for b in boxes[:i]:
            beside = a.left >= b.left + b.width or b.left >= a.left + a.width
            assert beside or a.top >= b.top + b.height or b.top >= a.top + a.height
    for shown in copies(arena, robots):
        for x, y in shown.walls:
            column, row = layout.pixel(x, y)
            assert 0 <= column - layout.arena.left < layout.arena.width
            assert 0 <= row - layout.arena.top < layout.arena.height


def test_odd_views_are_drawn(renderer: Renderer) -> None:
    hall = Arena(
        name="hall",
        walls=(Point(-900, -500), Point(700, -500), Point(700, 500), Point(0, 800), Point(-900, 500)),
        home=Point(300, 0),
        home_radius=120,
        start=Pose(-500, 0, 1),
        foods=(Point(0, 0),),
        obstacles=((Point(-300, -300), Point(-200, -300), Point(-250, -200)),),
    )
    stray = LEARNER._replace(
        pose=Pose(1e9, float("nan"), 50.0),
        proximity=(-5, 2000),
        arm=0,
        jaw=999,
        confidence=(2.0,),
        name="x" * 200,
        note="\0\n" * 9,
    )
    views = (
        View((hall,)),
        View(
            (hall,), (stray, LEARNER), title="A title\nof many words " * 30, limit=0, step=10**12, score=-20.0
        ),
        View((CORRIDOR,), (LEARNER._replace(vector=StateVector(1, -1, 9, 0, 10**6), state=State.UNKNOWN),)),
    )
    for view in views:
        assert picture(renderer, view).size


def test_bad_arguments_are_named(renderer: Renderer) -> None:
    with pytest.raises(ValueError, match=r"'ansi'.*rgb_array"):
        Renderer("ansi")
    for fps in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="fps"):
            Renderer("rgb_array", fps)
    with pytest.raises(ValueError, match="at least one"):
        renderer.draw(View(()))
    assert picture(renderer, VIEW).size


def test_close_twice_then_draw_again(renderer: Renderer) -> None:
    before = picture(renderer, VIEW)
    renderer.close()
    renderer.close()
    np.testing.assert_array_equal(picture(renderer, VIEW), before)


def test_a_copy_draws_the_same(renderer: Renderer) -> None:
    before = picture(renderer, VIEW)
    for twin in (copy.deepcopy(renderer), pickle.loads(pickle.dumps(renderer))):
        assert (twin.mode, twin.fps) == (renderer.mode, renderer.fps)
        np.testing.assert_array_equal(picture(twin, VIEW), before)
        twin.close()


DRAW = """
import sys
from khepera_forage.envs.rendering import Renderer, View
from khepera_forage.sim.arena import CORRIDOR, RECTANGLE
"""


@pytest.mark.parametrize("environment", [{}, {"SDL_VIDEODRIVER": "no such driver"}], ids=["unset", "invalid"])
def test_arrays_touch_no_display(environment: dict[str, str]) -> None:
    done = in_python(
        DRAW
        + """
assert Renderer("rgb_array").draw(View((CORRIDOR,))).any()
import pygame
assert pygame.display.get_init() is False
""",
        **environment,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_window_opens_draws_closes_twice_and_can_be_dismissed() -> None:
    done = in_python(
        DRAW
        + """
import pygame
renderer = Renderer("human", fps=1000)
assert not pygame.display.get_init()
for _ in range(2):
    assert renderer.draw(View((CORRIDOR,), title="one")) is None
    small = pygame.display.get_surface().get_size()
    assert renderer.draw(View((RECTANGLE,), title="two")) is None
    assert pygame.display.get_surface().get_size() != small
    assert pygame.display.get_caption()[0] == "two"
    assert pygame.surfarray.array3d(pygame.display.get_surface()).std() > 5
    renderer.close()
    renderer.close()
    assert not pygame.display.get_init()
renderer.draw(View((CORRIDOR,)))
pygame.event.post(pygame.event.Event(pygame.QUIT))
assert not renderer.closed_by_user
renderer.draw(View((CORRIDOR,)))
assert renderer.closed_by_user and not pygame.display.get_init()
renderer.draw(View((CORRIDOR,)))
assert not pygame.display.get_init()
renderer.close()
renderer.draw(View((CORRIDOR,)))
assert not renderer.closed_by_user and pygame.display.get_init()
renderer.close()
""",
        SDL_VIDEODRIVER="dummy",
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_window_keeps_the_pace() -> None:
    done = in_python(
        DRAW
        + """
import time
renderer = Renderer("human", fps=20)
renderer.draw(View((CORRIDOR,)))
start = time.perf_counter()
for step in range(6):
    renderer.draw(View((CORRIDOR,), step=step))
assert time.perf_counter() - start > 0.25
renderer.close()
""",
        SDL_VIDEODRIVER="dummy",
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_pygame_and_pillow_are_imported_only_when_needed() -> None:
    done = in_python(
        """
import sys
sys.modules["pygame"] = sys.modules["PIL"] = None
import numpy as np
from gymnasium.error import DependencyNotInstalled
from khepera_forage.envs.rendering import Renderer, save_gif
frame = np.zeros((2, 2, 3), np.uint8)
for missing in (lambda: Renderer("rgb_array"), lambda: save_gif([frame], "never.gif")):
    try:
        missing()
    except DependencyNotInstalled as error:
        assert "pip install khepera-forage[render]" in str(error), error
    else:
        raise AssertionError("no error")
"""
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_film_reads_back(renderer: Renderer, tmp_path: Path) -> None:
    frames = [
        picture(
            renderer, VIEW._replace(step=i, robots=(LEARNER._replace(pose=Pose(100.0 + 30 * i, 115.0, 0.0)),))
        )
        for i in range(4)
    ]
    path = save_gif(frames, tmp_path / "film.gif", fps=5)
    assert list(tmp_path.iterdir()) == [path]
    with Image.open(path) as film:
        assert film.size == (frames[0].shape[1], frames[0].shape[0])
        assert getattr(film, "n_frames") == 4  # noqa: B009  only animated pictures have it
        assert film.info["duration"] == 200
        assert film.info["loop"] == 0
        for number, frame in enumerate(frames):
            film.seek(number)
            error = np.abs(np.asarray(film.convert("RGB")).astype(int) - frame)
            assert error.mean() < 0.5
            assert (error.max(axis=2) > 60).mean() < 0.001


def test_a_film_of_one_frame_or_a_noncontiguous_one(tmp_path: Path) -> None:
    frame = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    save_gif([frame[::-1]], str(tmp_path / "still.gif"), fps=1000)
    with Image.open(tmp_path / "still.gif") as film:
        assert film.size == (5, 4)


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
def test_what_is_not_a_film_is_refused_and_the_old_file_stays(
    tmp_path: Path, frames: list[NDArray[np.uint8]], words: str
) -> None:
    (tmp_path / "film.gif").write_text("old")
    with pytest.raises(ValueError, match=words):
        save_gif(frames, tmp_path / "film.gif", fps=10)
    with pytest.raises(ValueError, match="fps"):
        save_gif([np.zeros((4, 4, 3), np.uint8)], tmp_path / "film.gif", fps=0)
    assert (tmp_path / "film.gif").read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1
