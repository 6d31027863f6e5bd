"""The rule of retracking: what one frame shows becomes tracked regions (3.5).

Tracking is feature-based, and the only feature is the number of holes, as in the thesis. What the thesis
leaves open is decided here, once for simulated and for real frames:

- A region that a frame does not show is lost: it keeps all it was last seen with.
- Lost food is dropped at the first frame in which its last place can be seen and it is not there. Markers are
  never dropped: a robot does not vanish.
- A detection continues a track with its number of holes. Food must lie within `GATE` of the track's last
  place. A marker may be anywhere, so that the only one of its kind is known again however far it was carried.
- Where several tracks could be meant, those tracked until now and near by come first, then lost ones, then
  markers that would have jumped; within each of these the nearest pair comes first.
- What continues no track starts a new one.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from khepera_forage.vision.scene import Region, Scene

GATE = 6.0
"""How far in pixels a region may come to lie from its last place, unless it is a marker that may be anywhere.

Our decision: 30 mm is more than the 20 mm that a robot drives or pushes in a round, with jitter on top, and
less than the 35 mm between the centres of two touching food objects, so that one is not taken for the other.
"""

_GATE_SQUARED = GATE * GATE

_Rank = Callable[[Region, "Detection", bool], int | None]


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


class Tracks:
    """The regions under observation, with labels that are never reused between two resets.

    The order in which a frame's detections come does not matter; new tracks are numbered in reading order.
    """

    def __init__(self) -> None:
        self._regions: list[Region] = []
        self._next_label = 0

    def reset(self) -> None:
        """Forget every track; labels start at 0 again."""
        self._regions = []
        self._next_label = 0

    def update(self, detections: Sequence[Detection], visible: Callable[[float, float], bool]) -> Scene:
        """The scene after one more frame.

        Args:
            detections: What the frame shows.
            visible: Whether food at a place (pixels) would have shown in this frame: inside the picture,
                under no marker, under no cable. Asked only about last places of food that is not shown.
        """
        shown = _obvious(self._regions, detections)
        started: list[Detection] = []
        if shown is None:
            shown, started = _assigned(self._regions, detections, _rank)
        regions = []
        for region, detection in zip(self._regions, shown, strict=True):
            if detection is not None:
                regions.append(_tracked(region.label, detection))
            elif region.holes > 0 or not visible(region.x, region.y):
                regions.append(region._replace(found=False) if region.found else region)
        for detection in started:
            regions.append(_tracked(self._next_label, detection))
            self._next_label += 1
        self._regions = regions
        return Scene(tuple(regions))


class FeaturelessTracks:
    """The same by place alone, for markers without holes or holes that cannot be told apart (3.5).

    A detection continues the nearest track within `GATE`, whatever its number of holes; tracked ones come before lost
    ones. The number of holes is then what the last frame showed. "There is no evidence that a redetected region
    corresponds to a previous lost one" (3.5): a region that reappears further off is another, and every lost region is
    dropped once its last place can be seen and is empty, a marker's like food's.
    """

    def __init__(self) -> None:
        self._regions: list[Region] = []
        self._next_label = 0

    def reset(self) -> None:
        """Forget every track; labels start at 0 again."""
        self._regions = []
        self._next_label = 0

    def update(self, detections: Sequence[Detection], visible: Callable[[float, float], bool]) -> Scene:
        """The scene after one more frame; arguments as of `Tracks.update`."""
        shown, started = _assigned(self._regions, detections, _rank_by_place)
        regions = []
        for region, detection in zip(self._regions, shown, strict=True):
            if detection is not None:
                regions.append(_tracked(region.label, detection))
            elif not visible(region.x, region.y):
                regions.append(region._replace(found=False) if region.found else region)
        for detection in started:
            regions.append(_tracked(self._next_label, detection))
            self._next_label += 1
        self._regions = regions
        return Scene(tuple(regions))


def _tracked(label: int, detection: Detection) -> Region:
    x, y, holes, orientation, edge, first_x, first_y, area, perimeter, compactness = detection
    return Region(label, x, y, holes, orientation, True, edge, first_x, first_y, area, perimeter, compactness)


def _obvious(regions: Sequence[Region], detections: Sequence[Detection]) -> list[Detection | None] | None:
    """What shows each region, if every detection is near one region of its kind and no two are near the same.

    Most frames are so, and the general rule of `_assigned` then comes to the same: this is for speed.
    """
    shown: list[Detection | None] = [None] * len(regions)
    for detection in detections:
        x, y, holes = detection.x, detection.y, detection.holes
        near = -1
        for i, region in enumerate(regions):
            if region.holes == holes:
                dx, dy = region.x - x, region.y - y
                if dx * dx + dy * dy <= _GATE_SQUARED:
                    if near >= 0:
                        return None
                    near = i
        if near < 0 or shown[near] is not None:
            return None
        shown[near] = detection
    return shown


def _assigned(
    regions: Sequence[Region], detections: Sequence[Detection], rank_of: _Rank
) -> tuple[list[Detection | None], list[Detection]]:
    """What shows each region, and what starts new tracks: the best pair first, then the next best."""
    ordered = sorted(detections, key=lambda d: (-d.first_y, d.first_x, d))
    pairs = []
    for i, region in enumerate(regions):
        for j, detection in enumerate(ordered):
            dx, dy = region.x - detection.x, region.y - detection.y
            distance_squared = dx * dx + dy * dy
            rank = rank_of(region, detection, distance_squared <= _GATE_SQUARED)
            if rank is not None:
                pairs.append((rank, distance_squared, i, j))
    shown: list[Detection | None] = [None] * len(regions)
    free = dict(enumerate(ordered))
    for _, _, i, j in sorted(pairs):
        if shown[i] is None and j in free:
            shown[i] = free.pop(j)
    return shown, list(free.values())


def _rank(region: Region, detection: Detection, near: bool) -> int | None:
    """How far-fetched it is that a detection continues a track: 0 is least, None is out of the question.

    A region that was tracked until now is near its last place, and one that has been lost for a while may be
    anywhere. So a lost track never takes the detection of a tracked one that is passing its last place.
    """
    if region.holes != detection.holes or (region.holes == 0 and not near):
        return None
    if not region.found:
        return 1
    return 0 if near else 2


def _rank_by_place(region: Region, detection: Detection, near: bool) -> int | None:
    """The same when only places count, and nothing may jump."""
    if not near:
        return None
    return 0 if region.found else 1
