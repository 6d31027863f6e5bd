"""The tracker: frames become detections; those that count become tracks, and these a scene (3.5).

`TrackedCamera` is the real overhead camera.
"""

import logging
import math
from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import TYPE_CHECKING

from khepera_forage.extras import require
from khepera_forage.robots.khepera import MARKER_WIDTH
from khepera_forage.vision.association import GATE, Detection, Track, match, may_vanish, start_tracks
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene, place_text
from khepera_forage.vision.shapes import Plate
from khepera_forage.vision.tracker_settings import TrackerSettings
from khepera_forage.vision.video import Frame, FrameSource, as_grey

if TYPE_CHECKING:
    from khepera_forage.vision.detection import Detector

__all__ = ["TrackedCamera", "Tracker", "TrackerSettings"]

_LOG = logging.getLogger(__name__)
_URGENT = ("camera moved", "tag twice", "tag size")
"""Warnings that are logged at once."""
_LASTING, _CHECK_INTERVAL = 5, 300
"""Frames after which the others are logged: half a second of rounds; and frames from one check of the picture's quality
to the next: half a minute."""

_MARKER_FRAMES, _FOOD_FRAMES = 3, 2
"""Consecutive frames that must agree before a marker, or food, is new, elsewhere, or reversed."""
_TURN = 60.0
"""Degrees by which a marker turns at most from one frame to the next: a Khepera turns by less than 20 in a round."""
_YOUNG, _LOST = 10, 5
"""A marker that was found in fewer frames is dropped when it has been lost for this many, half a second of rounds, and
its place has been empty."""
_OVERLAP = MARKER_WIDTH / MM_PER_PIXEL / 2
"""Pixels between the middles of two markers that no two robots can have."""


class Tracker:
    """Detects markers and food in frames, and tracks them.

    Frames have any size, that of the calibration, and are grey or in colour. Frames that show much more or less than
    5 mm of the floor in a pixel are resized to that. Bright shapes of a marker's size, with holes that some marker in
    use has, are markers, and discs of food's size with a sharp border are food.

    An uncertain shape is lost; it is never reported with a number that may be wrong, and `warnings` names the cause. A
    new region, or one that has jumped or is reversed, counts when two (food) or three (markers) consecutive frames
    agree on it, except in the first frame. Where a marker was lost, another counts only after the place has been empty.
    Food is dropped once its last place is inside the picture, clear of every marker, and has looked like floor in
    `settings.patience` consecutive frames.

    Not thread-safe.

    Args:
        settings: Sizes, thresholds, patience, and whether to track by features; None for the defaults.
        calibration: From the picture to the floor; None for `Calibration.identity()` at the size of the
            first frame.

    Raises:
        ImportError: OpenCV is not installed.
        ValueError: Markers or food are as high as the calibration's camera, or its pixels are too large for them.

    Attributes:
        settings: As given.
        calibration: As given.
        scene: The scene of the last frame; empty before the first.
        warnings: What the last frame does not show for certain, and is therefore not reported, by the name of the
            cause.
    """

    def __init__(self, settings: TrackerSettings | None = None, calibration: Calibration | None = None) -> None:
        require("the tracker", "camera")
        self.settings = settings or TrackerSettings()
        self.calibration = calibration or Calibration.identity()
        self.warnings: dict[str, str] = {}
        self._detector: Detector | None = None
        if calibration is not None:
            self._prepare(calibration)
        self.reset()

    def reset(self) -> None:
        """Forget every track; labels start at 0 again."""
        self.scene = Scene(())
        self._confirmation = Confirmation(by_place=self.settings.featureless)
        self._tracks = Tracks(by_place=self.settings.featureless)
        # Number of consecutive frames in which the floor was visible at the last place of lost food.
        self._visible: dict[tuple[float, float], int] = {}

    def detect(self, frame: Frame) -> list[Detection]:
        """The detections of one frame, in no particular order; no track changes.

        Args:
            frame: Grey levels, or blue, green and red, row 0 at the top.

        Raises:
            ValueError: A frame of another type, or of another size than the calibration's.
        """
        detector, grey = self._checked(frame)
        detections = detector.detect(grey, [(r.x, r.y) for r in self.scene.regions if r.holes])
        self.warnings = detector.warnings
        return detections

    def update(self, frame: Frame) -> Scene:
        """The scene after one more frame; arguments and errors as for `detect`."""
        shown = self.detect(frame)
        hidden, before, self._visible = self._hidden(shown), self._visible, {}
        plates = [_plate(marker) for marker in shown if marker.holes] + [_plate(marker) for marker in hidden]
        shows_floor = self._detector.shows_floor  # type: ignore[union-attr] # there is one now

        def visible(x: float, y: float) -> bool:
            if not shows_floor(plates, x, y):
                return False
            self._visible[x, y] = before.get((x, y), 0) + 1
            return self._visible[x, y] >= self.settings.patience

        detections, doomed = self._confirmation.check(shown, self.scene, hidden, partial(shows_floor, []))
        self.scene = self._tracks.update(detections, visible, doomed)
        for marker in shown:
            if marker.holes and marker not in detections:
                place = place_text(marker.x, marker.y)
                self.warnings["uncertain"] = (
                    f"marker {marker.holes} seems to be at {place}: it counts when three frames agree; if another "
                    "marker was lost there, also take it away for a moment"
                )
        for region in self.scene.regions:
            if region.holes and not region.found:
                place = place_text(region.x, region.y)
                self.warnings["lost"] = f"marker {region.holes} is not visible; it was last seen at {place}"
        return self.scene

    def reduced(self, frame: Frame) -> Frame:
        """The frame as grey levels of about 5 mm a pixel; errors as for `detect`."""
        detector, grey = self._checked(frame)
        return detector.reduced(grey)

    def _prepare(self, calibration: Calibration) -> "Detector":
        from khepera_forage.vision.detection import Detector

        self.calibration, self._detector = calibration, Detector(self.settings, calibration)
        return self._detector

    def _checked(self, frame: Frame) -> "tuple[Detector, Frame]":
        """The detector, and the frame as grey levels, of the calibration's size."""
        grey, detector = as_grey(frame), self._detector
        high, wide = grey.shape
        if detector is None:
            if min(high, wide) < 16:
                raise ValueError(f"frame is {wide} x {high}; allowed: at least 16 x 16")
            detector = self._prepare(Calibration.identity(size=(wide, high)))
        if (wide, high) != self.calibration.size:
            raise ValueError(
                f"frame is {wide} x {high}; allowed: {self.calibration.size[0]} x {self.calibration.size[1]}, as "
                "calibrated: set the camera to this size, or calibrate again"
            )
        return detector, grey

    def _hidden(self, detections: Sequence[Detection]) -> list[Region]:
        """Markers of the last scene that a frame does not show at their places, nor perhaps elsewhere."""
        if self.settings.featureless:
            return []  # a lost region may have been anything, or may have a new label
        hidden, markers = [], [r for r in self.scene.regions if r.holes]
        for region in markers:
            # Any marker with its number can be this region, if the frame shows all of them.
            same = [d for d in detections if d.holes == region.holes]
            all_shown = len(same) >= sum(r.holes == region.holes for r in markers)
            if not all_shown and all(_distance(d, region) > GATE for d in same):
                hidden.append(region)
        return hidden


