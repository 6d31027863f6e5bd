"""From the detections of frames to the scene: which of them count, the tracks, and when lost food is dropped (3.5)."""

import math
from collections.abc import Callable, Collection, Sequence

import numpy as np

from khepera_forage.robots.khepera import MARKER_WIDTH
from khepera_forage.vision.association import GATE, Detection, Track, match, may_vanish, start_tracks
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.segmentation import Segmentation
from khepera_forage.vision.shapes import Plate, under_plate
from khepera_forage.vision.tracker_settings import TrackerSettings

_MARKER_FRAMES, _FOOD_FRAMES = 3, 2
"""Consecutive frames that must agree before a marker, or food, is new, elsewhere, or reversed."""
_TURN = 60.0
"""Degrees by which a marker turns at most from one frame to the next: a Khepera turns by less than 20 in a round."""
_YOUNG, _LOST = 10, 5
"""A marker that was found in fewer frames is dropped when it has been lost for this many: half a second of rounds."""
_OVERLAP = MARKER_WIDTH / MM_PER_PIXEL / 2
"""Pixels between the middles of two markers that no two robots can have."""
_CLEARANCE = 13.0
"""Least distance in mm between the disc of food and a marker: the marker's black frame (8 mm), and a pixel of error."""
_FLOOR_TOLERANCE = 0.25
"""Share of the floor's brightness by which a pixel of floor may differ from it: noise, dirt, shade."""
_MIN_FLOOR_SHARE = 0.6
"""Least share of the disc's pixels that look like floor: a cable across the disc hides less, a robot's body more."""
_MAX_BRIGHT_SHARE = 0.1
"""Greatest share of bright pixels in the disc: more may be food, or a marker's rim over it."""


class Confirmation:
    """Holds back what one bad frame shows: a new region, one that has jumped, a marker that is reversed.

    Such a detection counts when consecutive frames agree on it; in the first frame all count. A marker that was found
    only a few times, or whose place another marker takes, is no marker: `doomed` names it.

    Args:
        by_place: As for `Tracks`.
    """

    def __init__(self, by_place: bool) -> None:
        self._by_place = by_place
        self._first = True
        # Detections that other frames must confirm, and the number of frames that showed each.
        self._candidates: list[tuple[Detection, int]] = []
        self._found: dict[int, int] = {}
        self._lost: dict[int, int] = {}

    def confirmed(self, detections: Sequence[Detection], scene: Scene) -> list[Detection]:
        """The detections of a frame that count, given the scene before it."""
        confirmed, candidates = [], []
        for detection in detections:
            frames = 1 + max((n for d, n in self._candidates if self._agree(d, detection)), default=0)
            if (
                self._first
                or any(self._continues(region, detection) for region in scene.regions)
                or frames >= _frames_needed(detection, scene)
            ):
                confirmed.append(detection)
            else:
                candidates.append((detection, frames))
        self._first, self._candidates = False, candidates
        return confirmed

    def count(self, scene: Scene) -> None:
        """Use the scene after a frame."""
        self._found = {r.label: self._found.get(r.label, 0) + r.found for r in scene.regions}
        self._lost = {r.label: 0 if r.found else self._lost.get(r.label, 0) + 1 for r in scene.regions}

    def doomed(self, detections: Sequence[Detection], scene: Scene) -> set[int]:
        """Labels of lost markers that are none, given the detections that count and the scene before them."""
        return {
            r.label
            for r in scene.regions
            if r.holes
            and (
                (self._found.get(r.label, 0) < _YOUNG and self._lost.get(r.label, 0) >= _LOST)
                or (
                    not r.found
                    and any(d.holes not in (0, r.holes) and _distance(d, r) < _OVERLAP for d in detections)
                )
            )
        }

    def _continues(self, region: Region, detection: Detection) -> bool:
        frames = 1 + self._lost.get(region.label, 0)
        return self._agree(region, detection, GATE * frames if region.holes else GATE, _TURN * frames)

    def _agree(
        self, one: Region | Detection, other: Detection, distance: float = GATE, turn: float = _TURN
    ) -> bool:
        turned = abs((one.orientation - other.orientation + 180) % 360 - 180)
        same = self._by_place or (one.holes == other.holes and turned <= turn)
        return same and _distance(one, other) <= distance


def _distance(one: Region | Detection, other: Region | Detection) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)


def _frames_needed(detection: Detection, scene: Scene) -> int:
    """Frames that must agree on a detection: more on food where a marker was lost, which may be a part of it."""
    if detection.holes:
        return _MARKER_FRAMES
    lost = (r for r in scene.regions if r.holes and not r.found)
    return _YOUNG if any(_distance(detection, r) < 2 * _OVERLAP for r in lost) else _FOOD_FRAMES


