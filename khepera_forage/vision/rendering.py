"""Rendered frames: what the overhead camera would show of a simulated world, as input for the real tracker."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import (
    CONTROL_PERIOD,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_HEIGHT,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    MARKER_LENGTH,
    MARKER_WIDTH,
    RADIUS,
    half_gap,
)
from khepera_forage.vision.calibration import DEFAULT_SIZE
from khepera_forage.vision.scene import MM_PER_PIXEL, Truth
from khepera_forage.vision.shapes import ARRANGEMENTS, MARKER_FRAME
from khepera_forage.vision.tags import CELLS, white_cells
from khepera_forage.vision.tracker_settings import TrackerSettings
from khepera_forage.vision.video import Frame

_GREYS = ("white", "black", "floor", "wall", "body", "gripper", "cable")
_SUPERSAMPLING = 16
"""Shapes are drawn enlarged by this factor, then reduced by averaging: edges are exact to a fiftieth of a pixel."""
_SHAPE_BITS, _CABLE_BITS = 8, 4
"""Fractional bits in the coordinates of OpenCV's drawing functions."""
_GROWTH = 0.5 / _SUPERSAMPLING
"""Pixels by which OpenCV draws shapes too large: it fills every pixel that an edge passes through."""
_ROBOT_HEIGHT = 45.0
"""Height in mm of the body with the gripper turret, for its parallax."""
_SHADE, _SHADE_WIDTH = 0.35, 4.0
"""Share by which a wall darkens the floor beside it, and the width of that shadow in pixels."""
_BLOTCH_SIZE = 9.0
"""Standard deviation in pixels of the blur that makes the floor's blotches."""
_DRIFT_PERIOD, _SWAY_PERIOD = 40.0, 7.0
"""Typical periods in s of the light's drift and of the cables' sway."""
_WAVES, _PERIODS = 3, (0.6, 1.7)
"""Waves of a slow signal, and their shortest and longest period as a share of the typical one."""
_SPARE = 256
"""Pixels by which the precomputed noise is larger than a frame in each direction."""
_FULL_SAG_LENGTH = 400.0
"""mm between anchor and robot from which on a cable sags in full; a nearer cable is steeper and shows less sag."""
_TAG_MARGIN = 0.5
"""Width of the white margin around a tag, in cells."""
_POINTS = 24
"""Points on the polyline that approximates a cable."""

Floats = NDArray[np.float64]
Wall = tuple[float, float, float, float]


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
            raise ValueError(f"camera appearance cable_width is {self.cable_width!r} mm; allowed: up to 40 mm")
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


class ImagePose(NamedTuple):
    """Origin in pixels, x to the right and y up, heading, and scale (pixels per mm) of an object in the picture."""

    x: float
    y: float
    cos: float
    sin: float
    scale: float


class Box(NamedTuple):
    """A rectangle in the object's own frame (mm, x forward), and its grey level."""

    x1: float
    y1: float
    x2: float
    y2: float
    grey: float


class Disc(NamedTuple):
    """A disc around the object's origin: radius in mm, and its grey level."""

    radius: float
    grey: float


