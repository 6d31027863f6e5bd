"""What a camera reports: the regions of section 3.5.

Coordinates are pixels of 5 mm on the arena plane, x to the right and y up, as floats; orientations are whole
degrees counter-clockwise from the x axis. A calibrated camera maps its image into this frame.
"""

from typing import NamedTuple, Protocol

MM_PER_PIXEL = 5.0
"""Our decision: 640 pixels over the 2.4 m of the arena and its surroundings (3.4)."""


class Region(NamedTuple):
    """One bright region, as Quek's tracker stores it (3.5).

    Attributes:
        label: Number of the track; stays with the region for as long as it is tracked or lost, never reused.
        x: Centre in pixels.
        y: Centre in pixels.
        holes: Dark regions within it: 1 or 2 for the markers of robots, 0 for food.
        orientation: Degrees 0..359 along the long side of a marker; 0 for a region without holes.
        found: True while tracked; False while lost, when all else is as it was last seen.
        edge: Whether it touches the edge of the picture.
        first_x: First pixel of the region in reading order (topmost row, leftmost in it).
        first_y: First pixel of the region.
        area: In square pixels, holes not counted.
        perimeter: Outer contour in pixels.
        compactness: perimeter^2 / area.
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
    compactness: float


class Scene(NamedTuple):
    """All regions of one look, oldest track first."""

    regions: tuple[Region, ...]


class Camera(Protocol):
    """An overhead camera with its tracker."""

    def look(self) -> Scene:
        """The regions as they are tracked now."""
        ...
