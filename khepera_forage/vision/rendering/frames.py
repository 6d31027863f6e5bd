"""The overhead camera's picture of a simulated world: grey frames for the real tracker to find its regions in."""

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
from khepera_forage.vision.rendering.appearance import CameraLook
from khepera_forage.vision.rendering.cables import Cables
from khepera_forage.vision.rendering.canvas import Box, Disc, Place, draw, pixels
from khepera_forage.vision.rendering.light import Light
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import (
    HOLE_SIDE,
    MARKER_FRAME,
    MARKER_HOLES,
    PICTURE_HEIGHT,
    PICTURE_WIDTH,
)
from khepera_forage.vision.simulated_camera import Truth

__all__ = ["CameraLook", "FrameRenderer", "RenderedSource", "marker_parts"]

_ROBOT_HEIGHT = 45.0
"""mm of the body with the gripper turret: what parallax shifts it by."""
_SHEET = Box(
    -MARKER_LENGTH / 2 - MARKER_FRAME,
    -MARKER_WIDTH / 2 - MARKER_FRAME,
    MARKER_LENGTH / 2 + MARKER_FRAME,
    MARKER_WIDTH / 2 + MARKER_FRAME,
    0.0,
)
_SHADE, _SHADE_WIDTH = 0.35, 4.0
"""By what share a wall darkens the floor at its foot, and over how many pixels."""
_BLOTCH = 9.0
"""Standard deviation in pixels of the blur that makes the floor's blotches."""

Wall = tuple[float, float, float, float]


class FrameRenderer:
    """Frames of 640 x 480 grey pixels, 5 mm each on the floor, whose lower left corner is (0, 0) mm.

    Seen are the floor and its walls, white food, the robots' dark bodies and grippers under their markers
    (white, 120 x 80 mm, black holes and frame), and over it all the cables; then come light, lens, sensor and
    grabber. Food under a marker is drawn, and covered. The gripper is drawn lowered and open: what is dark
    on the floor makes no region.

    Edges are smooth and true to a fiftieth of a pixel before the light falls on them. A frame stands for one
    moment: nothing is smeared by motion (a robot drives 3 mm in the 20 ms of a frame).

    The same seed and the same truths give the same frames, bit for bit.

    Args:
        truth: Where everything is, called once a frame. The number of markers stays the same between two resets.
        look: Intensities and troubles.
        anchor: Where the cables hang from, in mm as seen from above; None hangs no cables.
        walls: Segments (x1, y1, x2, y2) in mm, as of `Arena.segments`.
        period: Seconds from one frame to the next, in which light and cables move.
    """

    def __init__(
        self,
        truth: Callable[[], Truth],
        look: CameraLook | None = None,
        anchor: tuple[float, float] | None = None,
        *,
        walls: Sequence[Wall] = (),
        period: float = CONTROL_PERIOD,
    ) -> None:
        if not (math.isfinite(period) and period >= 0):
            raise ValueError(f"period of frames is {period!r} s; allowed: a finite number >= 0")
        self._truth = truth
        self._look = look = CameraLook.laboratory() if look is None else look
        self._anchor = anchor
        self._walls = tuple(walls)
        self._period = period
        self._frames = 0
        self._light: Light | None = None
        self._cables: Cables | None = None
        self._floor = np.empty((0, 0), np.uint8)
        self._robot = _robot(look)
        self._markers = {holes: marker_parts(look, places) for holes, places in MARKER_HOLES.items()}
        self._food = (Disc(FOOD_RADIUS, look.white),)

    def reset(self, rng: np.random.Generator) -> None:
        """Begin anew at time zero: another floor, other light, other cables; `rng` only spawns others."""
        floor, light, cables = rng.spawn(3)
        self._frames = 0
        self._floor = _floor(self._look, self._walls, floor)
        self._light = Light(self._look, light)
        self._cables = None
        if self._anchor is not None and self._look.cable_width > 0:
            self._cables = Cables(self._look, self._anchor, cables, len(self._truth().markers))

    def frame(self) -> NDArray[np.uint8]:
        """The picture of this moment, 480 x 640; row 0 is the top (largest y).

        Raises:
            RuntimeError: Never reset.
        """
        if self._light is None:
            raise RuntimeError("frame() before any reset(rng); allowed: after one")
        seconds = self._frames * self._period
        self._frames += 1
        picture = self._floor.copy()
        markers, foods = self._truth()
        for x, y in foods:
            draw(picture, self._place(x, y, 0.0, FOOD_HEIGHT), self._food)
        sheets = []
        for x, y, heading, _ in markers:
            draw(picture, self._place(x, y, heading, _ROBOT_HEIGHT), self._robot)
        for x, y, heading, holes in markers:
            sheets.append(self._place(x, y, heading, self._look.marker_height))
            draw(picture, sheets[-1], self._markers[holes])
        if self._cables is not None:
            self._cables.draw(picture, sheets, _SHEET, seconds)
        return self._light.expose(picture, seconds)

    @property
    def cables(self) -> list[NDArray[np.float64]]:
        """Where each robot's cable hung in the newest frame; empty without cables.

        Each is n x 2 points from the anchor to the middle of the marker, under which its end is hidden: pixels, x
        to the right and y up.
        """
        return [] if self._cables is None else [curve.copy() for curve in self._cables.curves]

    def _place(self, x: float, y: float, heading: float, height: float) -> Place:
        """Where a thing of this height shows."""
        column, row = pixels(x, y)
        nearer = 1.0
        if self._look.height is not None:
            nearer = self._look.height / (self._look.height - height)
            column = PICTURE_WIDTH / 2 + (column - PICTURE_WIDTH / 2) * nearer
            row = PICTURE_HEIGHT / 2 + (row - PICTURE_HEIGHT / 2) * nearer
        return Place(column, row, math.cos(heading), math.sin(heading), nearer / MM_PER_PIXEL)


