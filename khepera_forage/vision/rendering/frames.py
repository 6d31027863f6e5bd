"""Rendered frames: what the overhead camera would show of a simulated world, as input for the real tracker."""

import math
from collections.abc import Callable, Iterable, Sequence

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
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.drawing import Box, Disc, ImagePose, draw_cable, draw_shapes, to_pixels
from khepera_forage.vision.scene import MM_PER_PIXEL, Truth
from khepera_forage.vision.shapes import (
    HOLE_SIDE,
    MARKER_FRAME,
    MARKER_HOLES,
    PICTURE_HEIGHT,
    PICTURE_WIDTH,
)

_ROBOT_HEIGHT = 45.0
"""Height in mm of the body with the gripper turret, for its parallax."""
_SHEET = Box(
    -MARKER_LENGTH / 2 - MARKER_FRAME,
    -MARKER_WIDTH / 2 - MARKER_FRAME,
    MARKER_LENGTH / 2 + MARKER_FRAME,
    MARKER_WIDTH / 2 + MARKER_FRAME,
    0.0,
)
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
_POINTS = 24
"""Points on the polyline that approximates a cable."""

_SHAPE = (int(PICTURE_HEIGHT), int(PICTURE_WIDTH))

Wall = tuple[float, float, float, float]


class FrameRenderer:
    """Renders frames of 640 x 480 grey pixels, 5 mm each on the floor, whose lower left corner is (0, 0) mm.

    A frame shows, from bottom to top: the floor and its walls, white food, the robots' dark bodies and grippers,
    their markers (white, 120 x 80 mm, with black holes and frame) and the cables. Light, lens, sensor and frame
    grabber then disturb the picture. Food under a marker is drawn and covered. Grippers are always drawn lowered and
    open: dark shapes on the floor make no region.

    Edges are exact to a fiftieth of a pixel before light and noise. A frame shows one instant, without motion blur (a
    robot drives 3 mm in the 20 ms of a frame).

    The same seed and the same truths give the same frames, bit for bit.

    Args:
        truth: Gives all true poses, called once a frame. The number of markers stays the same between two resets.
        appearance: Intensities and disturbances; None for those of the laboratory.
        anchor: Where the cables hang from, in mm as seen from above; None draws no cables.
        walls: Segments (x1, y1, x2, y2) in mm, as in `Arena.segments`.
        period: Seconds from one frame to the next, in which light and cables move.

    Raises:
        ValueError: A period that is negative or not finite.
    """

    def __init__(
        self,
        truth: Callable[[], Truth],
        appearance: CameraAppearance | None = None,
        anchor: tuple[float, float] | None = None,
        *,
        walls: Sequence[Wall] = (),
        period: float = CONTROL_PERIOD,
    ) -> None:
        if not (math.isfinite(period) and period >= 0):
            raise ValueError(f"period of frames is {period!r} s; allowed: a finite number >= 0")
        self._truth = truth
        self._appearance = CameraAppearance.laboratory() if appearance is None else appearance
        self._anchor = anchor
        self._walls = tuple(walls)
        self._period = period
        self._frames = 0
        self._light: Light | None = None
        self._sway: SlowNoise | None = None
        self._curves: list[NDArray[np.float64]] = []
        self._robot = _robot_shapes(self._appearance)
        self._markers = {
            holes: marker_shapes(self._appearance, centres) for holes, centres in MARKER_HOLES.items()
        }
        self._food = (Disc(FOOD_RADIUS, self._appearance.white),)

    def reset(self, rng: np.random.Generator) -> None:
        """Restart at time zero with another floor, other light and other cables.

        Args:
            rng: Only used to spawn other generators.
        """
        floor, light, cables = rng.spawn(3)
        self._frames = 0
        self._floor = _draw_floor(self._appearance, self._walls, floor)
        self._light = Light(self._appearance, light)
        self._sway, self._curves = None, []
        if self._anchor is not None and self._appearance.cable_width > 0:
            robots = len(self._truth().markers)
            self._sway = SlowNoise(cables, robots, _SWAY_PERIOD)
            self._sides = cables.choice((-1.0, 1.0), robots)

    def frame(self) -> NDArray[np.uint8]:
        """The next frame, 480 x 640; row 0 is the top (largest y).

        Raises:
            RuntimeError: The renderer was never reset.
        """
        if self._light is None:
            raise RuntimeError("frame() before any reset(rng); allowed: after one")
        seconds = self._frames * self._period
        self._frames += 1
        truth = self._truth()
        picture = self._drawn(truth)
        if self._sway is not None:
            self._draw_cables(picture, truth, self._sway.at(seconds))
        return self._light.expose(picture, seconds)

    def picture(self) -> NDArray[np.uint8]:
        """Floor, food, robots and markers under full, even light: a frame without cables, lens and sensor.

        Raises:
            RuntimeError: The renderer was never reset.
        """
        if self._light is None:
            raise RuntimeError("picture() before any reset(rng); allowed: after one")
        return self._drawn(self._truth())

    def _drawn(self, truth: Truth) -> NDArray[np.uint8]:
        picture = self._floor.copy()
        for x, y in truth.foods:
            draw_shapes(picture, self._image_pose(x, y, 0.0, FOOD_HEIGHT), self._food)
        for x, y, heading, _ in truth.markers:
            draw_shapes(picture, self._image_pose(x, y, heading, _ROBOT_HEIGHT), self._robot)
        for x, y, heading, holes in truth.markers:
            pose = self._image_pose(x, y, heading, self._appearance.marker_height)
            draw_shapes(picture, pose, self._markers[holes])
        return picture

    def _draw_cables(self, picture: NDArray[np.uint8], truth: Truth, sway: NDArray[np.float64]) -> None:
        """Draw a cable from the overhead anchor to each robot.

        A cable enters its robot under the marker, for the plug is on the robot. It therefore covers other markers and
        food, but never its own robot's marker. Seen from above it is a quadratic curve whose middle sways.
        """
        assert self._anchor is not None
        appearance, start = self._appearance, np.array(to_pixels(*self._anchor))
        sags = (appearance.cable_sag * self._sides + appearance.cable_sway * sway) / MM_PER_PIXEL
        poses = [
            self._image_pose(x, y, heading, appearance.marker_height) for x, y, heading, _ in truth.markers
        ]
        self._curves = [_cable(start, pose, float(sag)) for pose, sag in zip(poses, sags, strict=True)]
        for pose, curve in zip(poses, self._curves, strict=True):
            width = appearance.cable_width / MM_PER_PIXEL
            draw_cable(picture, curve, width, appearance.cable, (_SHEET, pose))

    @property
    def cables(self) -> list[NDArray[np.float64]]:
        """Each robot's cable in the newest frame; empty without cables.

        Each is n x 2 points in pixels, x right and y up, from the anchor to the middle of the marker, which hides the
        end of the cable.
        """
        return [curve.copy() for curve in self._curves]

    def _image_pose(self, x: float, y: float, heading: float, height: float) -> ImagePose:
        """Pose in the picture of an object in mm, shifted by the parallax of its height."""
        column, row = to_pixels(x, y)
        magnification = 1.0
        if self._appearance.height is not None:
            magnification = self._appearance.height / (self._appearance.height - height)
            column = PICTURE_WIDTH / 2 + (column - PICTURE_WIDTH / 2) * magnification
            row = PICTURE_HEIGHT / 2 + (row - PICTURE_HEIGHT / 2) * magnification
        return ImagePose(column, row, math.cos(heading), math.sin(heading), magnification / MM_PER_PIXEL)


