"""Rendered frames: what the overhead camera would show of a simulated world, as input for the real tracker."""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

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
from khepera_forage.vision.rendering.cables import Cables
from khepera_forage.vision.rendering.canvas import Box, Disc, ImagePose, draw_shapes, to_pixels
from khepera_forage.vision.rendering.light import Light
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
        self._cables: Cables | None = None
        self._floor = np.empty((0, 0), np.uint8)
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
        self._cables = None
        if self._anchor is not None and self._appearance.cable_width > 0:
            self._cables = Cables(self._appearance, self._anchor, cables, len(self._truth().markers))

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
        if self._cables is not None:
            poses = [
                self._image_pose(x, y, heading, self._appearance.marker_height)
                for x, y, heading, _ in truth.markers
            ]
            self._cables.draw(picture, poses, _SHEET, seconds)
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

    @property
    def cables(self) -> list[NDArray[np.float64]]:
        """Each robot's cable in the newest frame; empty without cables.

        Each is n x 2 points in pixels, x right and y up, from the anchor to the middle of the marker, which hides the
        end of the cable.
        """
        return [] if self._cables is None else [curve.copy() for curve in self._cables.curves]

    def _image_pose(self, x: float, y: float, heading: float, height: float) -> ImagePose:
        """Pose in the picture of an object in mm, shifted by the parallax of its height."""
        column, row = to_pixels(x, y)
        magnification = 1.0
        if self._appearance.height is not None:
            magnification = self._appearance.height / (self._appearance.height - height)
            column = PICTURE_WIDTH / 2 + (column - PICTURE_WIDTH / 2) * magnification
            row = PICTURE_HEIGHT / 2 + (row - PICTURE_HEIGHT / 2) * magnification
        return ImagePose(column, row, math.cos(heading), math.sin(heading), magnification / MM_PER_PIXEL)


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
    """Frame, white sheet and holes of a marker, lowest first, for `canvas.draw_shapes`.

    Args:
        appearance: Grey levels.
        holes: Centres of the holes in mm in the marker's own frame.
    """
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
    shape = (int(PICTURE_HEIGHT), int(PICTURE_WIDTH))
    blotches = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), _BLOTCH_SIZE)
    grain = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), 0.8)
    texture = appearance.texture * (0.85 * blotches / blotches.std() + 0.5 * grain / grain.std())
    wall_mask = np.zeros(shape, np.uint8)
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
    picture: NDArray[np.floating[Any]] = floor + coverage * (appearance.wall + texture - floor)
    return picture.round().clip(0, 255).astype(np.uint8)