class RenderedSource:
    """A `FrameSource` whose newest frame is always of this moment.

    Args:
        renderer: After its reset.
    """

    def __init__(self, renderer: FrameRenderer) -> None:
        self._renderer = renderer

    def newest(self) -> tuple[NDArray[np.uint8], float]:
        """A frame rendered now, and its age: 0 s."""
        return self._renderer.frame(), 0.0

    def close(self) -> None:
        """Nothing to let go of."""


def _robot(look: CameraLook) -> tuple[Box | Disc, ...]:
    """Body and open gripper, from above."""
    gap = half_gap(JAW_OPEN)
    wide = gap + FINGER_THICKNESS
    return (
        Disc(RADIUS, look.body),
        Box(JAW_ROOT - 7.0, -wide, JAW_ROOT, wide, look.gripper),
        Box(JAW_ROOT, gap, FINGER_TIP, wide, look.gripper),
        Box(JAW_ROOT, -wide, FINGER_TIP, -gap, look.gripper),
    )


def marker_parts(look: CameraLook, holes: Iterable[tuple[float, float]]) -> tuple[Box, ...]:
    """Frame, white sheet and holes of a marker, lowest first, for `frame_pen.draw`.

    Args:
        look: Grey levels.
        holes: Their centres in mm in the marker's own frame.
    """
    half = HOLE_SIDE / 2
    return (
        _SHEET._replace(grey=look.black),
        Box(-MARKER_LENGTH / 2, -MARKER_WIDTH / 2, MARKER_LENGTH / 2, MARKER_WIDTH / 2, look.white),
        *(Box(x - half, y - half, x + half, y + half, look.black) for x, y in holes),
    )


def _floor(look: CameraLook, walls: Sequence[Wall], rng: np.random.Generator) -> NDArray[np.uint8]:
    """The empty floor with its walls, under full light."""
    shape = (int(PICTURE_HEIGHT), int(PICTURE_WIDTH))
    blotches = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), _BLOTCH)
    grain = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), 0.8)
    texture = look.texture * (0.85 * blotches / blotches.std() + 0.5 * grain / grain.std())
    boards = np.zeros(shape, np.uint8)
    for x1, y1, x2, y2 in walls:
        length = math.hypot(x2 - x1, y2 - y1)
        if length > 0:
            half, wide = length / 2, look.wall_width / 2
            place = Place(
                *pixels((x1 + x2) / 2, (y1 + y2) / 2),
                (x2 - x1) / length,
                (y2 - y1) / length,
                1 / MM_PER_PIXEL,
            )
            draw(boards, place, (Box(-half - wide, -wide, half + wide, wide, 255),))
    board = boards.astype(np.float32) / 255
    shade = 1 - _SHADE * cv2.GaussianBlur(board, (0, 0), _SHADE_WIDTH) if walls else 1.0
    floor = (look.floor + texture) * shade
    whole: NDArray[np.float32] = floor + board * (look.wall + texture - floor)
    return whole.round().clip(0, 255).astype(np.uint8)
