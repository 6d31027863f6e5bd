"""The tracker through mixed troubles at the resolutions of webcams: identities, errors and speed.

    python benchmarks/tracker_troubles.py [--frames 1000]

Two robots drive in circles over a floor that is 3.2 m wide, drawn by the scenes of the tests. Every other frame has a
trouble: glare on a marker, the hard edge of a shadow, a hand, a cable over each marker, compression, another exposure.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))  # for the scenes of the tests

from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.tracker_settings import TrackerSettings
from tests.vision.tag_scenes import Picture, Scene, grid_sheet, tag_sheet

SIZES = ((640, 480), (1280, 720), (1920, 1080))
_ROBOTS, _CIRCLE, _STEP = (1, 2), 420.0, 0.04
"""Numbers of the robots, radius of their circles in mm, and radians from one frame to the next: 17 mm."""
_WRONG, _OFF = 60.0, 5.0
"""mm from its robot from which a marker is another's, and from which it is off."""
_COLUMNS = (
    "frames",
    "markers",
    "found",
    "lost with a warning",
    "lost without",
    "wrong number, front or phantom",
    "off by more than 5 mm",
    "median error (mm)",
    "99 % (mm)",
    "frames/s",
)
TROUBLES = ("glare", "shadow", "hand", "cables", "compression", "exposure")


def troubled(scene: Scene, name: str, x: float, y: float, rng: np.random.Generator) -> Picture:
    """A frame with a trouble at a place in mm."""
    u, v = scene.pixel(x + rng.uniform(-60, 60), y + rng.uniform(-60, 60))
    across, down = (
        np.arange(scene.width, dtype=np.float32) - u,
        np.arange(scene.height, dtype=np.float32)[:, None] - v,
    )
    size = scene.scale * rng.uniform(12, 35)
    if name == "glare":
        along, beside = np.exp(-((across / size) ** 2) / 2), np.exp(-((down / size) ** 2) / 2)
        scene.picture = np.minimum(scene.picture + rng.uniform(120, 300) * beside * along, 400)
    elif name == "shadow":
        turn = rng.uniform(0, 2 * math.pi)
        dark = (across * math.cos(turn) + down * math.sin(turn)).clip(0, 1)
        scene.picture *= 1 - rng.uniform(0.2, 0.7) * dark
    elif name == "hand":
        turn, thick = rng.uniform(0, 2 * math.pi), max(1, round(70 * scene.scale))
        far = (round(u + 1500 * math.cos(turn)), round(v + 1500 * math.sin(turn)))
        cv2.line(scene.picture, (round(u), round(v)), far, float(rng.uniform(80, 170)), thick, cv2.LINE_AA)
    if name == "exposure":
        scene.picture *= rng.uniform(0.4, 1.5)
    frame = scene.frame()
    if name == "compression":
        frame = cv2.imdecode(
            cv2.imencode(".jpg", frame, (cv2.IMWRITE_JPEG_QUALITY, 15))[1], cv2.IMREAD_GRAYSCALE
        )  # type: ignore[assignment]
    return frame


def measure(width: int, height: int, markers: str, frames: int) -> str:
    """A row of the table."""
    rng = np.random.default_rng(width)
    sheet: Callable[[int], Picture] = (
        (lambda n: grid_sheet(n, thesis=True)) if markers == "holes" else (lambda n: tag_sheet(n, 100.0))
    )
    tracker = Tracker(TrackerSettings(markers=markers, numbers=_ROBOTS, tag_size=100.0))
    found = wrong = off = warned = silent = 0
    seconds, distances = 0.0, []
    for number in range(frames):
        scene = Scene(width, height, seed=number)
        middle = 1600 * height / width
        poses = {
            robot: (
                800.0 + 1600 * i + _CIRCLE * math.cos(_STEP * number + i),
                middle + _CIRCLE * math.sin(_STEP * number + i),
                _STEP * number + i + math.pi / 2,
            )
            for i, robot in enumerate(_ROBOTS)
        }
        for robot, pose in poses.items():
            scene.put(sheet(robot), pose)
        trouble = TROUBLES[int(rng.integers(len(TROUBLES)))] if number % 2 else ""
        if trouble == "cables":
            for x, y, _ in poses.values():
                scene.cable(x + rng.uniform(-20, 20), y + rng.uniform(-20, 20), rng.uniform(0, math.pi), 8.0)
        x, y, _ = poses[int(rng.choice(_ROBOTS))]
        frame = troubled(scene, trouble, x, y, rng)
        began = time.process_time()
        regions = tracker.update(frame).regions
        seconds += time.process_time() - began
        seen = {region.holes: region for region in regions if region.found and region.holes}
        wrong += len([r for r in regions if r.holes]) > len(_ROBOTS)
        for robot, (x, y, heading) in poses.items():
            region = seen.get(robot)
            if region is None:
                warned += bool(tracker.warnings)
                silent += not tracker.warnings
                continue
            found += 1
            distance = math.dist((5 * region.x, 5 * region.y), (x, y))
            turned = abs(math.remainder(region.orientation - math.degrees(heading), 360))
            wrong += distance > _WRONG or turned > 90
            off += _OFF < distance <= _WRONG
            distances.append(distance)
    median, most = np.quantile(distances, (0.5, 0.99))
    return (
        f"| {width} x {height} | {markers} | {100 * found / frames / len(_ROBOTS):.1f} % | "
        f"{warned} | {silent} | {wrong} | {off} | "
        f"{median:.2f} | {most:.2f} | {frames / seconds:.0f} |"
    )


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="The tracker through mixed troubles.")
    parser.add_argument("--frames", type=int, default=1000, help="of each row (1000)")
    parser.add_argument(
        "--widths", type=int, nargs="+", default=[width for width, _ in SIZES], help="pixels across"
    )
    parser.add_argument("--markers", nargs="+", default=["holes", "tags"], help="kinds of markers")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    print(f"| {' | '.join(_COLUMNS)} |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for width, height in SIZES:
        for markers in given.markers if width in given.widths else ():
            if (width, markers) != (640, "tags"):
                print(measure(width, height, markers, given.frames), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
