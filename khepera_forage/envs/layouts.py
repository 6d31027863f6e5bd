"""What robots know of an arena, and layouts of episodes: drawn, or as `reset(options=...)` gives them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import takewhile
from typing import Any

from khepera_forage.counter_rng import random_bits
from khepera_forage.geometry.paths import ChosenWaypoint
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Arena, Point, Pose, copies
from khepera_forage.sim.layout_checks import check_apart, check_layout, check_robot, check_seen, is_seen
from khepera_forage.sim.waypoints import is_home_free, path_tables_of, pixel_walls, way_out
from khepera_forage.sim.world import Layout
from khepera_forage.task.arena_map import EVERY_SIDE, OUTSIDE, ArenaMap, Floor, whole_pixels
from khepera_forage.task.decisions import DecisionValues
from khepera_forage.task.food_tracking import FoodObject, FoodTracker, KnownFood, Link
from khepera_forage.task.placement import Place, Start, draw_layout, place_by_hand
from khepera_forage.vision.scene import MM_PER_PIXEL


@lru_cache(maxsize=1 << 14)
def arena_map_of(arena: Arena) -> ArenaMap:
    """What a robot knows of an arena from the beginning, in pixels."""
    x1, y1, x2, y2 = arena.bounds
    return ArenaMap(
        arena.home.x / MM_PER_PIXEL,
        arena.home.y / MM_PER_PIXEL,
        whole_pixels(arena.home_radius),
        arena.start.x / MM_PER_PIXEL,
        arena.start.y / MM_PER_PIXEL,
        _home_opening(arena),
        whole_pixels(arena.diagonal),
        x1 / MM_PER_PIXEL - OUTSIDE,
        y1 / MM_PER_PIXEL - OUTSIDE,
        x2 / MM_PER_PIXEL + OUTSIDE,
        y2 / MM_PER_PIXEL + OUTSIDE,
        pixel_walls(arena),
        path_tables_of(arena),
    )


def _home_opening(arena: Arena) -> float:
    if is_home_free(arena):
        return EVERY_SIDE
    out_x, out_y = way_out(arena)
    return math.degrees(math.atan2(out_y - arena.home.y, out_x - arena.home.x))


@lru_cache(maxsize=1 << 14)
def floor_of(arena: Arena) -> Floor:
    """The floor of an arena, in mm."""
    return Floor(*arena.bounds, arena.home.x, arena.home.y, arena.home_radius, arena.wall_records)


def no_room(name: str, foods: int) -> ValueError:
    """The error of an arena with this name in which no random layout was found."""
    return ValueError(f"{name}: no room for a robot and {foods} food objects outside home; make the arena larger")


def random_layout(
    arena: Arena, foods: int, key: int, decisions: DecisionValues, options: Mapping[str, Any] | None = None
) -> Layout:
    """A random start and random food places (5.4.1.1), but for what `reset(options=...)` gives.

    Args:
        arena: Where.
        foods: Number of food objects.
        key: From `task.placement.layout_key`.
        decisions: Of the task.
        options: `start`: (x mm, y mm, heading degrees); `foods`: one (x mm, y mm) an object.

    Raises:
        ValueError: The arena has no room, an unknown option, a wrong number of values, or a place that is not on the
            free floor.
    """
    given_start, given = given_places(arena, foods, checked_options(options))
    start = Start() if given_start is None else Start(*given_start)
    places = [Place() for _ in range(foods)] if given is None else [Place(*place) for place in given]
    has_start, has_places = given_start is not None, given is not None
    if not draw_layout(start, places, key, floor_of(arena), arena_map_of(arena), decisions, has_start, has_places):
        raise no_room(arena.name, foods)
    return _layout_of(start, places)


def checked_options(options: Any) -> dict[str, Any]:
    """The options of a reset; none for None.

    Raises:
        ValueError: No mapping.
    """
    if options is not None and not isinstance(options, Mapping):
        raise ValueError(f"options is {options!r}; allowed: a mapping of 'start' and 'foods', or None")
    return dict(options or {})


def given_places(arena: Arena, foods: int, options: Mapping[str, Any]) -> tuple[Pose | None, tuple[Point, ...] | None]:
    """Start and food places that `reset(options=...)` gives; None for what it leaves open.

    Raises:
        ValueError: As `random_layout`.
    """
    _check_names(options)
    start, places = None, None
    if "start" in options:
        start = _start_of(options)
        arena.check_free("start", start, RADIUS)
        check_robot(arena, start)
    if "foods" in options:
        places = _foods_of(options, foods)
        for place in places:
            arena.check_free("food", place, FOOD_RADIUS)
    check_apart(Layout(() if start is None else (start,), places or ()))
    return start, places


def paired_copies(arena: Arena, robots: int) -> tuple[Arena, ...]:
    """An arena and its copies, one for each robot of a training.

    Raises:
        ValueError: The camera does not see all of them.
    """
    check_seen([arena])
    arenas = copies(arena, robots)
    seen = len(list(takewhile(is_seen, arenas)))
    if seen < robots:
        raise ValueError(
            f"num_learners is {robots - 1}; allowed: at most {seen - 1}, because the camera sees no more than {seen} "
            f"copies of the arena {arena.name!r}"
        )
    return arenas


def arenas_with_marks(arenas: Sequence[Arena], options: Mapping[str, Any]) -> Sequence[Arena]:
    """The arenas with the marks of training where `reset(options=...)` asks for them.

    Args:
        arenas: One a robot, each a copy of the first at an offset.
        options: `start`: (x mm, y mm, heading degrees) in the first arena; `foods`: one (x mm, y mm) an object,
            as many as there are marks for. The same places, moved along, are marked in the other arenas.

    Raises:
        ValueError: As `random_layout`.
    """
    # PettingZoo's api_test resets with {"options": 1}, which must do nothing.
    options = {name: value for name, value in options.items() if name != "options"}
    _check_names(options)
    if not options:
        return arenas
    first = arenas[0]
    start = _start_of(options) if "start" in options else first.start
    foods = _foods_of(options, len(first.foods)) if "foods" in options else first.foods
    moved = []
    for arena in arenas:
        dx, dy = arena.home.x - first.home.x, arena.home.y - first.home.y
        moved.append(
            replace(
                arena,
                start=Pose(start.x + dx, start.y + dy, start.heading),
                foods=tuple(Point(food.x + dx, food.y + dy) for food in foods),
            )
        )
    return moved


def training_layout(arenas: Sequence[Arena], noise: Noise, key: int) -> Layout:
    """Every robot and food object on its mark (figure 5.1), as well as an operator can put it there (4.5.2).

    Args:
        arenas: One a robot.
        noise: Its placement errors.
        key: From `task.placement.layout_key`; each arena has numbers of its own.

    Raises:
        ValueError: Nothing stands free, however often it is put down again.
    """
    starts: tuple[Pose, ...] = ()
    foods: tuple[Point, ...] = ()
    for side, arena in enumerate(arenas):
        start, places = Start(), [Place() for _ in arena.foods]
        heading_error = math.radians(noise.placement_heading_error)
        if not place_by_hand(
            start,
            places,
            random_bits(key, side),
            arena.start,
            arena.foods,
            noise.placement_error,
            heading_error,
            floor_of(arena),
        ):
            raise no_room_on_marks(arena, noise)
        layout = _layout_of(start, places)
        starts, foods = starts + layout.starts, foods + layout.foods
    return Layout(starts, foods)


def no_room_on_marks(arena: Arena, noise: Noise) -> ValueError:
    """The error of training marks on which nothing stands free."""
    message = (
        f"{arena.name}: start or food too near a wall or each other for a placement error of "
        f"{noise.placement_error:g} mm; move the marks, or make the error smaller"
    )
    try:
        check_layout((arena,), Layout((arena.start,), arena.foods))
    except ValueError as wrong:
        message += f" (exactly on the marks: {wrong})"
    return ValueError(message)


def known_food(places: Sequence[Point]) -> KnownFood:
    """What is known of food at the start of an episode, from where it lies, in mm."""
    return KnownFood(
        FoodTracker(deliverable=len(places)),
        [FoodObject(place.x / MM_PER_PIXEL, place.y / MM_PER_PIXEL) for place in places],
        [Link() for _ in range(2 * len(places))],
        [ChosenWaypoint() for _ in range(1 + len(places))],
    )


def _layout_of(start: Start, places: Sequence[Place]) -> Layout:
    return Layout((Pose(start.x, start.y, start.heading),), tuple(Point(place.x, place.y) for place in places))


def _check_names(options: Mapping[str, Any]) -> None:
    unknown = set(options) - {"start", "foods"}
    if unknown:
        raise ValueError(f"reset option {sorted(unknown)[0]!r} is unknown; allowed: 'start', 'foods'")


def _start_of(options: Mapping[str, Any]) -> Pose:
    x, y, degrees = _numbers("start", options["start"], 3, "(x mm, y mm, heading degrees)")
    return Pose(x, y, math.radians(degrees))


def _foods_of(options: Mapping[str, Any], count: int) -> tuple[Point, ...]:
    given = options["foods"] if isinstance(options["foods"], Iterable) else [options["foods"]]
    places = tuple(Point(*_numbers("foods", food, 2, "(x mm, y mm)")) for food in given)
    if len(places) != count:
        raise ValueError(f"{len(places)} foods given; allowed: {count}, the number of this environment")
    return places


def _numbers(name: str, values: Any, count: int, form: str) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, values))
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != count or not all(math.isfinite(n) for n in numbers):
        raise ValueError(f"reset option {name!r} has {values!r}; allowed: {form}, finite")
    return numbers
