"""The tracker: grey frames become detections, and detections a scene (3.5)."""

import math

from khepera_forage.extras import require
from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.detector import Detector
from khepera_forage.vision.detection.floor_visibility import FloorVisibility
from khepera_forage.vision.detection.segmentation import Frame, Segmentation, Segmenter
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.tracker_settings import TrackerSettings
from khepera_forage.vision.tracks import Tracks

__all__ = ["Tracker", "TrackerSettings"]


class Tracker:
    """Detects markers and food in frames of 640 x 480 grey levels, and tracks them.

    Detection:
        Pixels clearly brighter than the floor around them are segmented (`segmentation`). A bright shape of a marker's
        size with at least one hole is a marker. Its centre and axis come from the visible parts of its four sides
        (`rectangle_fit`), and its front is on the side of the holes. Cables are removed before the holes are counted
        (`cable_bands`, `hole_pattern`). If a user's own marker has its holes in the middle, the heading is the one
        nearer to that of the same marker in the frame before; in the first frame it lies between -90 and 90 degrees. A
        disc of food's size is food (`food_detector`). All other shapes are ignored: walls, cables, and markers or food
        of which too little is visible. An uncertain region is lost; it is never reported with a number of holes that
        may be wrong. `image_quality` tells when blur, exposure or noise make the whole picture uncertain.

    Lost food:
        Food is dropped once its last place is visible and empty (`association`). A place is visible when food there
        would be inside the picture and clear of every marker, found or lost, and when its pixels have looked like
        floor in `settings.patience` consecutive frames (`floor_visibility`).

    Attributes:
        settings: As given.
        calibration: As given.

    Not thread-safe.

    Args:
        settings: Sizes, thresholds, patience, and whether to track by features; None for the defaults.
        calibration: From the picture to the floor; None for `Calibration.identity()`.

    Raises:
        ImportError: OpenCV is not installed.
        ValueError: Markers or food are as high as the calibration's camera.
    """

    def __init__(
        self, settings: TrackerSettings | None = None, calibration: Calibration | None = None
    ) -> None:
        require("the tracker", "camera")
        self.settings = settings = settings or TrackerSettings()
        self.calibration = calibration or Calibration.identity()
        scale = _pixels_per_mm(self.calibration, settings)
        self._segmenter = Segmenter(settings.contrast)
        self._detector = Detector(settings, self.calibration, scale)
        self._floor = FloorVisibility(settings, self.calibration)
        self._tracks = Tracks(by_place=settings.featureless)
        self._scene = Scene(())

    @property
    def scene(self) -> Scene:
        """The scene of the last frame; empty before the first."""
        return self._scene

    def detect(self, frame: Frame) -> list[Detection]:
        """The detections of one frame, in no particular order; no track changes.

        Args:
            frame: 480 x 640 grey levels, row 0 at the top.

        Raises:
            ValueError: A frame of another shape or type.
        """
        return self._detect(self._segmenter.segment(frame))

    def update(self, frame: Frame) -> Scene:
        """The scene after one more frame.

        Args:
            frame: 480 x 640 grey levels, row 0 at the top.

        Raises:
            ValueError: A frame of another shape or type.
        """
        segmentation = self._segmenter.segment(frame)
        detections = self._detect(segmentation)
        self._floor.update(segmentation, detections, self._scene)
        self._scene = self._tracks.update(detections, self._floor.visible)
        return self._scene

    def reset(self) -> None:
        """Forget every track; labels start at 0 again."""
        self._tracks.reset()
        self._floor.reset()
        self._scene = Scene(())

    def _detect(self, segmentation: Segmentation) -> list[Detection]:
        return [
            detection if front_known else self._oriented(detection)
            for detection, front_known in self._detector.detect(segmentation)
        ]

    def _oriented(self, detection: Detection) -> Detection:
        """A marker whose holes do not tell its front, reversed if that fits the nearest such marker's last heading."""
        before = [r for r in self._scene.regions if r.holes == detection.holes]
        before.sort(key=lambda r: math.hypot(r.x - detection.x, r.y - detection.y))
        last = before[0].orientation if before else 0
        if 90 < (detection.orientation - last) % 360 <= 270:
            return detection._replace(orientation=(detection.orientation + 180) % 360)
        return detection


def _pixels_per_mm(calibration: Calibration, settings: TrackerSettings) -> float:
    """Pixels of the picture per mm of the floor, in the middle of the picture."""
    middle = (PICTURE_WIDTH / 2, PICTURE_HEIGHT / 2)
    for height in (settings.marker_height, settings.food_height):
        calibration.to_region(*middle, height)  # raises an error for heights above the camera
    return 1 / (MM_PER_PIXEL * math.sqrt(calibration.jacobian(*middle).area))