class SlowNoise:
    """Independent random signals, each the mean of three sine waves with random phases, and periods around one in s."""

    def __init__(self, rng: np.random.Generator, count: int, period: float) -> None:
        self._rates = 2 * np.pi / (period * rng.uniform(*_PERIODS, (count, _WAVES)))
        self._phases = rng.uniform(0, 2 * np.pi, (count, _WAVES))

    def at(self, seconds: float) -> NDArray[np.float64]:
        """The signals at a time: mean 0, within -1..1, with a standard deviation of 0.41."""
        return np.sin(self._rates * seconds + self._phases).mean(axis=1)  # type: ignore[no-any-return]


class Light:
    """Uneven and slowly varying light, blur, noise and quantisation.

    The light is a slowly tilting plane minus a paraboloid (the vignette). The noise is normal and independent from
    pixel to pixel. For speed it is drawn once, and each frame uses a randomly shifted and mirrored part of it.
    """

    def __init__(self, appearance: CameraAppearance, rng: np.random.Generator) -> None:
        drift, self._rng = rng.spawn(2)
        self._appearance = appearance
        self._drift = SlowNoise(drift, 3, _DRIFT_PERIOD)
        tilt = drift.uniform(-1, 1, 2)
        self._tilt = tilt * appearance.gradient / max(1e-9, float(np.abs(tilt).max()))
        height, width = _SHAPE
        self._across = np.linspace(-1, 1, width, dtype=np.float32)
        self._down = np.linspace(-1, 1, height, dtype=np.float32)[:, None]
        noise = self._rng.standard_normal((height + _SPARE, width + _SPARE), dtype=np.float32)
        self._noise = np.float32(appearance.grain) * noise

    def expose(self, picture: NDArray[np.uint8], seconds: float) -> NDArray[np.uint8]:
        """The frame that the camera takes of a 480 x 640 picture under full, even light, some time after the reset."""
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