class FrameRenderer:
    """Renders grey frames of a floor 3200 mm wide, whose lower left corner is (0, 0) mm: 640 x 480 pixels of 5 mm.

    A frame shows, from bottom to top: the floor and its walls, white food, the robots' dark bodies and grippers, their
    markers (white, 120 x 80 mm, with black holes and frame, or ArUco tags) and the cables. Light, lens, sensor and
    frame grabber then disturb the picture. Food under a marker is drawn and covered. Grippers are always drawn lowered
    and open: dark shapes on the floor make no region.

    Edges are exact to a fiftieth of a pixel before light and noise. A frame shows one instant, without motion blur (a
    robot drives 3 mm in the 20 ms of a frame).

    The same seed and the same truths give the same frames, bit for bit.

    Args:
        truth: Gives all true poses, called once a frame. The number of markers stays the same between two resets.
        appearance: Intensities and disturbances; None for those of the laboratory.
        anchor: Where the cables hang from, in mm as seen from above; None draws no cables.
        walls: Segments (x1, y1, x2, y2) in mm, as in `Arena.segments`.
        period: Seconds from one frame to the next, in which light and cables move.
        size: Width and height of the frames in pixels.
        tracker: What robots carry, and the size of tags; None for the thesis's markers.
        gripper: Whether the robots have one.

    Raises:
        ValueError: A period that is negative or not finite.

    Attributes:
        cables: Each robot's cable in the newest frame: n x 2 points in pixels, x right and y up, from the anchor to the
            middle of the marker, which hides its end; empty without cables.
    """

    def __init__(
        self,
        truth: Callable[[], Truth],
        appearance: CameraAppearance | None = None,
        anchor: tuple[float, float] | None = None,
        *,
        walls: Sequence[Wall] = (),
        period: float = CONTROL_PERIOD,
        size: tuple[int, int] = DEFAULT_SIZE,
        tracker: TrackerSettings | None = None,
        gripper: bool = True,
    ) -> None:
        if not (math.isfinite(period) and period >= 0):
            raise ValueError(f"period of frames is {period!r} s; allowed: a finite number >= 0")
        self._truth = truth
        self._appearance = CameraAppearance.laboratory() if appearance is None else appearance
        self._anchor = anchor
        self._walls = tuple(walls)
        self._period = period
        self._frames = 0
        self._floor: Frame | None = None
        self._sway: SlowNoise | None = None
        self.cables: list[Floats] = []
        self._size, self._mm = size, DEFAULT_SIZE[0] * MM_PER_PIXEL / size[0]
        self._tracker, self._gripper = tracker or TrackerSettings(), gripper

    def reset(self, rng: np.random.Generator) -> None:
        """Restart at time zero with another floor, other light and other cables.

        Args:
            rng: Only used to spawn other generators.
        """
        floor, light, cables = rng.spawn(3)
        self._frames = 0
        self._floor = _draw_floor(self._appearance, self._walls, floor, self._size)
        self._light = Light(self._appearance, light, self._size)
        self._sway, self.cables = None, []
        if self._anchor is not None and self._appearance.cable_width > 0:
            robots = len(self._truth().markers)
            self._sway = SlowNoise(cables, robots, _SWAY_PERIOD)
            self._sides = cables.choice((-1.0, 1.0), robots)

    def frame(self) -> Frame:
        """The next frame; row 0 is the top (largest y).

        Raises:
            RuntimeError: The renderer was never reset.
        """
        truth = self._truth()
        picture, seconds = self.picture(truth), self._frames * self._period
        self._frames += 1
        if self._sway is not None:
            self._draw_cables(picture, truth, self._sway.at(seconds))
        return self._light.expose(picture, seconds)

    def newest(self) -> tuple[Frame, float]:
        """The next frame, and its age: 0 s. With this and `close` the renderer is a `FrameSource`."""
        return self.frame(), 0.0

    def close(self) -> None:
        """Do nothing: there is no device to release."""

    def picture(self, truth: Truth | None = None) -> Frame:
        """What is there, or another truth, under full, even light: a frame without cables, lens and sensor.

        Raises:
            RuntimeError: The renderer was never reset.
        """
        if self._floor is None:
            raise RuntimeError("frame before any reset(rng); allowed: after one")
        truth, picture = truth or self._truth(), self._floor.copy()
        food, robot = (Disc(FOOD_RADIUS, self._appearance.white), _robot_shapes(self._appearance, self._gripper))
        for x, y in truth.foods:
            draw_shapes(picture, self._image_pose(x, y, 0.0, FOOD_HEIGHT), (food,))
        for x, y, heading, _ in truth.markers:
            draw_shapes(picture, self._image_pose(x, y, heading, _ROBOT_HEIGHT), robot)
        for x, y, heading, number in truth.markers:
            pose = self._image_pose(x, y, heading, self._appearance.marker_height)
            draw_shapes(picture, pose, _marker_shapes(self._appearance, number, self._tracker))
        return picture

    def _draw_cables(self, picture: Frame, truth: Truth, sway: Floats) -> None:
        """Draw a cable from the overhead anchor to each robot, seen from above a quadratic curve whose middle sways.

        A cable enters its robot under the marker, for the plug is on the robot. It therefore covers other markers and
        food, but never its own robot's marker.
        """
        assert self._anchor is not None
        appearance, start = self._appearance, np.array(self._anchor) / self._mm
        sags = (appearance.cable_sag * self._sides + appearance.cable_sway * sway) / self._mm
        poses = [self._image_pose(x, y, heading, appearance.marker_height) for x, y, heading, _ in truth.markers]
        full, width = _FULL_SAG_LENGTH / self._mm, appearance.cable_width / self._mm
        self.cables = [_cable(start, pose, float(sag), full) for pose, sag in zip(poses, sags, strict=True)]
        for pose, curve, (*_, number) in zip(poses, self.cables, truth.markers, strict=True):
            sheet, *_ = _marker_shapes(appearance, number, self._tracker)
            draw_cable(picture, curve, width, appearance.cable, (sheet, pose))

    def _image_pose(self, x: float, y: float, heading: float, height: float) -> ImagePose:
        """Pose in the picture of an object in mm, shifted by the parallax of its height."""
        column, row = x / self._mm, y / self._mm
        magnification = 1.0
        if self._appearance.height is not None:
            magnification = self._appearance.height / (self._appearance.height - height)
            middle = self._size[0] / 2, self._size[1] / 2
            column = middle[0] + (column - middle[0]) * magnification
            row = middle[1] + (row - middle[1]) * magnification
        return ImagePose(column, row, math.cos(heading), math.sin(heading), magnification / self._mm)


