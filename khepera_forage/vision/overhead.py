"""The simulated overhead camera: true poses become regions, with the troubles of sections 3.5 and 3.7."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_WIDTH
from khepera_forage.vision.retracking import Detection, Tracks
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene
from khepera_forage.vision.shapes import (
    FOOD_FEATURES,
    FOOD_RADIUS_PX,
    MARKER_FEATURES,
    Plate,
    distance_to_segment,
    in_picture,
    marker_extent,
    marker_top,
    under_plate,
)

_SURE = 5.0
"""Standard deviations of jitter by which a place must be clear of a marker to count as visible."""


class Truth(NamedTuple):
    """Where everything under the camera really is.

    Attributes:
        markers: For each robot x and y of its centre in mm, its heading in radians, and its marker's holes (1 or 2).
        foods: Centre of each food object in mm, hidden ones included.
    """

    markers: tuple[tuple[float, float, float, int], ...]
    foods: tuple[tuple[float, float], ...]


class OverheadCamera:
    """A camera that sees what a world says is there, as badly as the thesis' camera saw it.

    The picture is 640 x 480 pixels of 5 mm, its lower left corner at (0, 0) mm. One frame is taken each round.

    - *Jitter.* A region's centre is off by a normal error in x and in y, a marker's orientation by one in degrees,
      rounded to whole degrees. First pixel and edge flag follow the reported centre; area, perimeter and
      compactness are those of the whole shape.
    - *Reversal.* Now and then, in single frames, an orientation is reported the wrong way round (4.2.2).
    - *Losses.* Now and then the tracker does not see a region for a while: a two-hole marker more often than a
      one-hole one (3.5), and any region more often under a cable (3.7). How long is geometrically distributed.
      Nothing is lost in the first frame after a reset: an operator starts when everything is tracked.
    - *Cables.* Each robot's cable is a straight line from the overhead anchor to the middle of its own marker, which
      it does not disturb. It lies over food when it passes over the disc, and over another robot's marker when it
      passes within half the marker's width of its centre.
    - *Hiding.* Food whose disc touches a marker is not seen, whether or not that marker is itself lost. A region
      whose centre is outside the picture is not seen.

    What was seen becomes tracks by the rule of `retracking`. A place is visible to that rule when food lying there
    would be inside the picture, clear of every marker by five standard deviations of the jitter (a last place is
    only known that well: with less, food just gone under the rim of a marker is taken for vanished), and clear of
    food that is under a loss (whatever hides that also hides the floor around it).

    Every random number comes from a generator spawned at the reset, and every frame uses the same count of them
    whatever is hidden or lost: the same seed gives the same scenes, bit for bit, and one size of noise can be
    changed without shifting the draws of another.

    Args:
        truth: Called once a frame. The numbers of markers and foods stay the same between two resets.
        noise: Sizes and rates. With `Noise.none()` the scene is exact but for hiding, and for orientations, which
            are whole degrees.
        anchor: Where the cables hang from, in mm as seen from above; None hangs no cables.
    """

    def __init__(
        self, truth: Callable[[], Truth], noise: Noise, anchor: tuple[float, float] | None = None
    ) -> None:
        self._truth = truth
        self._noise = noise
        self._anchor = anchor
        self._tracks = Tracks()
        self._scene = Scene(())
        self._draws: _Draws | None = None
        self._plates: list[Plate] = []
        self._lost: list[bool] = []
        self._lost_foods: list[tuple[float, float]] = []

    def reset(self, rng: np.random.Generator) -> None:
        """Forget all tracks and losses, and take the first frame, with random numbers of its own."""
        truth = self._truth()
        self._draws = _Draws(rng.spawn(1)[0])
        self._tracks.reset()
        self._lost = [False] * (len(truth.markers) + len(truth.foods))
        self._take_frame(truth, self._draws)

    def expose(self) -> None:
        """Take the frame of this round.

        Raises:
            RuntimeError: The camera was never reset.
        """
        if self._draws is None:
            raise RuntimeError("expose() before the first reset(rng); allowed: after it")
        truth = self._truth()
        self._lose(truth, self._draws)
        self._take_frame(truth, self._draws)

    def look(self) -> Scene:
        """The scene of the last frame; empty before the first."""
        return self._scene

    def _lose(self, truth: Truth, draws: "_Draws") -> None:
        """Losses end and begin."""
        noise, markers = self._noise, len(truth.markers)
        for i, chance in enumerate(draws.uniforms(len(self._lost))):
            if self._lost[i]:
                self._lost[i] = chance >= 1 / noise.loss_rounds
                continue
            if i >= markers:
                rate = noise.loss_rate_food
            else:
                rate = noise.loss_rate_one_hole if truth.markers[i][3] == 1 else noise.loss_rate_two_holes
            # Few draws are so low that a cable could matter, and only those are worth looking for one.
            if chance < rate * noise.cable_loss_factor:
                self._lost[i] = chance < rate or self._under_cable(truth, i)

    def _under_cable(self, truth: Truth, i: int) -> bool:
        """Whether another region's cable passes over region `i`, counted through markers and then foods."""
        if self._anchor is None:
            return False
        markers = len(truth.markers)
        x, y = truth.markers[i][:2] if i < markers else truth.foods[i - markers]
        reach = MARKER_WIDTH / 2 if i < markers else FOOD_RADIUS
        return any(
            j != i and distance_to_segment(x, y, *self._anchor, marker[0], marker[1]) <= reach
            for j, marker in enumerate(truth.markers)
        )

    def _take_frame(self, truth: Truth, draws: "_Draws") -> None:
        markers, foods = truth
        count = len(markers)
        self._plates = [Plate(x, y, math.cos(heading), math.sin(heading)) for x, y, heading, _ in markers]
        self._lost_foods = [food for food, lost in zip(foods, self._lost[count:], strict=True) if lost]
        normals = draws.normals(3 * count + 2 * len(foods))
        uniforms = draws.uniforms(count)
        detections = []
        for i, plate in enumerate(self._plates):
            if not self._lost[i] and in_picture(plate.x / MM_PER_PIXEL, plate.y / MM_PER_PIXEL):
                detections.append(self._marker(markers[i], plate, normals[3 * i : 3 * i + 3], uniforms[i]))
        at = 3 * count
        for i, (x, y) in enumerate(foods, count):
            if not self._lost[i] and not under_plate(x, y, FOOD_RADIUS, self._plates):
                x, y = x / MM_PER_PIXEL, y / MM_PER_PIXEL
                if in_picture(x, y):
                    detections.append(self._food(x, y, normals[at], normals[at + 1]))
            at += 2
        self._scene = self._tracks.update(detections, self._visible)

    def _marker(
        self, marker: tuple[float, float, float, int], plate: Plate, errors: list[float], chance: float
    ) -> Detection:
        noise, (x, y, heading, holes) = self._noise, marker
        x = x / MM_PER_PIXEL + noise.position_jitter * errors[0]
        y = y / MM_PER_PIXEL + noise.position_jitter * errors[1]
        degrees = math.degrees(heading) + noise.heading_jitter * errors[2]
        if chance < noise.reversal_rate:
            degrees += 180.0
        half_width, half_height = marker_extent(plate.cos, plate.sin)
        edge = not in_picture(x, y, half_width, half_height)
        first_x, first_y = marker_top(plate.cos, plate.sin)
        return Detection(
            x, y, holes, round(degrees) % 360, edge, x + first_x, y + first_y, *MARKER_FEATURES[holes]
        )  # fmt: skip

    def _food(self, x: float, y: float, error_x: float, error_y: float) -> Detection:
        x += self._noise.position_jitter * error_x
        y += self._noise.position_jitter * error_y
        edge = not in_picture(x, y, FOOD_RADIUS_PX, FOOD_RADIUS_PX)
        return Detection(x, y, 0, 0, edge, x, y + FOOD_RADIUS_PX, *FOOD_FEATURES)

    def _visible(self, x: float, y: float) -> bool:
        """Whether food at a place (pixels) would have shown in this frame."""
        if not in_picture(x, y):
            return False
        x, y = x * MM_PER_PIXEL, y * MM_PER_PIXEL
        clear = FOOD_RADIUS + _SURE * self._noise.position_jitter * MM_PER_PIXEL
        return not under_plate(x, y, clear, self._plates) and all(
            math.hypot(x - food_x, y - food_y) > 2 * FOOD_RADIUS for food_x, food_y in self._lost_foods
        )


class _Draws:
    """Random numbers in blocks: one call for many frames, so that the cost of the call is small."""

    _BLOCK = 512

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._normals: list[float] = []
        self._uniforms: list[float] = []

    def normals(self, count: int) -> list[float]:
        """The next standard normal numbers."""
        if len(self._normals) < count:
            self._normals = self._rng.standard_normal(max(count, self._BLOCK)).tolist()
        taken = self._normals[:count]
        del self._normals[:count]
        return taken

    def uniforms(self, count: int) -> list[float]:
        """The next numbers from 0 (included) to 1 (excluded)."""
        if len(self._uniforms) < count:
            self._uniforms = self._rng.random(max(count, self._BLOCK)).tolist()
        taken = self._uniforms[:count]
        del self._uniforms[:count]
        return taken
