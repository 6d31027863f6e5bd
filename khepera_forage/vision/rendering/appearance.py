"""How a rendered picture looks: intensities, light, lens, sensor and cables, each figure with its reason."""

import math
from dataclasses import dataclass, fields, replace

_GREYS = ("white", "black", "floor", "wall", "body", "gripper", "cable")


@dataclass(frozen=True, slots=True)
class CameraLook:
    """What the overhead camera makes of the laboratory. Greys are levels 0..255 under full light.

    The thesis' only picture of it (figure 3.7) did not survive, so most figures are assumptions; no figure was
    fitted to how well the tracker does on it.
    """

    white: float = 225.0
    """Marker and food: paper and white tape (3.1), exposed just short of saturation. Assumption."""
    black: float = 25.0
    """Holes and frame of a marker: printed black is about a tenth as bright as paper."""
    floor: float = 105.0
    """"A medium intensity colour", so that white stands out (3.1); half of white. Assumption."""
    wall: float = 82.0
    """Also of medium intensity (3.1), but seen from above mostly the shaded edge of a board. Assumption."""
    wall_width: float = 10.0
    """Thickness of the walls in mm. Assumption: a board."""
    body: float = 48.0
    """The robot's body: dark circuit boards. Assumption."""
    gripper: float = 62.0
    """The gripper's fingers: dark metal. Assumption."""
    texture: float = 2.5
    """Standard deviation of the floor's own blotches and grain, in grey levels. Assumption."""
    gradient: float = 0.08
    """By what share the light changes from the middle of the picture to a side: windows, unequal lamps. Assumption."""
    vignette: float = 0.22
    """Share of light missing in the corners: natural fall-off cos^4 of a lens that sees 3.2 x 2.4 m from about 2.7 m
    costs a third there; a long lens less (the thesis speaks of a "long zoom")."""
    drift: float = 0.04
    """By what share light and gradient come and go, over half a minute and more: clouds, mains. Assumption."""
    blur: float = 0.7
    """Standard deviation of the lens' and the grabber's blur in pixels: a focused video lens. Assumption."""
    grain: float = 2.5
    """Standard deviation of the sensor's noise in grey levels. A CCD camera's 50 dB of that day are 0.8; its gain
    turned up for room light takes it to 40 dB."""
    cable: float = 60.0
    """The cables: dark grey plastic. Assumption."""
    cable_width: float = 4.0
    """Thickness of a cable in mm as it shows on the floor's scale: 3 mm, nearer to the camera. 0 hangs none."""
    cable_sag: float = 70.0
    """How far in mm the middle of a cable hangs beside the straight line from the anchor to the robot. Assumption."""
    cable_sway: float = 40.0
    """How far in mm the middle of a cable swings about that, over several seconds. Assumption."""
    height: float | None = None
    """Height in mm of the camera above the floor, over the middle of the picture: what stands up then leans
    outwards (parallax). None looks straight down everywhere, as if from far away."""
    marker_height: float = 70.0
    """Height in mm of a marker above the floor: on posts over the gripper turret, clear of a raised arm. Assumption."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "height" and value is None:
                continue
            if not 0 <= value < math.inf:
                raise ValueError(f"look {field.name} is {value!r}; allowed: a finite number >= 0")
        for name in _GREYS:
            if getattr(self, name) > 255:
                raise ValueError(f"look {name} is {getattr(self, name)!r}; allowed: a grey level 0..255")
        if self.cable_width > 17:
            raise ValueError(f"look cable_width is {self.cable_width!r} mm; allowed: up to 17 mm")
        if self.height is not None and self.height <= self.marker_height:
            raise ValueError(
                f"look height is {self.height!r} mm; allowed: above the markers at {self.marker_height!r} mm"
            )

    @classmethod
    def laboratory(cls) -> "CameraLook":
        """The laboratory as we imagine it: the default everywhere."""
        return cls()

    @classmethod
    def none(cls) -> "CameraLook":
        """The same things under even light, through a perfect lens, without noise, texture or cables."""
        quiet = ("texture", "gradient", "vignette", "drift", "blur", "grain", "cable_width")
        return replace(cls(), **dict.fromkeys(quiet, 0.0))
