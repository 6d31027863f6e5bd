"""A family of random arenas: convex or not, with or without obstacles, one to five food objects."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.layouts import random_layout
from khepera_forage.geometry import polygon
from khepera_forage.geometry.walls import Wall, clearance, walls_of
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import layout_key

HOME_RADIUS = 100.0
"""As in the thesis's arenas, mm."""
MOST_FOODS, MOST_OBSTACLES = 5, 3
WIDTH = 230.0
"""Width of the arms of L, T and U at least, that of the thesis's corridor, mm."""
PASSAGE = 180.0
"""Between obstacles and walls at least, mm: a robot with food between its fingers can turn."""
_MARGIN = 50.0
"""From the edge of the camera's picture to the arena, mm."""
_TRIES = 1000

Corners = tuple[Point, ...]


class Kind(NamedTuple):
    """A kind of arenas.

    Attributes:
        convex: Whether the outer wall is.
        obstacles: Whether there are obstacles, one to three.
    """

    convex: bool
    obstacles: bool

    @property
    def name(self) -> str:
        """For tables."""
        return f"{'convex' if self.convex else 'not convex'}, {'obstacles' if self.obstacles else 'no obstacles'}"


KINDS = tuple(Kind(convex, obstacles) for obstacles in (False, True) for convex in (True, False))
"""Random arenas take turns."""


class RandomArena(NamedTuple):
    """An arena of the family.

    Attributes:
        kind: Of the arena.
        arena: Walls, home and obstacles. Its training marks are not used.
        foods: Number of food objects.
        seeds: Of the recalls. In each of them there is room for robot and food.
    """

    kind: Kind
    arena: Arena
    foods: int
    seeds: tuple[int, ...]

    @property
    def first_layout(self) -> Layout:
        """Where robot and food are at the start of the first recall."""
        return _layout(self.arena, self.foods, self.seeds[0])

    @property
    def limit(self) -> int:
        """Steps of a recall: 500 for one food object and 700 for two, as in the thesis, 200 for each further one."""
        return 300 + 200 * self.foods


def random_arena(seed: int, number: int, recalls: int) -> RandomArena:
    """One arena of the family of a seed.

    Args:
        seed: Of the family.
        number: Of the arena, from 0.
        recalls: How many seeds of recalls to draw with it.

    Raises:
        RuntimeError: No valid arena was found.
    """
    shapes, episodes = np.random.SeedSequence(seed, spawn_key=(4, number)).spawn(2)
    rng, seeds = np.random.default_rng(shapes), tuple(episodes.generate_state(recalls).tolist())
    kind = KINDS[number % len(KINDS)]
    for _ in range(_TRIES):
        foods = int(rng.integers(1, MOST_FOODS + 1))
        try:
            arena = _draw(rng, f"random {number}", kind)
            for episode in seeds:
                _layout(arena, foods, episode)
        except ValueError:  # a shape without room
            continue
        return RandomArena(kind, arena, foods, seeds)
    raise RuntimeError(f"no arena {number} of seed {seed} in {_TRIES} tries")


def is_convex(corners: Sequence[Point]) -> bool:
    """Whether a simple polygon is convex."""
    turns = []
    for i, corner in enumerate(corners):
        before, after = corners[i - 1], corners[(i + 1) % len(corners)]
        turns.append(
            (corner.x - before.x) * (after.y - corner.y) - (corner.y - before.y) * (after.x - corner.x) > 0
        )
    return len(set(turns)) == 1


def _layout(arena: Arena, foods: int, seed: int) -> Layout:
    """The layout of a recall, the same on every backend.

    Raises:
        ValueError: There is no room.
    """
    return random_layout(arena, foods, layout_key(key_of(seed), 0), Decisions().values())


def _draw(rng: np.random.Generator, name: str, kind: Kind) -> Arena:
    """One try.

    Raises:
        ValueError: The shape has no room.
    """
    shapes: tuple[_Shape, ...] = (_round,) if kind.convex else (_l, _t, _u, _star)
    corners = shapes[rng.integers(len(shapes))](rng)
    if is_convex(corners) != kind.convex:
        raise ValueError(f"{name}: the wrong kind")
    polygon.check(name, corners)
    walls = _turned(corners, rng.uniform(0, 2 * math.pi))
    obstacles: list[Corners] = []
    for _ in range(int(rng.integers(1, MOST_OBSTACLES + 1)) if kind.obstacles else 0):
        obstacles.append(_obstacle(rng, walls, obstacles))
    free = walls_of((walls, *obstacles))
    home = _place(rng, free, HOME_RADIUS)
    # Training marks, which recalls do not use.
    return Arena(name, walls, home, HOME_RADIUS, Pose(*home, 0.0), (home,), tuple(obstacles))


