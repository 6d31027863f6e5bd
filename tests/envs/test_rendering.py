"""Pictures of the environments: arrays, colours, and that every value of a view is visible."""

import copy
import pickle
from collections.abc import Iterator

import numpy as np
import pygame
import pytest
from numpy.typing import NDArray

from khepera_forage.envs.rendering import FoodView, Renderer, RobotView, View
from khepera_forage.envs.rendering.palette import FLOOR, FOOD, Colour
from khepera_forage.envs.rendering.picture import Layout, arrange
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector
from khepera_forage.vision.scene import MM_PER_PIXEL, Region
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


def draw(renderer: Renderer, view: View) -> NDArray[np.uint8]:
    frame = renderer.draw(view)
    assert frame is not None
    return frame


def patch(layout: Layout, frame: NDArray[np.uint8], x: float, y: float, reach: float) -> NDArray[np.uint8]:
    """The square of pixels around a position in mm."""
    (left, top), (right, bottom) = layout.pixel(x - reach, y + reach), layout.pixel(x + reach, y - reach)
    return frame[top : bottom + 1, left : right + 1]


def is_colour(pixel: NDArray[np.uint8], colour: Colour) -> bool:
    """Whether the colours are equal except for rounding."""
    return bool(np.all(np.abs(pixel.astype(int) - colour) <= 3))


def test_draw_returns_a_new_array(renderer: Renderer) -> None:
    first = draw(renderer, VIEW)
    assert first.dtype == np.uint8
    assert first.ndim == 3
    assert first.shape[2] == 3
    assert first.flags.writeable
    kept = first.copy()
    second = draw(renderer, VIEW)
    assert not np.shares_memory(first, second)
    second[:] = 0
    np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(draw(renderer, VIEW), kept)


def test_equal_views_give_equal_pictures_in_any_order(renderer: Renderer) -> None:
    busy = VIEW._replace(
        arenas=(RECTANGLE,),
        robots=(LEARNER._replace(separated=True, tracked=False, note="lost", arm=255, jaw=0),),
        regions=(region(100, 100, 2), region(300, 300, 1, found=False), region(370, 200, 0, found=False)),
        foods=tuple(FoodView(100.0 * kind + 100, 400.0, kind, kind > 1, kind > 2) for kind in FoodType),
    )
    other = Renderer("rgb_array")
    draw(renderer, VIEW)
    np.testing.assert_array_equal(draw(renderer, busy), draw(other, busy))
    np.testing.assert_array_equal(draw(renderer, VIEW), draw(other, VIEW))
    other.close()


def test_moving_a_robot_changes_only_its_surroundings(renderer: Renderer) -> None:
    layout = arrange(VIEW.arenas, 1)
    before = draw(renderer, VIEW)
    after = draw(renderer, VIEW._replace(robots=(LEARNER._replace(pose=Pose(150.0, 60.0, 0.3)),)))
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
def test_every_attribute_of_a_robot_is_visible(renderer: Renderer, change: dict[str, object]) -> None:
    plain = draw(renderer, VIEW)
    changed = draw(renderer, VIEW._replace(robots=(LEARNER._replace(**change),)))  # type: ignore[arg-type]
    assert changed.shape == plain.shape
    assert not np.array_equal(changed, plain)


@pytest.mark.parametrize(
    "change", [{"step": 4}, {"limit": None}, {"score": 90.0}, {"delivered": 1}, {"title": "Hall"}]
)
def test_every_figure_of_a_view_is_visible(renderer: Renderer, change: dict[str, object]) -> None:
    plain = draw(renderer, VIEW)
    changed = draw(renderer, VIEW._replace(**change))  # type: ignore[arg-type]
    assert changed.shape == plain.shape
    assert not np.array_equal(changed, plain)


@pytest.mark.parametrize("kind", list(FoodType))
def test_food_is_drawn_in_the_colour_of_its_type(renderer: Renderer, kind: FoodType) -> None:
    layout = arrange((CORRIDOR,), 1)
    frame = draw(renderer, VIEW._replace(foods=(FoodView(250.0, 180.0, kind),)))
    column, row = layout.pixel(250.0 - 12.0, 180.0)  # beside the symbol in its middle
    assert is_colour(frame[row, column], FOOD[kind])
    column, row = layout.pixel(250.0 - 40.0, 180.0)
    assert is_colour(frame[row, column], FLOOR)


def test_food_types_differ_by_more_than_colour(renderer: Renderer) -> None:
    layout = arrange((CORRIDOR,), 1)
    symbols = []
    for kind in FoodType:
        frame = draw(renderer, VIEW._replace(foods=(FoodView(250.0, 180.0, kind),)))
        around = patch(layout, frame, 250.0, 180.0, 9.0).astype(int)
        symbols.append(np.abs(around - 255).max(axis=2) < 60)
    assert all(not np.array_equal(a, b) for i, a in enumerate(symbols) for b in symbols[:i])


@pytest.mark.parametrize("change", [{"lifted": True}, {"delivered": True}])
def test_lifted_or_delivered_food_looks_different(renderer: Renderer, change: dict[str, bool]) -> None:
    food = FoodView(250.0, 180.0, FoodType.PICKABLE)
    layout = arrange((CORRIDOR,), 1)
    plain, changed = (
        patch(layout, draw(renderer, VIEW._replace(foods=(f,))), 250.0, 180.0, 30.0)
        for f in (food, food._replace(**change))  # type: ignore[arg-type]
    )
    assert not np.array_equal(plain, changed)


@pytest.mark.parametrize("holes", [0, 1, 2])
def test_lost_regions_are_drawn_in_red(renderer: Renderer, holes: int) -> None:
    layout = arrange((CORRIDOR,), 1)

    def max_redness(regions: tuple[Region, ...]) -> int:
        around = patch(layout, draw(renderer, VIEW._replace(regions=regions)), 280.0, 115.0, 70.0).astype(int)
        return int((around[..., 0] - np.maximum(around[..., 1], around[..., 2])).max())

    assert max_redness((region(280.0, 115.0, holes, found=False),)) > 60
    assert max_redness((region(280.0, 115.0, holes),)) < 20


def test_extreme_values_are_drawn(renderer: Renderer) -> None:
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
        assert draw(renderer, view).size


def test_invalid_arguments_are_refused(renderer: Renderer) -> None:
    with pytest.raises(ValueError, match=r"'ansi'.*rgb_array"):
        Renderer("ansi")
    for fps in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="fps"):
            Renderer("rgb_array", fps)
    with pytest.raises(ValueError, match="at least one"):
        renderer.draw(View(()))
    assert draw(renderer, VIEW).size


def test_renderer_draws_again_after_close(renderer: Renderer) -> None:
    before = draw(renderer, VIEW)
    renderer.close()
    renderer.close()
    np.testing.assert_array_equal(draw(renderer, VIEW), before)


def test_pictures_are_drawn_after_another_program_quit_pygame(renderer: Renderer) -> None:
    before, other = draw(renderer, VIEW), VIEW._replace(title="Another title")
    pygame.quit()  # as Gymnasium's own environments do when they are closed
    np.testing.assert_array_equal(draw(renderer, VIEW), before)
    assert not np.array_equal(draw(renderer, other), before)


def test_copied_renderer_draws_the_same(renderer: Renderer) -> None:
    before = draw(renderer, VIEW)
    for copied in (copy.deepcopy(renderer), pickle.loads(pickle.dumps(renderer))):
        assert (copied.mode, copied.fps) == (renderer.mode, renderer.fps)
        np.testing.assert_array_equal(draw(copied, VIEW), before)
        copied.close()
