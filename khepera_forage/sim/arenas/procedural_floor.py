"""Floors of procedural arenas: a rectangle with notches, partitions with doors, and blocks. Whole millimetres."""

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeVar
from zlib import crc32

from khepera_forage.counter_rng import key_of, random_bits
from khepera_forage.sim.arenas.difficulty import Difficulty

T = TypeVar("T")

PASSAGE = 240
"""Least distance between walls that do not touch. Path finding keeps 80 mm from walls, and up to 120 from corners."""
_ARM = 300
"""Least width of what notches leave of the floor."""
_ROOM = 260
"""Least distance between partitions, and from them to parallel walls: more than the width of the thesis's corridor."""
_SMALLEST_NOTCH, _SHORTEST_PIECE = 120, 60
_DOOR = (220, 320)
_THICKNESS = 40
_TRIES = 30
"""For each partition and block."""

Corners = tuple[tuple[int, int], ...]


class NoRoomError(ValueError):
    """A try to draw an arena found no room for something."""


class Draws:
    """Random numbers of one try to draw an arena, from the counter-based generator.

    Args:
        level: Of the arena.
        stream: Name of the difficulty, which has numbers of its own.
        attempt: From 0.
    """

    def __init__(self, level: int, stream: str, attempt: int) -> None:
        self._key = random_bits(key_of(level) ^ crc32(stream.encode()), attempt)
        self._number = 0

    def whole(self, low: int, high: int) -> int:
        """A whole number from `low` to `high`, each as likely as the others."""
        self._number += 1
        # The remainder favours small numbers by less than 1 in 2**40.
        return int(low + random_bits(self._key, self._number) % (high - low + 1))

    def one_of(self, items: Sequence[T]) -> T:
        """One of the items."""
        return items[self.whole(0, len(items) - 1)]

    def sample(self, items: Sequence[T], count: int) -> list[T]:
        """Different items, in the order of drawing."""
        left = list(items)
        return [left.pop(self.whole(0, len(left) - 1)) for _ in range(count)]


class Notch(NamedTuple):
    """A rectangle cut out of a corner of the floor.

    Attributes:
        right: Whether the corner is one on the right.
        top: Whether the corner is one at the top.
        dx: Size.
        dy: Size.
    """

    right: bool
    top: bool
    dx: int
    dy: int


class Cells(NamedTuple):
    """A rectangle with level sides."""

    left: int
    bottom: int
    right: int
    top: int

    @classmethod
    def around(cls, corners: Corners) -> "Cells":
        """The smallest one that contains a polygon."""
        xs, ys = [x for x, _ in corners], [y for _, y in corners]
        return cls(min(xs), min(ys), max(xs), max(ys))

    def corners(self) -> Corners:
        """Counter-clockwise."""
        return ((self.left, self.bottom), (self.right, self.bottom), (self.right, self.top), (self.left, self.top))

    def is_apart(self, other: "Cells") -> bool:
        """Whether there is a passage between two boxes."""
        dx = max(self.left - other.right, other.left - self.right, 0)
        dy = max(self.bottom - other.top, other.bottom - self.top, 0)
        return dx * dx + dy * dy >= PASSAGE * PASSAGE


class Outline(NamedTuple):
    """The outer wall.

    Attributes:
        length: Along x.
        width: Along y.
        notches: At different corners.
    """

    length: int
    width: int
    notches: tuple[Notch, ...]

    def corners(self) -> Corners:
        """Counter-clockwise."""
        found: list[tuple[int, int]] = []
        at = {(notch.right, notch.top): notch for notch in self.notches}
        for right, top in ((False, False), (True, False), (True, True), (False, True)):
            x, y = self.length * right, self.width * top
            notch = at.get((right, top))
            if notch is None:
                found.append((x, y))
                continue
            inner_x, inner_y = abs(x - notch.dx), abs(y - notch.dy)
            around = [(x, inner_y), (inner_x, inner_y), (inner_x, y)]
            found += around if right == top else around[::-1]
        return tuple(found)

    def span(self, x: int) -> tuple[int, int]:
        """Lowest and highest y of the floor at an x that is not on a vertical wall."""
        bottom, top = 0, self.width
        for notch in self.notches:
            if x > self.length - notch.dx if notch.right else x < notch.dx:
                bottom, top = (bottom, self.width - notch.dy) if notch.top else (notch.dy, top)
        return bottom, top

    def has_room(self, box: Cells) -> bool:
        """Whether there are passages between a box and the rectangle around the floor."""
        return min(box.left, box.bottom, self.length - box.right, self.width - box.top) >= PASSAGE

    def cut_out(self) -> list[Cells]:
        """The notches as boxes."""
        boxes = []
        for right, top, dx, dy in self.notches:
            x, y = (self.length - dx) * right, (self.width - dy) * top
            boxes.append(Cells(x, y, x + dx, y + dy))
        return boxes


