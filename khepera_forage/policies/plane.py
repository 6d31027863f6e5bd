"""Points of whole numbers in a plane, and the nearest ones in Manhattan distance, exactly."""

from bisect import bisect_left, bisect_right, insort

Counts = dict[int, int]
"""How often a point was seen with each class that it was seen with."""


class Plane:
    """Distinct points (x, y), in columns of equal x, both sorted.

    A search goes outward from its own column, first to one side, then to the other, and ends where columns alone
    are further away than the best point so far: in planes as dense as experience is, after a handful. One more point
    costs two insertions into sorted lists; nothing is ever rebuilt. All numbers are Python's, which never overflow
    or round.
    """

    __slots__ = ("_columns", "_counts", "_high", "_low", "_xs")

    def __init__(self) -> None:
        self._xs: list[int] = []
        self._columns: dict[int, list[int]] = {}
        self._counts: dict[tuple[int, int], Counts] = {}
        self._low = self._high = 0

    def add(self, x: int, y: int, code: int, times: int = 1) -> None:
        """Count the point for class `code`, once or several times."""
        counts = self._counts.get((x, y))
        if counts is None:
            self._low, self._high = (min(self._low, y), max(self._high, y)) if self._counts else (y, y)
            counts = self._counts[x, y] = {}
            column = self._columns.get(x)
            if column is None:
                self._columns[x] = [y]
                insort(self._xs, x)
            else:
                insort(column, y)
        counts[code] = counts.get(code, 0) + times

    def items(self) -> list[tuple[int, int, Counts]]:
        """Every distinct point with its counts."""
        return [(x, y, counts) for (x, y), counts in self._counts.items()]

    def nearest(self, x: int, y: int, reach: int) -> tuple[int, list[Counts]]:
        """The least distance of a point, if it is at most `reach`, and the counts of all points at it.

        Returns:
            The distance and the counts; with no point in reach there are none, and the distance means nothing.
        """
        here = self._counts.get((x, y))
        if here is not None:
            return 0, [here]
        # No point is nearer to y than the gap, which narrows the columns worth a look.
        low, high = self._low, self._high
        gap = low - y if y < low else y - high if y > high else 0
        if gap > reach:
            return reach, []
        xs, columns = self._xs, self._columns
        middle = bisect_left(xs, x)
        found: list[tuple[int, int]] = []
        for side in (xs[middle:], xs[middle - 1 :: -1] if middle else ()):
            for column_x in side:
                across = column_x - x if column_x > x else x - column_x
                if across + gap > reach:
                    break  # and so is every column further out
                column = columns[column_x]
                if y <= column[0]:
                    place = 0
                elif y >= column[-1]:
                    place = -1
                else:
                    place = bisect_left(column, y)
                    away = across + y - column[place - 1]
                    if away <= reach:
                        if away < reach:
                            reach, found = away, []
                        found.append((column_x, column[place - 1]))
                above = column[place]
                away = across + (above - y if above > y else y - above)
                if away <= reach:
                    if away < reach:
                        reach, found = away, []
                    found.append((column_x, above))
        return reach, [self._counts[point] for point in found]

    def within(self, x: int, y: int, reach: int) -> list[Counts]:
        """The counts of all points at most `reach` away."""
        first, last = bisect_left(self._xs, x - reach), bisect_right(self._xs, x + reach)
        found = []
        for column_x in self._xs[first:last]:
            left = reach - abs(column_x - x)
            column = self._columns[column_x]
            for column_y in column[bisect_left(column, y - left) : bisect_right(column, y + left)]:
                found.append(self._counts[column_x, column_y])
        return found
