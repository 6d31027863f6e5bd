"""From the detections of frames to the scene: which of them count, the tracks, and when lost food is dropped (3.5)."""

import math
from collections.abc import Callable, Collection, Sequence

from khepera_forage.robots.khepera import MARKER_WIDTH
from khepera_forage.vision.association import GATE, Detection, Track, match, may_vanish, start_tracks
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene

_MARKER_FRAMES, _FOOD_FRAMES = 3, 2
"""Consecutive frames that must agree before a marker, or food, is new, elsewhere, or reversed."""
_TURN = 60.0
"""Degrees by which a marker turns at most from one frame to the next: a Khepera turns by less than 20 in a round."""
_YOUNG, _LOST = 10, 5
"""A marker that was found in fewer frames is dropped when it has been lost for this many: half a second of rounds."""
_OVERLAP = MARKER_WIDTH / MM_PER_PIXEL / 2
"""Pixels between the middles of two markers that no two robots can have."""


class Confirmation:
    """Holds back what one bad frame shows: a new region, one that has jumped, a marker that is reversed.

    Such a detection counts when consecutive frames agree on it; in the first frame all count. A marker that was found
    only a few times, or whose place another marker takes, is no marker: `doomed` names it.

    Args:
        by_place: As for `Tracks`.
    """

    def __init__(self, by_place: bool) -> None:
        self._by_place, self._first = by_place, True
        # Detections that other frames must confirm, and the number of frames that showed each.
        self._candidates: list[tuple[Detection, int]] = []
        # Frames in which a region was found, and those since it was lost, by its label.
        self._found: dict[int, int] = {}
        self._lost: dict[int, int] = {}

    def confirmed(self, detections: Sequence[Detection], scene: Scene) -> list[Detection]:
        """The detections of a frame that count, given the scene before it."""
        confirmed, candidates = [], []
        lost_markers = [r for r in scene.regions if r.holes and not r.found]
        for detection in detections:
            frames = 1 + max((n for d, n in self._candidates if self._agree(d, detection)), default=0)
            needed = _MARKER_FRAMES if detection.holes else _FOOD_FRAMES
            if not detection.holes and any(distance(detection, r) < 2 * _OVERLAP for r in lost_markers):
                needed = _YOUNG  # it may be a part of the marker
            if self._first or frames >= needed or any(self._continues(r, detection) for r in scene.regions):
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
                (self._found[r.label] < _YOUNG and self._lost[r.label] >= _LOST)
                or (
                    not r.found
                    and any(d.holes not in (0, r.holes) and distance(d, r) < _OVERLAP for d in detections)
                )
            )
        }

    def _continues(self, region: Region, detection: Detection) -> bool:
        frames = 1 + self._lost[region.label]
        return self._agree(region, detection, GATE * frames if region.holes else GATE, _TURN * frames)

    def _agree(
        self, one: Region | Detection, other: Detection, gate: float = GATE, turn: float = _TURN
    ) -> bool:
        turned = abs(math.remainder(one.orientation - other.orientation, 360))
        same = self._by_place or (one.holes == other.holes and turned <= turn)
        return same and distance(one, other) <= gate


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


def distance(one: Region | Detection, other: Region | Detection) -> float:
    """Pixels between two regions."""
    return math.hypot(one.x - other.x, one.y - other.y)


def _region(label: int, detection: Detection) -> Region:
    x, y, holes, orientation, *rest = detection
    return Region(label, x, y, holes, orientation, True, *rest)  # type: ignore[arg-type] # mypy joins their types