def draw_floor(draws: Draws, difficulty: Difficulty) -> tuple[Corners, list[Corners]]:
    """An outer wall, and the obstacles inside.

    Raises:
        NoRoomError: Something that the difficulty requires does not fit.
    """
    outline = _outline(draws, difficulty)
    walls = outline.corners()
    budget = difficulty.most_walls - len(walls)
    partitions = _partitions(draws, outline, draws.whole(*difficulty.partitions), budget)
    budget -= 4 * len(partitions)
    if budget < 0:
        raise NoRoomError(f"there are more than {difficulty.most_walls} walls")
    blocks = _blocks(draws, outline, partitions, difficulty.blocks, budget)
    return walls, [*(piece.corners() for piece in partitions), *blocks]


def _outline(draws: Draws, difficulty: Difficulty) -> Outline:
    length, width = draws.whole(*difficulty.length), draws.whole(*difficulty.width)
    places = [(right, top) for right in (False, True) for top in (False, True)]
    # Two notches of this size beside each other leave an arm between them.
    most_dx, most_dy = (length - _ARM) // 2, (width - _ARM) // 2
    notches = [
        Notch(*place, draws.whole(_SMALLEST_NOTCH, most_dx), draws.whole(_SMALLEST_NOTCH, most_dy))
        for place in draws.sample(places, draws.whole(*difficulty.notches))
        if min(most_dx, most_dy) >= _SMALLEST_NOTCH
    ]
    return Outline(length, width, tuple(notches))


def _partitions(draws: Draws, outline: Outline, count: int, budget: int) -> list[Cells]:
    """The pieces of walls across the floor, each wall with a door at an end or in the middle."""
    taken = [0, outline.length, *(x for notch in outline.cut_out() for x in (notch.left, notch.right))]
    pieces: list[Cells] = []
    for left in range(count, 0, -1):
        x = _free_place(draws, outline.length, taken)
        taken.append(x)
        bottom, top = outline.span(x)
        door = draws.whole(*_DOOR)
        room = top - bottom - door
        if room < _SHORTEST_PIECE:
            raise NoRoomError(f"a door of {door} mm does not fit")
        # Two pieces instead of one, if the budget is enough for them and for the further partitions.
        two_pieces = room >= 2 * _SHORTEST_PIECE and budget >= 4 * (len(pieces) + left + 1) and draws.whole(0, 1)
        low = bottom + (draws.whole(_SHORTEST_PIECE, room - _SHORTEST_PIECE) if two_pieces else draws.one_of((0, room)))
        half = _THICKNESS // 2
        pieces += [Cells(x - half, y1, x + half, y2) for y1, y2 in ((bottom, low), (low + door, top)) if y2 > y1]
    return pieces


def _free_place(draws: Draws, length: int, taken: list[int]) -> int:
    for _ in range(_TRIES):
        x = draws.whole(_ROOM, length - _ROOM)
        if all(abs(x - other) >= _ROOM + _THICKNESS for other in taken):
            return x
    raise NoRoomError("a partition does not fit")


def _blocks(
    draws: Draws, outline: Outline, partitions: list[Cells], count: tuple[int, int], budget: int
) -> list[Corners]:
    """Polygons that stand free."""
    least, most = count
    blocks: list[Corners] = []
    taken = [*outline.cut_out(), *partitions]
    for _ in range(draws.whole(least, most)):
        for _ in range(_TRIES):
            block = _block(draws, draws.whole(PASSAGE, outline.length), draws.whole(PASSAGE, outline.width))
            around = Cells.around(block)
            if len(block) <= budget and outline.has_room(around) and all(map(around.is_apart, taken)):
                budget -= len(block)
                blocks.append(block)
                taken.append(around)
                break
    if len(blocks) < least:
        raise NoRoomError("a block does not fit")
    return blocks


def _block(draws: Draws, x: int, y: int) -> Corners:
    """A convex polygon around a place: a bar, a box, or three to six corners on a circle."""
    kind = draws.one_of(("bar", "box", "circle"))
    if kind == "circle":
        count, radius, turn = draws.whole(3, 6), draws.whole(40, 100), math.radians(draws.whole(0, 119))
        angles = [turn + 2 * math.pi * i / count for i in range(count)]
        return tuple((x + round(radius * math.cos(a)), y + round(radius * math.sin(a))) for a in angles)
    long, short = (draws.whole(160, 360), 30) if kind == "bar" else (draws.whole(60, 180), draws.whole(60, 180))
    dx, dy = (long // 2, short // 2) if draws.whole(0, 1) else (short // 2, long // 2)
    return Cells(x - dx, y - dy, x + dx, y + dy).corners()
