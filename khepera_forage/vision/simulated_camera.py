"""What a simulated camera looks at, and rendered frames are drawn from."""

from typing import NamedTuple

_Marker = tuple[float, float, float, int]


class Truth(NamedTuple):
    """Where everything under the camera really is.

    Attributes:
        markers: For each robot x and y of its centre in mm, its heading in radians, and the number of holes
            in its marker (1 or 2).
        foods: Centre of each food object in mm, hidden ones included.
    """

    markers: tuple[_Marker, ...]
    foods: tuple[tuple[float, float], ...]
