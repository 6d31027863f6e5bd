"""The tracks of a camera: detections in, the scene with its regions out (3.5)."""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

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


@dataclass(slots=True)
class _Candidate:
    """A detection that other frames must confirm, and the number of frames that showed it."""

    detection: Detection
    frames: int = 1


class Confirmation:
    """Holds back what one bad frame shows: a new region, one that has jumped, a marker that is reversed.

    Such a detection counts when consecutive frames agree on it; in the first frame all count. A marker that was found
    only a few times, or whose place another marker takes, is no marker: `doomed` names it.

    Args:
        by_place: As for `Tracks`.
    """

    def __init__(self, by_place: bool = False) -> None:
        self._by_place = by_place
        self.reset()

    def reset(self) -> None:
        """Forget everything; the next frame is the first."""
        self._first = True
        self._candidates: list[_Candidate] = []
        self._found: dict[int, int] = {}
        self._lost: dict[int, int] = {}

    def confirmed(self, detections: Sequence[Detection], scene: Scene) -> list[Detection]:
        """The detections of a frame that count.

        Args:
            detections: Of the frame.
            scene: Before the frame.
        """
        if self._first:
            self._first = False
            return list(detections)
        confirmed, candidates = [], []
        for detection in detections:
            if any(self._continues(region, detection) for region in scene.regions):
                confirmed.append(detection)
                continue
            before = [c for c in self._candidates if self._agree(c.detection, detection, GATE, _TURN)]
            candidate = _Candidate(detection, 1 + max((c.frames for c in before), default=0))
            if candidate.frames >= self._frames_needed(detection, scene):
                confirmed.append(detection)
            else:
                candidates.append(candidate)
        self._candidates = candidates
        return confirmed

    def count(self, scene: Scene) -> None:
        """Use the scene after a frame."""
        self._found = {r.label: self._found.get(r.label, 0) + r.found for r in scene.regions}
        self._lost = {r.label: 0 if r.found else self._lost.get(r.label, 0) + 1 for r in scene.regions}

    def doomed(self, detections: Sequence[Detection], scene: Scene) -> set[int]:
        """Labels of lost markers that are none, given the detections that count and the scene before them."""
        markers = [d for d in detections if d.holes]
        doomed = set()
        for region in scene.regions:
            if not region.holes:
                continue
            found, lost = self._found.get(region.label, 0), self._lost.get(region.label, 0)
            taken = not region.found and any(
                d.holes != region.holes and math.hypot(d.x - region.x, d.y - region.y) < _OVERLAP
                for d in markers
            )
            if taken or (found < _YOUNG and lost >= _LOST):
                doomed.add(region.label)
        return doomed

    def _frames_needed(self, detection: Detection, scene: Scene) -> int:
        """Frames that must agree on a detection: more on food where a marker was lost, which may be a part of it."""
        if detection.holes:
            return _MARKER_FRAMES
        lost = (r for r in scene.regions if r.holes and not r.found)
        near = any(math.hypot(detection.x - r.x, detection.y - r.y) < 2 * _OVERLAP for r in lost)
        return _YOUNG if near else _FOOD_FRAMES

    def _continues(self, region: Region, detection: Detection) -> bool:
        frames = 1 + self._lost.get(region.label, 0)
        return self._agree(region, detection, GATE * frames if region.holes else GATE, _TURN * frames)

    def _agree(self, one: Region | Detection, other: Detection, distance: float, turn: float) -> bool:
        if math.hypot(one.x - other.x, one.y - other.y) > distance:
            return False
        if self._by_place:
            return True
        turned = abs((one.orientation - other.orientation + 180) % 360 - 180)
        return one.holes == other.holes and turned <= turn


class Tracks:
    """The regions under observation, with labels that are never reused between two resets.

    The order in which a frame's detections come does not matter; new tracks are numbered in reading order.

    Args:
        by_place: Whether only places count, for markers without holes or with holes that cannot be told apart (3.5).
            The number of holes is then what the last frame showed. "There is no evidence that a redetected region
            corresponds to a previous lost one" (3.5): a region that reappears beyond `GATE` is another, and a lost
            marker is dropped as food is.
    """

    def __init__(self, by_place: bool = False) -> None:
        self._by_place = by_place
        self.reset()

    def reset(self) -> None:
        """Forget every track; labels start at 0 again."""
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
        tracks, regions = self._tracks, []
        new = match(tracks, detections, len(detections), self._by_place)
        for k, track in enumerate(tracks):
            if track.detection >= 0:
                # `_region`, written out, with the constructor of tuples: a named tuple's own takes twice as long, and
                # this is done for every region of every frame.
                x, y, holes, degrees, edge, left, top, area, outline, compactness = detections[
                    track.detection
                ]
                label = track.label
                region = tuple.__new__(
                    Region, (label, x, y, holes, degrees, True, edge, left, top, area, outline, compactness)
                )
            elif track.label in doomed or (may_vanish(track, self._by_place) and visible(track.x, track.y)):
                track.label = -1
                continue
            else:
                region = self._regions[k]
                if region.found:
                    region = region._replace(found=False)
            regions.append(region)
        if len(regions) < len(tracks):
            self._tracks = tracks = [track for track in tracks if track.label >= 0]
        if new:
            # Slots are filled in this order, so that the oldest track stays first.
            slots = [Track() for _ in range(new)]
            tracks += slots
            self._next_label = start_tracks(tracks, detections, len(detections), self._next_label)
            regions += [_region(track.label, detections[track.detection]) for track in slots]
        self._regions = regions
        return tuple.__new__(Scene, (tuple(regions),))


def _region(label: int, detection: Detection) -> Region:
    x, y, holes, orientation, edge, first_x, first_y, area, perimeter, compactness = detection
    return Region(label, x, y, holes, orientation, True, edge, first_x, first_y, area, perimeter, compactness)