class Tracks:
    """The regions under observation, with labels that are never reused.

    The order in which a frame's detections come does not matter; new tracks are numbered in reading order.

    Args:
        by_place: Whether only places count, for markers without holes or with holes that cannot be told apart (3.5).
            The number of holes is then what the last frame showed. "There is no evidence that a redetected region
            corresponds to a previous lost one" (3.5): a region that reappears beyond `GATE` is another, and a lost
            marker is dropped as food is.
    """

    def __init__(self, by_place: bool = False) -> None:
        self._by_place = by_place
        self._tracks: list[Track] = []
        self._regions: list[Region] = []
        self._next_label = 0

    def update(
        self,
        detections: Sequence[Detection],
        visible: Callable[[float, float], bool],
        doomed: Collection[int] = (),
    ) -> Scene:
        """The scene after one more frame.

        Args:
            detections: What the frame shows.
            visible: Whether food at a place (pixels) would have shown in this frame: inside the picture, under no
                marker, under no cable. Called only with last places of lost regions.
            doomed: Labels that are dropped if the frame does not show them.
        """
        # One order for any order in which the detections come.
        detections = sorted(detections)
        new = match(self._tracks, detections, len(detections), self._by_place)
        kept: list[tuple[Track, Region]] = []
        for track, region in zip(self._tracks, self._regions, strict=True):
            if track.detection >= 0:
                kept.append((track, _region(track.label, detections[track.detection])))
            elif track.label not in doomed and not (
                may_vanish(track, self._by_place) and visible(track.x, track.y)
            ):
                kept.append((track, region._replace(found=False)))
        # Slots are filled in this order, so that the oldest track stays first.
        slots = [Track() for _ in range(new)]
        self._tracks = [track for track, _ in kept] + slots
        self._next_label = start_tracks(self._tracks, detections, len(detections), self._next_label)
        self._regions = [region for _, region in kept]
        self._regions += [_region(track.label, detections[track.detection]) for track in slots]
        return Scene(tuple(self._regions))


def _region(label: int, detection: Detection) -> Region:
    x, y, holes, orientation, *rest = detection
    return Region(label, x, y, holes, orientation, True, *rest)  # type: ignore[arg-type] # mypy joins their types


class FloorVisibility:
    """Counts, frame by frame, how long the floor has been visible at the last places of lost food (3.5)."""

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._settings, self._calibration = settings, calibration
        self._segmentation: Segmentation | None = None
        self._markers: list[Plate] = []
        # Number of consecutive frames in which the floor was visible, by place.
        self._counts: dict[tuple[float, float], int] = {}
        self._counts_before: dict[tuple[float, float], int] = {}

    def update(self, segmentation: Segmentation, detections: Sequence[Detection], scene: Scene) -> None:
        """Use a new frame and its detections; a lost marker of the scene before it hides its last place."""
        self._segmentation = segmentation
        self._counts_before, self._counts = self._counts, {}
        markers: list[Detection | Region] = [d for d in detections if d.holes > 0]
        # In featureless tracking a lost region may have been anything, or may have a new label.
        if not self._settings.featureless:
            markers += [r for r in scene.regions if r.holes > 0 and not _is_found(r, scene, detections)]
        self._markers = [
            Plate(
                m.x * MM_PER_PIXEL,
                m.y * MM_PER_PIXEL,
                math.cos(math.radians(m.orientation)),
                math.sin(math.radians(m.orientation)),
            )
            for m in markers
        ]

    def visible(self, x: float, y: float) -> bool:
        """Whether the floor is visible at a place (region coordinates), now and in the last `patience` frames.

        Call this once per frame and place: the frames of a place are counted by these calls.
        """
        if not self._shows_floor(x, y):
            return False
        self._counts[x, y] = count = self._counts_before.get((x, y), 0) + 1
        return count >= self._settings.patience

    def _shows_floor(self, x: float, y: float) -> bool:
        """Whether the disc of food at this place shows the floor in the newest frame."""
        assert self._segmentation is not None
        radius = self._settings.food_radius
        if under_plate(x * MM_PER_PIXEL, y * MM_PER_PIXEL, radius + _CLEARANCE, self._markers):
            return False
        u, v = self._calibration.to_picture(x, y, self._settings.food_height)
        unit = self._calibration.jacobian(u, v, self._settings.food_height).area
        reach = radius / MM_PER_PIXEL / math.sqrt(unit)
        rows, columns = self._segmentation.frame.shape
        if not (reach <= u <= columns - reach and reach <= v <= rows - reach):
            return False
        left, right = math.floor(u - reach), math.ceil(u + reach)
        top, bottom = math.floor(v - reach), math.ceil(v + reach)
        across, down = np.arange(left, right) + 0.5 - u, np.arange(top, bottom)[:, None] + 0.5 - v
        disc = across**2 + down**2 <= reach * reach
        grey = self._segmentation.frame[top:bottom, left:right][disc].astype(np.float64)
        bright = self._segmentation.mask[top:bottom, left:right][disc] > 0
        floor = self._segmentation.floor_at(math.floor(u), math.floor(v))
        like_floor = np.abs(grey - floor) <= _FLOOR_TOLERANCE * floor
        return bool(like_floor.mean() >= _MIN_FLOOR_SHARE and bright.mean() <= _MAX_BRIGHT_SHARE)


def _is_found(region: Region, scene: Scene, detections: Sequence[Detection]) -> bool:
    """Whether a detected marker can be this region of the last scene.

    Any marker with the same number of holes can be, if the frame shows all of them; otherwise only one within `GATE`.
    """
    same = [d for d in detections if d.holes == region.holes]
    return len(same) >= sum(r.holes == region.holes for r in scene.regions) or any(
        _distance(d, region) <= GATE for d in same
    )
