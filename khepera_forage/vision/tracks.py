"""The tracks of a camera: detections in, the scene with its regions out (3.5)."""

from collections.abc import Callable, Sequence

from khepera_forage.vision.association import Detection, Track, match, may_vanish, start_tracks
from khepera_forage.vision.scene import Region, Scene


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
            elif may_vanish(track, self._by_place) and visible(track.x, track.y):
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
