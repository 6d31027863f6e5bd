"""Random whole numbers for procedural arenas, the same on every machine."""

from collections.abc import Sequence
from typing import TypeVar
from zlib import crc32

from khepera_forage.counter_rng import key_of, random_bits

T = TypeVar("T")


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
