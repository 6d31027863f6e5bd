"""The scene that a camera reports: the regions of section 3.5.

Coordinates are pixels of 5 mm on the floor, x to the right and y up, as floats. Orientations are whole degrees
counter-clockwise from the x axis. A calibrated camera maps its picture into this coordinate frame.
"""

from typing import NamedTuple, Protocol

MM_PER_PIXEL = 5.0
"""Decision: 5 mm per pixel, so that the picture covers the 2.4 m of the arena and its surroundings (3.4)."""


class Region(NamedTuple):
    """One bright region, with the attributes that Quek's tracker stores (3.5).

    Attributes:
        label: Number of the track, never reused; a region keeps it while tracked or lost.
        x: Centre in pixels.
        y: Centre in pixels.
        holes: Number of dark regions inside: 1 or 2 for the markers of robots, 0 for food.
        orientation: Degrees 0..359 along the long side of a marker; 0 for a region without holes.
        found: True while tracked; False while lost, when all other attributes are those last seen.
        edge: Whether the region touches the edge of the picture.
        first_x: First pixel of the region in reading order (topmost row, leftmost in it).
        first_y: First pixel of the region.
        area: In square pixels, holes not counted.
        perimeter: Length of the outer contour in pixels.
    """

    label: int
    x: float
    y: float
    holes: int
    orientation: int
    found: bool
    edge: bool
    first_x: float
    first_y: float
    area: float
    perimeter: float

    @property
    def compactness(self) -> float:
        """perimeter^2 / area."""
        return self.perimeter**2 / self.area


class Scene(NamedTuple):
    """All regions at one time, oldest track first."""

    regions: tuple[Region, ...]


class Truth(NamedTuple):
    """Where everything under the camera really is: what a simulated camera looks at, and frames are rendered from.

    Attributes:
        markers: For each robot x and y of its centre in mm, its heading in radians, and the number of its marker:
            that of its holes, or the id of a tag.
        foods: Centre of each food object in mm, hidden ones included.
    """

    markers: tuple[tuple[float, float, float, int], ...]
    foods: tuple[tuple[float, float], ...]


class Camera(Protocol):
    """An overhead camera with its tracker."""

    def look(self) -> Scene:
        """The regions tracked now; calling this takes no frame."""
        ...


def kind_text(region: Region) -> str:
    """What a region is, for messages: food, or the marker with a number."""
    return f"marker {region.holes}" if region.holes else "food"


def place_text(x: float, y: float) -> str:
    """A place in pixels as text in mm, for warnings."""
    return f"({x * MM_PER_PIXEL:.0f}, {y * MM_PER_PIXEL:.0f}) mm"
