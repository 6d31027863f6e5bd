"""Appearance of rendered frames: intensities, light, lens, sensor and cables, each figure with its reason."""

import math
from dataclasses import dataclass, fields, replace

_GREYS = ("white", "black", "floor", "wall", "body", "gripper", "cable")


@dataclass(frozen=True, slots=True)
class CameraAppearance:
    """Appearance of the laboratory in the overhead camera's frames. Greys are levels 0..255 under full light.

    The thesis's only picture from the camera (figure 3.7) did not survive, so most figures are assumptions. None was
    fitted to the tracker's results on rendered frames.

    Raises:
        ValueError: A value that is not finite or out of its range; the message says which.
    """

    white: float = 225.0
    """Marker and food: paper and white tape (3.1), exposed just short of saturation. Assumption."""
    black: float = 25.0
    """Holes and frame of a marker: printed black is about a tenth as bright as paper."""
    floor: float = 105.0
    """The floor has "a medium intensity colour", so that white stands out (3.1). Assumption: half of white."""
    wall: float = 82.0
    """Walls are of medium intensity (3.1), but seen from above mostly the shaded edge of a board. Assumption."""
    wall_width: float = 10.0
    """Thickness of the walls in mm. Assumption: a board."""
    body: float = 48.0
    """The robot's body: dark circuit boards. Assumption."""
    gripper: float = 62.0
    """The gripper's fingers: dark metal. Assumption."""
    texture: float = 2.5
    """Standard deviation of the floor's blotches and grain, in grey levels. Assumption."""
    gradient: float = 0.08
    """Relative change of light from the middle of the picture to a side: windows, unequal lamps. Assumption."""
    vignette: float = 0.22
    """Share of light missing in the corners. The natural fall-off, cos^4, of a lens that sees 3.2 x 2.4 m from about
    2.7 m is a third there; a long lens (the thesis mentions a "long zoom") loses less."""
    drift: float = 0.04
    """Relative size of slow changes of light and gradient, over half a minute and more: clouds, mains. Assumption."""
    blur: float = 0.7
    """Standard deviation in pixels of the blur by lens and frame grabber: a focused video lens. Assumption."""
    grain: float = 2.5
    """Standard deviation of the sensor's noise in grey levels. A CCD camera of 2001 with 50 dB has 0.8; with its gain
    raised for room light it has 40 dB."""
    cable: float = 60.0
    """The cables: dark grey plastic. Assumption."""
    cable_width: float = 4.0
    """Thickness of a cable in mm at the scale of the floor: a 3 mm cable nearer to the camera. 0 draws no cables."""
    cable_sag: float = 70.0
    """Distance in mm of the middle of a cable from the straight line between anchor and robot. Assumption."""
    cable_sway: float = 40.0
    """Amplitude in mm by which that distance changes, over several seconds. Assumption."""
    height: float | None = None
    """Height in mm of the camera above the floor, over the middle of the picture. Objects with a height then appear
    shifted outwards (parallax). None is a camera infinitely far away, without parallax."""
    marker_height: float = 70.0
    """Height in mm of a marker above the floor: on posts over the gripper turret, clear of a raised arm. Assumption."""

    def __post_init__(self) -> None:
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            if not (name == "height" and value is None) and not 0 <= value < math.inf:
                raise ValueError(f"camera appearance {name} is {value!r}; allowed: a finite number >= 0")
            if name in _GREYS and value > 255:
                raise ValueError(f"camera appearance {name} is {value!r}; allowed: a grey level 0..255")
        if self.cable_width > 40:
            raise ValueError(
                f"camera appearance cable_width is {self.cable_width!r} mm; allowed: up to 40 mm"
            )
        if self.height is not None and self.height <= self.marker_height:
            raise ValueError(
                f"camera appearance height is {self.height!r} mm; allowed: above the markers at "
                f"{self.marker_height!r} mm"
            )

    @classmethod
    def laboratory(cls) -> "CameraAppearance":
        """The laboratory by our assumptions: the default everywhere."""
        return cls()

    @classmethod
    def none(cls) -> "CameraAppearance":
        """The same objects under even light, through a perfect lens, without noise, texture or cables."""
        disturbances = ("texture", "gradient", "vignette", "drift", "blur", "grain", "cable_width")
        return replace(cls(), **dict.fromkeys(disturbances, 0.0))