_Shape = Callable[[np.random.Generator], Corners]


def _round(rng: np.random.Generator) -> Corners:
    """Three to eight corners on an ellipse, which make a convex polygon."""
    across, along = rng.uniform(300, 600, 2)
    return _around(rng, int(rng.integers(3, 9)), lambda: (across, along))


def _star(rng: np.random.Generator) -> Corners:
    """Six to ten corners in a circle at any distance from its centre."""
    return _around(rng, int(rng.integers(6, 11)), lambda: (rng.uniform(200, 700),) * 2)


def _around(rng: np.random.Generator, count: int, radii: Callable[[], tuple[float, float]]) -> Corners:
    """Corners around the origin, in even steps but for some deviation."""
    corners = []
    for i in range(count):
        angle = 2 * math.pi * (i + rng.uniform(-0.3, 0.3)) / count
        a, b = radii()
        corners.append(Point(a * math.cos(angle), b * math.sin(angle)))
    return tuple(corners)


def _l(rng: np.random.Generator) -> Corners:
    """An L."""
    width, height = rng.uniform(600, 1200, 2)
    x, y = rng.uniform(WIDTH, width - 100), rng.uniform(WIDTH, height - 100)
    return _points((0, 0), (width, 0), (width, y), (x, y), (x, height), (0, height))


def _t(rng: np.random.Generator) -> Corners:
    """A T upside down: the bar at the bottom."""
    width, height = rng.uniform(700, 1200), rng.uniform(600, 1200)
    y = rng.uniform(WIDTH, height - 100)
    left = rng.uniform(100, width - WIDTH - 100)
    right = rng.uniform(left + WIDTH, width - 100)
    return _points(
        (0, 0), (width, 0), (width, y), (right, y), (right, height), (left, height), (left, y), (0, y)
    )


def _u(rng: np.random.Generator) -> Corners:
    """A U."""
    width, height = rng.uniform(700, 1200), rng.uniform(600, 1200)
    y = rng.uniform(WIDTH, height - 100)
    left = rng.uniform(WIDTH, width - WIDTH - 100)
    right = rng.uniform(left + 50, width - WIDTH)
    return _points(
        (0, 0),
        (width, 0),
        (width, height),
        (right, height),
        (right, y),
        (left, y),
        (left, height),
        (0, height),
    )


def _obstacle(rng: np.random.Generator, walls: Corners, others: Sequence[Corners]) -> Corners:
    """A convex polygon on the floor, away from walls and other obstacles.

    Raises:
        ValueError: There is no room.
    """
    radius = rng.uniform(30, 100)
    x, y = _place(rng, walls_of((walls, *others)), radius + PASSAGE)
    corners = _around(rng, int(rng.integers(3, 7)), lambda: (radius, radius))
    return tuple(Point(x + cx, y + cy) for cx, cy in corners)


def _place(rng: np.random.Generator, walls: Sequence[Wall], room: float) -> Point:
    """A random place with some room around it.

    Raises:
        ValueError: None was found.
    """
    xs, ys = [wall.x1 for wall in walls], [wall.y1 for wall in walls]
    for _ in range(_TRIES):
        place = Point(float(rng.uniform(min(xs), max(xs))), float(rng.uniform(min(ys), max(ys))))
        if clearance(*place, walls) >= room:
            return place
    raise ValueError(f"no place {room:g} mm from every wall")


def _turned(corners: Corners, angle: float) -> Corners:
    """A polygon turned by an angle, in whole mm, within the camera's picture."""
    cos, sin = math.cos(angle), math.sin(angle)
    turned = [(x * cos - y * sin, x * sin + y * cos) for x, y in corners]
    left, bottom, *_ = polygon.bounds(tuple(turned))
    return tuple(Point(round(x - left + _MARGIN), round(y - bottom + _MARGIN)) for x, y in turned)


def _points(*corners: tuple[float, float]) -> Corners:
    return tuple(Point(float(x), float(y)) for x, y in corners)
