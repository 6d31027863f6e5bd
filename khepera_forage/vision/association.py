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

from dataclasses import dataclass
from typing import Any, NamedTuple

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

    The cheapest pair of track and detection is matched first, then the next, until no pair is left. Slots of tracks are
    changed in place; `count` is the number of detections, and with `by_place` only places count, whatever the number of
    holes (3.5). Returns how many detections continue no track.
    """
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
            break
        tracks[chosen].detection = which
    new = count
    for track in tracks:
        shown = track.detection
        if shown >= 0:
            detection = detections[shown]
            track.x = detection.x
            track.y = detection.y
            track.holes = detection.holes
            track.found = True
            new -= 1
        else:
            track.found = False
    return new


def may_vanish(track: Any, by_place: bool) -> bool:
    """Whether a track is dropped if its last place is visible and empty: lost food, and by place a lost marker."""
    return track.label >= 0 and not track.found and (track.holes == 0 or by_place)


def start_tracks(tracks: Any, detections: Any, count: int, next_label: int) -> int:
    """Start a track for each detection that continues none, in reading order; returns the next label then.

    Without a free slot the oldest lost track makes way. That cannot happen with twice as many slots as regions, unless
    several last places of one food object are hidden at once.
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

    A track that was found until now is near its last place, within `GATE`, and one that has been lost for a while may
    be anywhere. So a lost track never takes the detection of a tracked region that passes its last place.
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
