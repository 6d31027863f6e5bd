"""The simulated overhead camera: true poses become regions, with the troubles of sections 3.5 and 3.7."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_WIDTH
from khepera_forage.vision.association import Detection
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene
from khepera_forage.vision.shapes import (
    FOOD_FEATURES,
    FOOD_RADIUS_PX,
    MARKER_FEATURES,
    Plate,
    distance_to_segment,
    in_picture,
    marker_outline,
    shows_beside_lost_food,
    under_plate,
    visible_clearance,
)
from khepera_forage.vision.tracks import Tracks

_BLOCK = 64
"""Frames for which random numbers are drawn at a time."""


_Marker = tuple[float, float, float, int]


class Truth(NamedTuple):
    """Where everything under the camera really is.

    Attributes:
        markers: For each robot x and y of its centre in mm, its heading in radians, and the number of holes
            in its marker (1 or 2).
        foods: Centre of each food object in mm, hidden ones included.
    """

    markers: tuple[_Marker, ...]
    foods: tuple[tuple[float, float], ...]


class OverheadCamera:
    """A camera that sees what a world says is there, as badly as the thesis's camera saw it.

    The picture is 640 x 480 pixels of 5 mm, its lower left corner at (0, 0) mm. It is taken once a round.

    - *Jitter.* A region's centre is off by a normal error in x and in y, a marker's orientation by one in
      degrees; it is then rounded to whole degrees. First pixel and edge flag follow the reported centre;
      area, perimeter and compactness are those of the whole shape.
    - *Reversal.* Now and then, in single frames, an orientation is reported the wrong way round (4.2.2).
    - *Losses.* Now and then the tracker does not see a region for a while: a two-hole marker more often than
      a one-hole one (3.5), any region more often under a cable (3.7). How long is geometrically distributed.
      Nothing is lost in the first frame after a reset: an operator starts when everything is tracked.
    - *Cables.* Each robot's cable is a straight line from the overhead anchor to the middle of its own
      marker, which it does not disturb. It lies over food when it passes over the disc, and over the marker
      of another robot when it passes within half the marker's width of its centre.
    - *Hiding.* Food whose disc touches a marker is not seen, whether or not that marker is itself lost. A
      region whose centre is outside the picture is not seen.

    What was seen becomes tracks by the rule of `retracking`. A place is visible to that rule when food lying
    there would be clear of every marker by five standard deviations of the jitter (no last place is known
    better: with less, food just gone under the rim of a marker is taken for vanished) and would not touch
    food that is under a loss (whatever hides that also hides the floor around it).

    Every random number comes from a generator spawned at the reset, and every frame uses the same count of
    them whatever is hidden or lost: the same seed gives the same scenes, bit for bit, and one size of noise
    can be changed without shifting the draws of another.

    Args:
        truth: Called once a frame. The numbers of markers and foods stay the same between two resets.
        noise: Sizes and rates. With `Noise.none()` the scene is exact, but food is still hidden by markers,
            and orientations are still whole degrees.
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
        self._rng: np.random.Generator | None = None
        # Rows of numbers, one a frame, taken from the end.
        self._normals: list[list[float]] = []  # x, y and heading a marker, x and y a food
        self._chances: list[list[float]] = []  # losses of all, then reversals of markers
        self._plates: list[Plate] = []
        self._lost: list[bool] = []  # under a loss: markers, then foods
        self._loss_rates: list[tuple[float, float]] = []  # the same way, without and with a cable over it
        self._lost_foods: list[tuple[float, float]] = []
        self._worst_rate = 0.0

    def reset(self, rng: np.random.Generator) -> None:
        """Forget all tracks and losses, and take the first frame; `rng` only spawns another."""
        self._rng = rng.spawn(1)[0]
        self._normals, self._chances = [], []
        self._tracks.reset()
        truth, noise = self._truth(), self._noise
        rates = [noise.loss_rate_one_hole if m[3] == 1 else noise.loss_rate_two_holes for m in truth.markers]
        rates += [noise.loss_rate_food] * len(truth.foods)
        self._loss_rates = [(rate, rate * noise.cable_loss_factor) for rate in rates]
        self._worst_rate = max(rates, default=0.0) * noise.cable_loss_factor
        self._lost = [False] * len(rates)
        self._take_frame(truth, *self._draw(truth))

    def expose(self) -> None:
        """Take the frame of this round.

        Raises:
            RuntimeError: The camera was never reset.
        """
        truth = self._truth()
        normals, chances = self._draw(truth)
        # In nearly every frame no loss goes on, and none can begin.
        if True in self._lost or (chances and min(chances) < self._worst_rate):
            self._lose(truth, chances)
        self._take_frame(truth, normals, chances)

    def look(self) -> Scene:
        """The scene of the last frame; empty before the first."""
        return self._scene

    def _draw(self, truth: Truth) -> tuple[list[float], list[float]]:
        """The random numbers of one frame, normal and uniform."""
        if not self._normals:
            if self._rng is None:
                raise RuntimeError("expose() before any reset(rng); allowed: after one")
            markers, foods = len(truth.markers), len(truth.foods)
            self._normals = self._rng.standard_normal((_BLOCK, 3 * markers + 2 * foods)).tolist()
            self._chances = self._rng.random((_BLOCK, 2 * markers + foods)).tolist()
        return self._normals.pop(), self._chances.pop()

    def _lose(self, truth: Truth, chances: list[float]) -> None:
        """End and begin losses."""
        lost = self._lost
        for i, (rate, rate_under_cable) in enumerate(self._loss_rates):
            chance = chances[i]
            if lost[i]:
                lost[i] = chance >= 1.0 / self._noise.loss_rounds
            elif chance < rate_under_cable:  # so seldom that only then a cable is looked for
                lost[i] = chance < rate or self._under_cable(truth, i)

    def _under_cable(self, truth: Truth, i: int) -> bool:
        """Whether a cable passes over region `i`, counted through markers and then foods."""
        if self._anchor is None:
            return False
        markers = len(truth.markers)
        x, y = truth.markers[i][:2] if i < markers else truth.foods[i - markers]
        reach = MARKER_WIDTH / 2 if i < markers else FOOD_RADIUS
        return any(
            j != i and distance_to_segment(x, y, *self._anchor, marker[0], marker[1]) <= reach
            for j, marker in enumerate(truth.markers)
        )

    def _take_frame(self, truth: Truth, normals: list[float], chances: list[float]) -> None:
        markers, foods = truth
        count, lost = len(markers), self._lost
        plates: list[Plate] = []
        self._plates = plates
        if True in lost:
            self._lost_foods = [food for i, food in enumerate(foods, count) if lost[i]]
        elif self._lost_foods:
            self._lost_foods = []
        seen = []
        edge = False
        for i, marker in enumerate(markers):
            x, y, heading, _ = marker
            plate = tuple.__new__(Plate, (x, y, math.cos(heading), math.sin(heading)))
            plates.append(plate)
            if not lost[i]:
                shown = self._marker(marker, plate, normals, 3 * i, chances[len(lost) + i])
                edge = edge or shown.edge
                seen.append(shown)
        for i, (x, y) in enumerate(foods, count):
            if not lost[i] and not under_plate(x, y, FOOD_RADIUS, plates):
                shown = self._food(x, y, normals, count + 2 * i)
                edge = edge or shown.edge
                seen.append(shown)
        if edge:  # What touches the edge may lie outside as a whole.
            seen = [d for d in seen if not d.edge or in_picture(d.x, d.y)]
        self._scene = self._tracks.update(seen, self._visible)

    def _marker(
        self, marker: _Marker, plate: Plate, normals: list[float], at: int, chance: float
    ) -> Detection:
        noise, (x, y, heading, holes) = self._noise, marker
        x = x / MM_PER_PIXEL + noise.position_jitter * normals[at]
        y = y / MM_PER_PIXEL + noise.position_jitter * normals[at + 1]
        degrees = math.degrees(heading) + noise.heading_jitter * normals[at + 2]
        if chance < noise.reversal_rate:
            degrees += 180.0
        half_width, half_height, first = marker_outline(plate.cos, plate.sin)
        edge = not in_picture(x, y, half_width, half_height)
        area, perimeter, compactness = MARKER_FEATURES[holes]
        angle = round(degrees) % 360
        # The constructor of tuples: a named tuple's own takes twice as long, and this is done in every frame.
        return tuple.__new__(
            Detection, (x, y, holes, angle, edge, x + first, y + half_height, area, perimeter, compactness)
        )

    def _food(self, x: float, y: float, normals: list[float], at: int) -> Detection:
        x = x / MM_PER_PIXEL + self._noise.position_jitter * normals[at]
        y = y / MM_PER_PIXEL + self._noise.position_jitter * normals[at + 1]
        edge = not in_picture(x, y, FOOD_RADIUS_PX, FOOD_RADIUS_PX)
        return tuple.__new__(Detection, (x, y, 0, 0, edge, x, y + FOOD_RADIUS_PX, *FOOD_FEATURES))

    def _visible(self, x: float, y: float) -> bool:
        """Whether food at a place in the picture (pixels) would have shown in this frame."""
        x, y = x * MM_PER_PIXEL, y * MM_PER_PIXEL
        clearance = visible_clearance(self._noise.position_jitter)
        return not under_plate(x, y, clearance, self._plates) and all(
            shows_beside_lost_food(x, y, food_x, food_y) for food_x, food_y in self._lost_foods
        )
