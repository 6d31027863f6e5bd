"""Sides of a marker that a cable lies along.

Such a cable is outside the white or covers only a fraction of a pixel of it: it cannot be told from the marker's black
frame, and the side would be measured too far inside. But it goes on beyond both ends of the side.
"""

import numpy as np
from numpy.typing import NDArray

_BEYOND = (5.0, 6.0, 7.0)
"""Region pixels beyond the end of a side where the floor is looked at: beyond the black frame and its blur, even of a
marker that appears 15 % too large."""
_ASIDE = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)
"""Region pixels from the line of the side, outwards, where a cable is looked for: with it, cables that make an angle of
up to 10 degrees with the side are found."""
_DEVIATION = 0.1
"""Share of the floor's brightness by which a cable differs from it: a grey one, 4 mm wide and blurred, differs by 0.15
to 0.2, and floor with its texture, noise and light by up to 0.09."""
_OPPOSITE = [1, 0, 3, 2]
"""Number of the side that is opposite to each: front, back, left, right."""


def places_beyond_ends(length: float, width: float) -> NDArray[np.float64]:
    """Where to look for cables.

    Args:
        length: Of the rectangle: its extent along x, region pixels.
        width: Its extent along y.

    Returns:
        x and y from its centre, for front, back, left and right side; shape (places, 2).
    """
    a, b = length / 2, width / 2
    ends = [(end, aside, beyond) for end in (1, -1) for aside in _ASIDE for beyond in _BEYOND]
    across = [(sign * (a + aside), end * (b + beyond)) for sign in (1, -1) for end, aside, beyond in ends]
    along = [(end * (a + beyond), sign * (b + aside)) for sign in (1, -1) for end, aside, beyond in ends]
    return np.array(across + along)


def sides_along_cables(levels: NDArray[np.float64], floor: float) -> NDArray[np.bool_]:
    """For each side, whether a cable lies along it.

    Of two opposite sides one is needed to measure the marker: if something lies along both, neither is given.

    Args:
        levels: Grey levels at `places_beyond_ends`.
        floor: Grey level of the floor.
    """
    means = levels.reshape(4, 2, len(_ASIDE), len(_BEYOND)).mean(axis=3)
    seen: NDArray[np.bool_] = (np.abs(means - floor) > _DEVIATION * floor).any(axis=2).all(axis=1)
    return seen & ~seen[_OPPOSITE]
