"""Data association: which detection of a new frame continues which track (3.5).

Tracking is feature-based, and the only feature is the number of holes, as in the thesis. What the thesis leaves open
is decided here, once for real frames, simulated frames and compiled worlds:

- A region that a frame does not show is lost: it keeps everything it was last seen with.
- Lost food is dropped at the first frame in which its last place is visible and empty. Markers are never dropped: a
  robot does not vanish.
- A detection continues a track with its number of holes. Food must lie within `GATE` of the track's last place. A
  marker may be anywhere, so that the only one of its kind is recognised however far it was carried.
- Where several tracks could be continued, the cheapest pair by `association_cost` comes first, and among equal costs
  the nearest pair.
- A detection that continues no track starts a new one.

The functions take *records*: objects with the fields of `Track` and `Detection`. In Python these are a slotted
dataclass and a named tuple, in compiled code records of numpy arrays.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from khepera_forage.vision.scene import Region, Scene

GATE = 6.0
"""Distance in pixels within which a region may be found again, unless it is a marker that may be anywhere.

Decision: 30 mm is more than the 20 mm that a robot drives or pushes in a round, with jitter on top, and less than the
35 mm between the centres of two touching food objects, so that one is not taken for the other.
"""

_GATE_SQUARED = GATE * GATE

FORBIDDEN = 3
"""Association cost of a pair that must not be associated."""


class Detection(NamedTuple):
    """What one frame shows of one region: the attributes of `Region` that need no memory."""

    x: float
    y: float
    holes: int
    orientation: int
    edge: bool
    first_x: float
    first_y: float
    area: float
    perimeter: float
    compactness: float


@dataclass(slots=True)
class Track:
    """One region under observation, or a free slot.

    Attributes:
        label: Number of the track; -1 in a free slot.
        x: Last place in pixels.
        y: Last place in pixels.
        holes: 0 for food, 1 or 2 for markers.
        found: Whether the last frame showed it; otherwise it is lost.
        detection: Index of the detection that showed it in the last frame; -1 without one.
    """

    label: int = -1
    x: float = 0.0
    y: float = 0.0
    holes: int = 0
    found: bool = False
    detection: int = -1


def match(tracks: Any, detections: Any, count: int, by_place: bool) -> int:
    """Continue tracks with the detections of a frame; tracks that continue with none are lost.

    Args:
        tracks: Slots of `Track` records; changed in place.
        detections: `Detection` records.
        count: How many of them the frame has.
        by_place: Whether only places count, whatever the number of holes (markers without readable holes, 3.5).

    Returns:
        How many detections continue no track.
    """
    if not _match_obvious(tracks, detections, count, by_place):
        _match_by_cost(tracks, detections, count, by_place)
    new = count
    for track in tracks:
        shown = track.detection
        if shown >= 0:
            detection = detections[shown]
            track.x, track.y, track.holes, track.found = detection.x, detection.y, detection.holes, True
            new -= 1
        else:
            track.found = False
    return new


def may_vanish(track: Any, by_place: bool) -> bool:
    """Whether a track is dropped if its last place is visible and empty: lost food, never a marker.

    Args:
        track: A `Track` record.
        by_place: As for `match`; a lost marker is then dropped as food is.
    """
    return track.label >= 0 and not track.found and (track.holes == 0 or by_place)


def start_tracks(tracks: Any, detections: Any, count: int, next_label: int) -> int:
    """Start a track for each detection that continues none, in reading order.

    Without a free slot the oldest lost track makes way. That cannot happen with twice as many slots as regions, unless
    several last places of one food object are hidden at once.

    Args:
        tracks: Slots of `Track` records; changed in place.
        detections: `Detection` records.
        count: How many of them the frame has.
        next_label: Label of the next new track.

    Returns:
        The label of the next new track then.
    """
    while True:
        first = -1
        for j in range(count):
            new = not _is_shown(tracks, j)
            if new and (first < 0 or _reads_before(detections[j], detections[first])):
                first = j
        if first < 0:
            return next_label
        slot = _slot_for_new_track(tracks)
        if slot < 0:
            return next_label
        track = tracks[slot]
        detection = detections[first]
        track.label, track.detection = next_label, first
        track.x, track.y, track.holes, track.found = detection.x, detection.y, detection.holes, True
        next_label += 1


def association_cost(track: Any, detection: Any, near: bool, by_place: bool) -> int:
    """Cost of continuing a track with a detection: 0 is best, `FORBIDDEN` is never done.

    A track that was found until now is near its last place, and one that has been lost for a while may be anywhere. So
    a lost track never takes the detection of a tracked region that passes its last place.

    Args:
        track: A `Track` record.
        detection: A `Detection` record.
        near: Whether the two are within `GATE`.
        by_place: As for `match`.
    """
    if by_place:
        if not near:
            return FORBIDDEN
        return 0 if track.found else 1
    if track.holes != detection.holes or (track.holes == 0 and not near):
        return FORBIDDEN
    if not track.found:
        return 1
    return 0 if near else 2


def _match_obvious(tracks: Any, detections: Any, count: int, by_place: bool) -> bool:
    """Match the frame if every detection is near exactly one track of its kind, and each near another.

    Nearly all frames are like this, and the general rule then has the same result.

    Returns:
        Whether it was such a frame.
    """
    for track in tracks:
        track.detection = -1
    for j in range(count):
        detection = detections[j]
        x, y, holes = detection.x, detection.y, detection.holes
        near, only = 0, -1
        for k in range(len(tracks)):
            track = tracks[k]
            if track.label >= 0 and (track.holes == holes or by_place):
                dx, dy = track.x - x, track.y - y
                if dx * dx + dy * dy <= _GATE_SQUARED:
                    near, only = near + 1, k
        if near != 1 or tracks[only].detection >= 0:
            return False
        tracks[only].detection = j
    return True


def _match_by_cost(tracks: Any, detections: Any, count: int, by_place: bool) -> None:
    """Match the cheapest pair of track and detection first, then the next, until no pair is left."""
    for track in tracks:
        track.detection = -1
    while True:
        chosen, which, least, nearest = -1, -1, FORBIDDEN, 0.0
        for k in range(len(tracks)):
            track = tracks[k]
            if track.label < 0 or track.detection >= 0:
                continue
            for j in range(count):
                if _is_shown(tracks, j):
                    continue
                detection = detections[j]
                dx, dy = track.x - detection.x, track.y - detection.y
                squared = dx * dx + dy * dy
                cost = association_cost(track, detection, squared <= _GATE_SQUARED, by_place)
                if cost == FORBIDDEN or cost > least:
                    continue
                tie = chosen >= 0 and cost == least and squared == nearest
                if tie and track.label == tracks[chosen].label:
                    better = _reads_before(detection, detections[which])
                elif tie:
                    better = track.label < tracks[chosen].label
                else:
                    better = cost < least or squared < nearest
                if better:
                    chosen, which, least, nearest = k, j, cost, squared
        if chosen < 0:
            return
        tracks[chosen].detection = which


def _is_shown(tracks: Any, detection: int) -> bool:
    """Whether a track continues with this detection."""
    for track in tracks:  # noqa: SIM110 (numba compiles no generator expressions)
        if track.label >= 0 and track.detection == detection:
            return True
    return False


def _reads_before(one: Any, other: Any) -> bool:
    """Whether one detection's first pixel comes before another's in reading order: higher, then further left."""
    if one.first_y != other.first_y:
        return bool(one.first_y > other.first_y)
    return bool(one.first_x < other.first_x)


def _slot_for_new_track(tracks: Any) -> int:
    """A free slot, otherwise that of the oldest lost track; -1 if every track is found."""
    oldest = -1
    for k in range(len(tracks)):
        track = tracks[k]
        if track.label < 0:
            return k
        if not track.found and (oldest < 0 or track.label < tracks[oldest].label):
            oldest = k
    return oldest


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

    def update(self, detections: Sequence[Detection], visible: Callable[[float, float], bool]) -> Scene:
        """The scene after one more frame.

        Args:
            detections: What the frame shows.
            visible: Whether food at a place (pixels) would have shown in this frame: inside the picture, under no
                marker, under no cable. Called only with last places of lost regions.
        """
        # One order for any order in which the detections come.
        detections = sorted(detections)
        new = match(self._tracks, detections, len(detections), self._by_place)
        tracks, regions = [], []
        for track, region in zip(self._tracks, self._regions, strict=True):
            if track.detection >= 0:
                region = _region(track.label, detections[track.detection])
            elif may_vanish(track, self._by_place) and visible(track.x, track.y):
                continue
            elif region.found:
                region = region._replace(found=False)
            tracks.append(track)
            regions.append(region)
        if new:
            # Slots are filled in this order, so that the oldest track stays first.
            slots = [Track() for _ in range(new)]
            tracks += slots
            self._next_label = start_tracks(tracks, detections, len(detections), self._next_label)
            regions += [_region(track.label, detections[track.detection]) for track in slots]
        self._tracks, self._regions = tracks, regions
        return Scene(tuple(regions))


def _region(label: int, detection: Detection) -> Region:
    x, y, holes, orientation, edge, first_x, first_y, area, perimeter, compactness = detection
    return Region(label, x, y, holes, orientation, True, edge, first_x, first_y, area, perimeter, compactness)