class RenderedFrameSource:
    """A `FrameSource` that renders a new frame at every call.

    Args:
        renderer: After its reset.
    """

    def __init__(self, renderer: FrameRenderer) -> None:
        self._renderer = renderer

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        """A frame rendered now, and its age: 0 s."""
        return self._renderer.frame(), 0.0

    def close(self) -> None:
        """Do nothing: there is no device to release."""


def _cable(start: NDArray[np.float64], marker: ImagePose, sag: float) -> NDArray[np.float64]:
    """Points in pixels from the anchor to the middle of a marker; `sag` is the signed distance of the middle."""
    end = np.array((marker.x, marker.y))
    along = end - start
    length = math.hypot(*along)
    normal = np.array((-along[1], along[0])) / max(length, 1e-9)
    control = (start + end) / 2 + 2 * sag * min(1.0, length * MM_PER_PIXEL / _FULL_SAG_LENGTH) * normal
    s = np.linspace(0, 1, _POINTS)[:, None]
    return (1 - s) ** 2 * start + 2 * s * (1 - s) * control + s**2 * end  # type: ignore[no-any-return]


def _robot_shapes(appearance: CameraAppearance) -> tuple[Box | Disc, ...]:
    """Body and open gripper from above, lowest first."""
    gap = half_gap(JAW_OPEN)
    outer = gap + FINGER_THICKNESS
    return (
        Disc(RADIUS, appearance.body),
        Box(JAW_ROOT - 7.0, -outer, JAW_ROOT, outer, appearance.gripper),
        Box(JAW_ROOT, gap, FINGER_TIP, outer, appearance.gripper),
        Box(JAW_ROOT, -outer, FINGER_TIP, -gap, appearance.gripper),
    )


def marker_shapes(appearance: CameraAppearance, holes: Iterable[tuple[float, float]]) -> tuple[Box, ...]:
    """Frame, white sheet and holes (centres in mm in the marker's own frame) of a marker, lowest first."""
    half = HOLE_SIDE / 2
    return (
        _SHEET._replace(grey=appearance.black),
        Box(-MARKER_LENGTH / 2, -MARKER_WIDTH / 2, MARKER_LENGTH / 2, MARKER_WIDTH / 2, appearance.white),
        *(Box(x - half, y - half, x + half, y + half, appearance.black) for x, y in holes),
    )


def _draw_floor(
    appearance: CameraAppearance, walls: Sequence[Wall], rng: np.random.Generator
) -> NDArray[np.uint8]:
    """The empty floor with its walls, under full light."""
    blotches = cv2.GaussianBlur(rng.standard_normal(_SHAPE, dtype=np.float32), (0, 0), _BLOTCH_SIZE)
    grain = cv2.GaussianBlur(rng.standard_normal(_SHAPE, dtype=np.float32), (0, 0), 0.8)
    texture = appearance.texture * (0.85 * blotches / blotches.std() + 0.5 * grain / grain.std())
    wall_mask = np.zeros(_SHAPE, np.uint8)
    for x1, y1, x2, y2 in walls:
        length = math.hypot(x2 - x1, y2 - y1)
        if length > 0:
            half_length, half_width = length / 2, appearance.wall_width / 2
            pose = ImagePose(
                *to_pixels((x1 + x2) / 2, (y1 + y2) / 2),
                (x2 - x1) / length,
                (y2 - y1) / length,
                1 / MM_PER_PIXEL,
            )
            box = Box(-half_length - half_width, -half_width, half_length + half_width, half_width, 255)
            draw_shapes(wall_mask, pose, (box,))
    coverage = wall_mask.astype(np.float32) / 255
    shade = 1 - _SHADE * cv2.GaussianBlur(coverage, (0, 0), _SHADE_WIDTH) if walls else 1.0
    floor = (appearance.floor + texture) * shade
    picture = floor + coverage * (appearance.wall + texture - floor)
    return np.asarray(picture).round().clip(0, 255).astype(np.uint8)