class SlowNoise:
    """Independent random signals, each the mean of three sine waves with random phases, and periods around one in s."""

    def __init__(self, rng: np.random.Generator, count: int, period: float) -> None:
        self._rates = 2 * np.pi / (period * rng.uniform(*_PERIODS, (count, _WAVES)))
        self._phases = rng.uniform(0, 2 * np.pi, (count, _WAVES))

    def at(self, seconds: float) -> Floats:
        """The signals at a time: mean 0, within -1..1, with a standard deviation of 0.41."""
        return np.sin(self._rates * seconds + self._phases).mean(axis=1)  # type: ignore[no-any-return]


class Light:
    """Blur, light that is a slowly tilting plane minus a paraboloid (the vignette), noise and quantisation.

    The noise is normal and independent from pixel to pixel. For speed it is drawn once, and each frame uses a randomly
    shifted and mirrored part of it.
    """

    def __init__(
        self, appearance: CameraAppearance, rng: np.random.Generator, size: tuple[int, int] = DEFAULT_SIZE
    ) -> None:
        drift, self._rng = rng.spawn(2)
        self._appearance = appearance
        self._drift = SlowNoise(drift, 3, _DRIFT_PERIOD)
        tilt = drift.uniform(-1, 1, 2)
        self._tilt = tilt * appearance.gradient / max(1e-9, float(np.abs(tilt).max()))
        width, height = size
        self._across = np.linspace(-1, 1, width, dtype=np.float32)
        self._down = np.linspace(-1, 1, height, dtype=np.float32)[:, None]
        noise = self._rng.standard_normal((height + _SPARE, width + _SPARE), dtype=np.float32)
        self._noise = np.float32(appearance.grain) * noise

    def expose(self, picture: Frame, seconds: float) -> Frame:
        """The frame that the camera takes of a picture under full, even light, some time after the reset."""
        appearance = self._appearance
        if appearance.blur > 0:
            picture = cv2.GaussianBlur(picture, (0, 0), appearance.blur)  # type: ignore[assignment]
        brightness, *tilt = appearance.drift * self._drift.at(seconds)
        tilt_x, tilt_y = (np.float32(t) for t in self._tilt + tilt)
        vignette = np.float32(appearance.vignette / 2)
        # Blur before light is the wrong order physically, but the light hardly changes over the width of the blur.
        across = np.float32(1 + brightness) + tilt_x * self._across - vignette * self._across**2
        down = tilt_y * self._down - vignette * self._down**2
        height, width = picture.shape
        row, column, mirrors = self._rng.integers(0, (_SPARE, _SPARE, 4)).tolist()
        noise = self._noise[row : row + height, column : column + width]
        noise = np.ascontiguousarray(noise[:: 1 - 2 * (mirrors & 1), :: 1 - (mirrors & 2)])
        return cv2.add((across + down) * picture, noise, dtype=cv2.CV_8U)  # type: ignore[return-value]


def _cable(start: Floats, marker: ImagePose, sag: float, full: float) -> Floats:
    """Points in pixels from the anchor to the middle of a marker; `sag` is that of the middle of a `full` length."""
    end = np.array((marker.x, marker.y))
    along = end - start
    length = math.hypot(*along)
    normal = np.array((-along[1], along[0])) / max(length, 1e-9)
    control = (start + end) / 2 + 2 * sag * min(1.0, length / full) * normal
    s = np.linspace(0, 1, _POINTS)[:, None]
    return (1 - s) ** 2 * start + 2 * s * (1 - s) * control + s**2 * end  # type: ignore[no-any-return]