class Confirmation:
    """Holds back what one bad frame shows: a new region, one that has jumped, a marker that is reversed.

    Such a detection counts when consecutive frames agree on it; in the first frame all count. What lasts may still be
    wrong: where one marker was lost, no other counts until the place has been empty. A marker that was found only a few
    times, and has left an empty place, is no marker.

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
        # Labels of lost markers whose last place has been empty.
        self._gone = set[int]()

    def check(
        self,
        detections: Sequence[Detection],
        scene: Scene,
        hidden: Sequence[Region],
        shows_floor: Callable[[float, float], bool],
    ) -> tuple[list[Detection], set[int]]:
        """The detections of a frame that count, and the labels of lost markers that are none.

        Args:
            detections: What the frame shows.
            scene: The scene before it.
            hidden: Markers of that scene that it does not show.
            shows_floor: Whether it shows the floor at a place (pixels).
        """
        regions = scene.regions
        found = self._found = {r.label: self._found.get(r.label, 0) + r.found for r in regions}
        lost = self._lost = {r.label: 0 if r.found else self._lost.get(r.label, 0) + 1 for r in regions}
        lost_markers = [r for r in regions if r.holes and not r.found]
        self._gone = {r.label for r in hidden if r.label in self._gone or shows_floor(r.x, r.y)}
        covered = [r for r in hidden if r.label not in self._gone]
        confirmed, candidates = [], []
        for detection in detections:
            frames = 1 + max((n for d, n in self._candidates if self._agree(d, detection, 1)), default=0)
            needed = _MARKER_FRAMES if detection.holes else _FOOD_FRAMES
            if not detection.holes and any(_distance(detection, r) < 2 * _OVERLAP for r in lost_markers):
                needed = _YOUNG  # it may be a part of the marker
            continues = any(self._agree(r, detection, 1 + lost[r.label]) for r in regions)
            in_sight = any(r.found and self._agree(r, detection, 1) for r in regions)
            misread = not in_sight and any(
                detection.holes not in (0, r.holes) and _distance(detection, r) < _OVERLAP for r in covered
            )
            if self._first or (not misread and (frames >= needed or continues)):
                confirmed.append(detection)
            else:
                candidates.append((detection, frames))
        self._first, self._candidates = False, candidates
        return confirmed, {
            r.label
            for r in lost_markers
            if (found[r.label] < _YOUNG and lost[r.label] >= _LOST and r.label in self._gone)
            or any(d.holes not in (0, r.holes) and _distance(d, r) < _OVERLAP for d in confirmed)
        }

    def _agree(self, one: Region | Detection, other: Detection, frames: int) -> bool:
        """Whether both may show the same thing, some frames apart."""
        turned = abs(math.remainder(one.orientation - other.orientation, 360))
        same = self._by_place or (one.holes == other.holes and turned <= _TURN * frames)
        return same and _distance(one, other) <= GATE * (frames if one.holes else 1)


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
        self._by_place, self._regions, self._next_label = by_place, list[Region](), 0

    def update(
        self, detections: Sequence[Detection], visible: Callable[[float, float], bool], doomed: Collection[int] = ()
    ) -> Scene:
        """The scene after one more frame.

        Args:
            detections: What the frame shows.
            visible: Whether food at a place (pixels) would have shown in this frame: inside the picture, under no
                marker, under no cable. Called only with last places of lost regions.
            doomed: Labels that are dropped if the frame does not show them.
        """
        # One order for any order in which the detections come.
        detections, count = sorted(detections), len(detections)
        tracks = [Track(r.label, r.x, r.y, r.holes, r.found) for r in self._regions]
        new = [Track() for _ in range(match(tracks, detections, count, self._by_place))]
        regions = []
        for track, region in zip(tracks, self._regions, strict=True):
            if track.detection >= 0:
                regions.append(_region(track.label, detections[track.detection]))
            elif track.label not in doomed and not (may_vanish(track, self._by_place) and visible(track.x, track.y)):
                regions.append(region._replace(found=False))
        self._next_label = start_tracks([*tracks, *new], detections, count, self._next_label)
        self._regions = regions + [_region(track.label, detections[track.detection]) for track in new]
        return Scene(tuple(self._regions))


class TrackedCamera:
    """A `Camera` that reports the regions which a `Tracker` finds in the frames of a `FrameSource`.

    The scene is empty before the first `reset` or `expose`. The first frame after a reset, and one frame every half
    minute, is checked by `measure_quality`; what is beyond its limit is logged as a warning, once. What the tracker is
    uncertain about is logged once in an episode.

    Args:
        source: Frame source; it is closed with the camera.
        tracker: A tracker that nothing else uses.
    """

    def __init__(self, source: FrameSource, tracker: Tracker) -> None:
        self._source, self._tracker = source, tracker
        self._until_check = 0
        self._warned: set[str] = set()
        self._lasted: dict[str, int] = {}
        self._logged: set[str] = set()

    def reset(self) -> None:
        """Forget all tracks, and take the first frame.

        Raises:
            CameraLost: The source has no more frames.
        """
        self._tracker.reset()
        self._until_check = 0
        self._lasted, self._logged = {}, set()
        self.expose()

    def expose(self) -> None:
        """Take the newest frame, once per round.

        Raises:
            CameraLost: The source has no more frames; `look` still returns the last scene.
        """
        frame, _ = self._source.newest()
        self._tracker.update(frame)
        # What the tracker is uncertain about is logged if it lasts or needs the user.
        found = self._tracker.warnings
        self._lasted = {name: self._lasted.get(name, 0) + 1 for name in found}
        for name, text in found.items():
            if name not in self._logged and (name in _URGENT or self._lasted[name] >= _LASTING):
                _LOG.warning("camera: %s", text)
                self._logged.add(name)
        self._until_check -= 1
        if self._until_check < 0:
            from khepera_forage.vision.image_quality import measure_quality

            self._until_check = _CHECK_INTERVAL
            found = measure_quality(self._tracker.reduced(frame)).warnings(self._tracker.settings)
            for name, text in found.items():
                if name not in self._warned:
                    _LOG.warning("camera picture %s", text)
            self._warned = set(found)

    def look(self) -> Scene:
        """The scene of the last frame; empty before the first."""
        return self._tracker.scene

    def close(self) -> None:
        """Close the source; a second call does nothing."""
        self._source.close()


def _distance(one: Region | Detection, other: Region | Detection) -> float:
    """Pixels between two regions."""
    return math.hypot(one.x - other.x, one.y - other.y)


def _plate(marker: Region | Detection) -> Plate:
    turn = math.radians(marker.orientation)
    return Plate(marker.x * MM_PER_PIXEL, marker.y * MM_PER_PIXEL, math.cos(turn), math.sin(turn))


def _region(label: int, detection: Detection) -> Region:
    x, y, holes, orientation, *rest = detection
    return Region(label, x, y, holes, orientation, True, *rest)  # type: ignore[arg-type] # mypy joins their types
