"""The imitators' search and vote (section 4.6), compiled from the functions of `policies.nearest_neighbour`."""

from bisect import bisect_left
from typing import Any

from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, stand_in
from khepera_forage.policies.nearest_neighbour.distance import rounded_distance, scaled_distance
from khepera_forage.policies.nearest_neighbour.memories import plane_key
from khepera_forage.policies.nearest_neighbour.votes import clear, draw_label, nearest_votes, search_plane

__all__ = ["clear", "draw_label", "nearest_votes"]

_FEW = 16
"""Values among which looking at one after the other is faster than halving."""

for _rule in (scaled_distance, rounded_distance, plane_key, clear, search_plane, nearest_votes, draw_label):
    inline(_rule)


@stand_in(bisect_left)
def _bisect_left(values: NDArray[Any], value: int, first: int, last: int) -> int:
    while last - first > _FEW:
        middle = (first + last) // 2
        if values[middle] < value:
            first = middle + 1
        else:
            last = middle
    while first < last and values[first] < value:
        first += 1
    return first