def _robot_shapes(appearance: CameraAppearance, gripper: bool) -> tuple[Box | Disc, ...]:
    """Body and open gripper from above, lowest first."""
    gap = half_gap(JAW_OPEN)
    outer = gap + FINGER_THICKNESS
    return (
        Disc(RADIUS, appearance.body),
        Box(JAW_ROOT - 7.0, -outer, JAW_ROOT, outer, appearance.gripper),
        Box(JAW_ROOT, gap, FINGER_TIP, outer, appearance.gripper),
        Box(JAW_ROOT, -outer, FINGER_TIP, -gap, appearance.gripper),
    )[: None if gripper else 1]


def _marker_shapes(appearance: CameraAppearance, number: int, tracker: TrackerSettings) -> tuple[Box, ...]:
    """Frame, white sheet and holes of a marker, or sheet, square and white cells of a tag, whose top is the front."""
    white, black = appearance.white, appearance.black
    if tracker.markers != "tags":
        holes, side = ARRANGEMENTS[tracker.markers]
        length, width, frame, hole = MARKER_LENGTH / 2, MARKER_WIDTH / 2, MARKER_FRAME, side / 2
        return (
            Box(-length - frame, -width - frame, length + frame, width + frame, black),
            Box(-length, -width, length, width, white),
            *(Box(x - hole, y - hole, x + hole, y + hole, black) for x, y in holes[number]),
        )
    half, cell = tracker.tag_size / 2, tracker.tag_size / CELLS
    sheet = half + _TAG_MARGIN * cell
    return (
        Box(-sheet, -sheet, sheet, sheet, white),
        Box(-half, -half, half, half, black),
        *(
            Box(half - (row + 1) * cell, half - (column + 1) * cell, half - row * cell, half - column * cell, white)
            for row, column in white_cells(number)
        ),
    )


def _draw_floor(
    appearance: CameraAppearance, walls: Sequence[Wall], rng: np.random.Generator, size: tuple[int, int]
) -> Frame:
    """The empty floor with its walls, under full light."""
    shape, scale = (size[1], size[0]), size[0] / DEFAULT_SIZE[0]
    blotches = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), _BLOTCH_SIZE * scale)
    grain = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), 0.8)
    texture = appearance.texture * (0.85 * blotches / blotches.std() + 0.5 * grain / grain.std())
    wall_mask = np.zeros(shape, np.uint8)
    for x1, y1, x2, y2 in walls:
        length = math.hypot(x2 - x1, y2 - y1)
        if length > 0:
            half_length, half_width = length / 2, appearance.wall_width / 2
            pixels = scale / MM_PER_PIXEL
            middle = (x1 + x2) / 2 * pixels, (y1 + y2) / 2 * pixels
            pose = ImagePose(*middle, (x2 - x1) / length, (y2 - y1) / length, pixels)
            box = Box(-half_length - half_width, -half_width, half_length + half_width, half_width, 255)
            draw_shapes(wall_mask, pose, (box,))
    coverage = wall_mask.astype(np.float32) / 255
    shade = 1 - _SHADE * cv2.GaussianBlur(coverage, (0, 0), _SHADE_WIDTH * scale) if walls else 1.0
    floor = (appearance.floor + texture) * shade
    picture = floor + coverage * (appearance.wall + texture - floor)
    return np.asarray(picture).round().clip(0, 255).astype(np.uint8)


