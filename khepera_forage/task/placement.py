"""Where robot and food stand at the start of an episode (5.4.1.1: "random in every recall episode")."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, RADIUS, half_gap
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.layout_checks import check_layout
from khepera_forage.sim.world import Layout
from khepera_forage.task.states import CLOSE_TO_FOOD
from khepera_forage.vision.scene import MM_PER_PIXEL

FOOD_CLEARANCE = 50.0
"""mm from a food's centre to the walls, so that the gripper fits around it from any side it is approached."""
FOOD_SPACING = 100.0
"""mm between the centres of two food objects, for the same reason."""
_MARGIN = 5.0
_TRIES = 200


def random_layout(arena: Arena, foods: int, rng: np.random.Generator) -> Layout:
    """A random start and random food places.

    The robot starts anywhere outside home, heading uniform; food lies outside home, further from the robot than
    the close threshold, where a gripper fits around it.

    Args:
        arena: Where.
        foods: Number of food objects.
        rng: The placements' own generator.

    Raises:
        ValueError: The arena has no room.
    """
    x1, y1, x2, y2 = arena.bounds
    width, height = x2 - x1, y2 - y1
    for _ in range(_TRIES):
        u, v, w = rng.random(3).tolist()
        start = Pose(x1 + width * u, y1 + height * v, -math.pi + 2.0 * math.pi * w)
        if min(start.x - x1, x2 - start.x, start.y - y1, y2 - start.y) < RADIUS or not (
            _outside_home(arena, start, RADIUS) and _stands_free(arena, start)
        ):
            continue
        places: list[Point] = []
        for _ in range(50 * foods):
            u, v = rng.random(2).tolist()
            place = Point(x1 + width * u, y1 + height * v)
            if (
                # What is too near the outer bounds needs no look at the walls.
                x1 + FOOD_CLEARANCE <= place.x <= x2 - FOOD_CLEARANCE
                and y1 + FOOD_CLEARANCE <= place.y <= y2 - FOOD_CLEARANCE
                and arena.clearance(place) >= FOOD_CLEARANCE
                and _outside_home(arena, place, FOOD_RADIUS)
                and math.dist(place, start[:2]) > CLOSE_TO_FOOD * MM_PER_PIXEL + _MARGIN
                and all(math.dist(place, other) >= FOOD_SPACING for other in places)
            ):
                places.append(place)
                if len(places) == foods:
                    return Layout((start,), tuple(places))
    raise ValueError(
        f"{arena.name}: no room for a robot and {foods} food objects outside home; make the arena larger"
    )


def given_layout(arena: Arena, foods: int, options: Mapping[str, Any], rng: np.random.Generator) -> Layout:
    """The layout that `reset(options=...)` asks for; what it leaves open is random.

    Args:
        arena: Where.
        foods: Number of food objects of the environment.
        options: `start`: (x mm, y mm, heading degrees); `foods`: one (x mm, y mm) an object.
        rng: The placements' own generator.

    Raises:
        ValueError: An unknown option, a wrong number of values, a place that is not on the free floor.
    """
    _check_names(options)
    drawn = random_layout(arena, foods, rng) if len(options) < 2 else None
    if "start" in options:
        start = _start_of(options)
        arena.check_free("start", start, RADIUS)
    else:
        assert drawn is not None
        start = drawn.starts[0]
    if "foods" in options:
        places = _foods_of(options, foods)
        for place in places:
            arena.check_free("food", place, FOOD_RADIUS)
    else:
        assert drawn is not None
        places = drawn.foods
    return Layout((start,), places)


def marked(arenas: Sequence[Arena], options: Mapping[str, Any]) -> Sequence[Arena]:
    """The arenas with the marks of training where `reset(options=...)` asks for them; others stay.

    Args:
        arenas: One a robot, each a copy of the first at an offset.
        options: `start`: (x mm, y mm, heading degrees) in the first arena; `foods`: one (x mm, y mm) an object,
            as many as there are marks for. The same places, moved along, are marked in the other arenas.

    Raises:
        ValueError: As `given_layout`.
    """
    # PettingZoo's api_test resets with {"options": 1}, which must do nothing; any other name is a slip of the pen.
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


def training_layout(arenas: Sequence[Arena], noise: Noise, rng: np.random.Generator) -> Layout:
    """Every robot and food object on its mark (figure 5.1), as well as an operator can put it there.

    What would stand in a wall, or in something else, is put down again.

    Args:
        arenas: One a robot.
        noise: Its placement errors.
        rng: The placements' own generator.

    Raises:
        ValueError: Nothing stands free, however often it is put down again.
    """
    starts: list[Pose] = []
    foods: list[Point] = []
    for arena in arenas:
        wrong = ""
        for _ in range(_TRIES):
            dx, dy, turn = rng.standard_normal(3).tolist()
            turn = arena.start.heading + math.radians(noise.placement_heading_error * turn)
            error = noise.placement_error
            start = Pose(arena.start.x + error * dx, arena.start.y + error * dy, turn)
            moved = rng.standard_normal((len(arena.foods), 2)).tolist()
            places = [
                Point(f.x + error * ex, f.y + error * ey)
                for f, (ex, ey) in zip(arena.foods, moved, strict=True)
            ]
            try:
                check_layout((arena,), Layout((start,), tuple(places)))
            except ValueError as refused:
                wrong = str(refused)
            else:
                break
        else:
            raise ValueError(
                f"{arena.name}: start or food too near a wall for a placement error of {error:g} mm; the last of "
                f"{_TRIES} draws: {wrong}"
            )
        starts.append(start)
        foods += places
    return Layout(tuple(starts), tuple(foods))


def _outside_home(arena: Arena, place: Point | Pose, radius: float) -> bool:
    return math.dist(place[:2], arena.home) > arena.home_radius + radius


def _stands_free(arena: Arena, start: Pose) -> bool:
    """Whether body and gripper touch no wall."""
    clearance = arena.clearance(start)
    if clearance < RADIUS + _MARGIN:
        return False
    wide = half_gap(200) + _MARGIN
    if clearance > math.hypot(FINGER_TIP, wide) + _MARGIN:
        return True
    cosine, sine = math.cos(start.heading), math.sin(start.heading)
    return all(
        arena.clearance(Point(start.x + x * cosine - y * sine, start.y + x * sine + y * cosine)) >= _MARGIN
        for x in (FINGER_TIP / 2, FINGER_TIP)
        for y in (-wide, wide)
    )


def _check_names(options: Mapping[str, Any]) -> None:
    unknown = set(options) - {"start", "foods"}
    if unknown:
        raise ValueError(f"reset option {sorted(unknown)[0]!r} is unknown; allowed: 'start', 'foods'")


def _start_of(options: Mapping[str, Any]) -> Pose:
    x, y, degrees = _numbers("start", options["start"], 3, "(x mm, y mm, heading degrees)")
    return Pose(x, y, math.radians(degrees))


def _foods_of(options: Mapping[str, Any], count: int) -> tuple[Point, ...]:
    places = tuple(Point(*_numbers("foods", food, 2, "(x mm, y mm)")) for food in options["foods"])
    if len(places) != count:
        raise ValueError(f"{len(places)} foods given; allowed: {count}, the number of this environment")
    return places


def _numbers(name: str, values: Sequence[float], count: int, form: str) -> tuple[float, ...]:
    numbers = tuple(float(v) for v in values)
    if len(numbers) != count or not all(math.isfinite(n) for n in numbers):
        raise ValueError(f"reset option {name!r} has {values!r}; allowed: {form}, finite")
    return numbers