def draw_shapes(picture: Frame, pose: ImagePose, shapes: Sequence[Box | Disc]) -> None:
    """Draw the shapes of one object into a picture, lowest first; parts outside of the picture are left out."""
    reach = pose.scale * max(_reach(shape) for shape in shapes) + 1.0
    height, width = picture.shape
    row = height - pose.y
    left, right = max(0, math.floor(pose.x - reach)), min(width, math.ceil(pose.x + reach))
    top, bottom = max(0, math.floor(row - reach)), min(height, math.ceil(row + reach))
    if left >= right or top >= bottom:
        return
    patch = picture[top:bottom, left:right]
    size = ((right - left) * _SUPERSAMPLING, (bottom - top) * _SUPERSAMPLING)
    fine = cv2.resize(patch, size, interpolation=cv2.INTER_NEAREST)
    # OpenCV's integer coordinates are the middles of pixels, ours their lower left corners.
    origin = np.array([pose.x - left, row - top]) * _SUPERSAMPLING - 0.5
    for shape in shapes:
        if isinstance(shape, Disc):
            centre = np.round(origin * 2**_SHAPE_BITS).astype(int).tolist()
            radius = round((shape.radius * pose.scale - _GROWTH) * _SUPERSAMPLING * 2**_SHAPE_BITS)
            cv2.circle(fine, centre, radius, shape.grey, cv2.FILLED, cv2.LINE_8, _SHAPE_BITS)
        else:
            corners = origin + _SUPERSAMPLING * _corners(shape, pose, _GROWTH)
            fixed_point = np.round(corners * 2**_SHAPE_BITS).astype(np.int32)
            cv2.fillConvexPoly(fine, fixed_point, shape.grey, cv2.LINE_8, _SHAPE_BITS)
    cv2.resize(fine, (right - left, bottom - top), dst=patch, interpolation=cv2.INTER_AREA)
    picture[top:bottom, left:right] = patch


def draw_cable(
    picture: Frame, curve: Floats, width: float, grey: float, above: tuple[Box, ImagePose] | None = None
) -> None:
    """Draw one cable into a picture, below the marker `above` it.

    `curve` is n x 2 points in pixels, x to the right and y up; `width` is in pixels.
    """
    height, across = picture.shape
    points = np.column_stack((curve[:, 0], height - curve[:, 1])) - 0.5
    reach = math.ceil(width) + 2
    left, top = np.clip(np.floor(points.min(axis=0)) - reach, 0, (across, height)).astype(int).tolist()
    right, bottom = np.clip(np.ceil(points.max(axis=0)) + reach, 0, (across, height)).astype(int).tolist()
    if left >= right or top >= bottom:
        return
    near = np.zeros((bottom - top, right - left), np.uint8)
    line = np.round((points - (left, top)) * 2**_CABLE_BITS).astype(np.int32)
    cv2.polylines(near, [line], False, 255, reach, cv2.LINE_8, _CABLE_BITS)
    if above is not None:
        box, pose = above
        corners = _corners(box, pose) + np.array((pose.x - left, height - pose.y - top)) - 0.5
        cv2.fillConvexPoly(near, np.round(corners * 2**_CABLE_BITS).astype(np.int32), 0, cv2.LINE_8, _CABLE_BITS)
    rows, columns = near.nonzero()
    rows, columns = rows + top, columns + left
    share = _coverage(columns, rows, points, width)
    below = picture[rows, columns]
    picture[rows, columns] = np.rint(below + share * (grey - below)).astype(np.uint8)


def _corners(box: Box, pose: ImagePose, shrink: float = 0.0) -> Floats:
    """The corners of a box in the picture, from its origin: 4 x 2, columns and rows; it may shrink by some pixels."""
    x = np.array([box.x1, box.x2, box.x2, box.x1]) * pose.scale + shrink * np.array([1, -1, -1, 1])
    y = np.array([box.y1, box.y1, box.y2, box.y2]) * pose.scale + shrink * np.array([1, 1, -1, -1])
    return np.column_stack((x * pose.cos - y * pose.sin, -x * pose.sin - y * pose.cos))


def _reach(shape: Box | Disc) -> float:
    """Largest distance in mm of a point of the shape from the origin."""
    if isinstance(shape, Disc):
        return shape.radius
    return math.hypot(max(-shape.x1, shape.x2), max(-shape.y1, shape.y2))


def _coverage(columns: NDArray[np.int64], rows: NDArray[np.int64], line: Floats, width: float) -> Floats:
    """The share of each pixel that a line of some width in pixels covers; the line is m x 2 columns and rows."""
    starts, steps = line[:-1], np.diff(line, axis=0)
    squares = np.maximum((steps * steps).sum(axis=1), 1e-12)
    offset_x, offset_y = columns[:, None] - starts[:, 0], rows[:, None] - starts[:, 1]
    along = ((offset_x * steps[:, 0] + offset_y * steps[:, 1]) / squares).clip(0, 1)
    distances = (offset_x - along * steps[:, 0]) ** 2 + (offset_y - along * steps[:, 1]) ** 2
    # A pixel as a strip as wide as itself: exact for lines along rows and columns, and within 5 % for all others.
    edge = (width + 1) / 2 - np.sqrt(distances.min(axis=1))
    return edge.clip(0, min(1.0, width))  # type: ignore[no-any-return]
