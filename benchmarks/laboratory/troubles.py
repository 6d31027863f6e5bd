"""The tracker through mixed troubles at the resolutions of webcams: identities, errors and speed.

Two robots drive in circles over a floor that is 3.2 m wide, drawn by OpenCV alone. After ten frames without trouble,
each trouble lasts for ten: glare on a marker, the hard edge of a shadow, a hand, a cable over each marker, compression,
another exposure. It goes with the robot, which is worse than one that stays where it is.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Table, Value, table_of
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.tracker_settings import TrackerSettings
from laboratory.sheets import SheetScene, grid_sheet, tag_sheet

Frame = NDArray[np.uint8]
_WIDE = 3200.0
"""mm of the floor across the picture."""
SETUPS = ((640, 480, "holes"), (1280, 720, "holes"), (1280, 720, "tags"), (1920, 1080, "holes"), (1920, 1080, "tags"))
"""Width, height and kind of markers."""
_ROBOTS, _CIRCLE, _STEP = (1, 2), 420.0, 0.04
"""Numbers of the robots, radius of their circles in mm, and radians from one frame to the next: 17 mm."""
_WRONG, _OFF = 60.0, 5.0
"""mm from its robot from which a marker is another's, and from which it is off."""
_TROUBLES, _LASTING = ("glare", "shadow", "hand", "cables", "compression", "exposure"), 10
"""What disturbs some frames, and for how many: the tracker waits for three that agree."""


@dataclass(frozen=True, slots=True)
class Trouble:
    """What the tracker made of all frames at one resolution, with two markers each.

    Of the markers, `found` have their number and heading, or not; `warned` and `silent` were lost in frames with and
    without a warning, `wrong` have the number or heading of another, or are one too many, and `off` are more than 5 mm
    from their robot. 99 % of the errors of centres are at most `most` mm, `rate` is frames a second of one thread.
    """

    size: str
    markers: str
    frames: int
    found: int
    warned: int
    silent: int
    wrong: int
    off: int
    most: float
    rate: float


def troubled_drive(width: int, height: int, markers: str, frames: int, seed: int) -> list[Trouble]:
    """Track frames of one of `SETUPS`."""
    cv2.setNumThreads(1)
    rng = np.random.default_rng(width + seed)
    tracker = Tracker(TrackerSettings(markers=markers, numbers=_ROBOTS, tag_size=100.0))
    wrong = off = warned = silent = 0
    seconds, distances = 0.0, []
    for number in range(frames):
        frame, poses = _troubled_frame(width, height, markers, number, seed, rng)
        began = time.process_time()
        regions = tracker.update(frame).regions
        seconds += time.process_time() - began
        seen = {region.holes: region for region in regions if region.found and region.holes}
        wrong += len([region for region in regions if region.holes]) > len(_ROBOTS)
        for robot, (x, y, heading) in poses.items():
            region = seen.get(robot)
            if region is None:
                warned += bool(tracker.warnings)
                silent += not tracker.warnings
                continue
            distance = math.dist((5 * region.x, 5 * region.y), (x, y))
            turned = abs(math.remainder(region.orientation - math.degrees(heading), 360))
            wrong += distance > _WRONG or turned > 90
            off += _OFF < distance <= _WRONG
            distances.append(distance)
    size, rate, most = f"{width} x {height}", frames / seconds, float(np.quantile(distances, 0.99))
    counts = (frames, len(distances), warned, silent, wrong, off)
    return [Trouble(size, markers, *counts, most, rate)]


def _troubled_frame(
    width: int, height: int, markers: str, number: int, seed: int, noise: np.random.Generator
) -> tuple[Frame, dict[int, tuple[float, float, float]]]:
    """A frame, perhaps with a trouble, and the pose of each robot in mm and radians."""
    scene, poses = SheetScene(width, height, _WIDE, noise), {}
    scale = scene.scale
    for i, robot in enumerate(_ROBOTS):
        angle = _STEP * number + i
        x = 800.0 + 1600 * i + _CIRCLE * math.cos(angle)
        y = height / scale / 2 + _CIRCLE * math.sin(angle)
        poses[robot] = x, y, angle + math.pi / 2
        scene.put(tag_sheet(robot, 100.0) if markers == "tags" else grid_sheet(robot, thesis=True), poses[robot])
    rng = np.random.default_rng((seed, number // (2 * _LASTING)))  # the same trouble for all of its frames
    trouble = _TROUBLES[int(rng.integers(len(_TROUBLES)))] if number // _LASTING % 2 else ""
    x, y, _ = poses[int(rng.choice(_ROBOTS))]
    u, v = scale * (x + rng.uniform(-60, 60)), height - scale * (y + rng.uniform(-60, 60))
    across, down = np.arange(width, dtype=np.float32) - u, np.arange(height, dtype=np.float32)[:, None] - v
    size, turn = scale * rng.uniform(12, 35), rng.uniform(0, 2 * math.pi)
    ahead = np.array((math.cos(turn), math.sin(turn)))
    if trouble == "cables":
        for x, y, _ in poses.values():
            right, below = rng.uniform(-20, 20, 2)
            scene.cable(x + right, y - below, -rng.uniform(0, math.pi), 8.0)
    elif trouble == "glare":
        spot = np.exp(-((across / size) ** 2) / 2) * np.exp(-((down / size) ** 2) / 2)
        scene.picture = np.minimum(scene.picture + rng.uniform(120, 300) * spot, 400).astype(np.float32)
    elif trouble == "shadow":
        scene.picture *= 1 - rng.uniform(0.2, 0.7) * (across * ahead[0] + down * ahead[1]).clip(0, 1)
    elif trouble == "hand":
        scene.line(np.array((u, v)), (u, v) + 1500 * ahead, 70 * scale, float(rng.uniform(80, 170)))
    elif trouble == "exposure":
        scene.picture *= rng.uniform(0.4, 1.5)
    frame = scene.frame()
    if trouble == "compression":
        coded = cv2.imencode(".jpg", frame, (cv2.IMWRITE_JPEG_QUALITY, 15))[1]
        frame = cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)  # type: ignore[assignment] # uint8
    return frame, poses


def troubles_table(rows: Sequence[Trouble]) -> Table:
    """All resolutions."""
    lines: list[dict[str, Value]] = [
        {
            "frames": f"{row.frames} of {row.size}",
            "markers": row.markers,
            "found (%)": 100 * row.found / row.frames / len(_ROBOTS),
            "lost with a warning": row.warned,
            "lost without": row.silent,
            "wrong number, front or phantom": row.wrong,
            "off by more than 5 mm": row.off,
            "99 % (mm)": row.most,
            "frames/s": row.rate,
        }
        for row in rows
    ]
    note = "Two robots drive over a floor of 3.2 m, and a trouble disturbs ten frames of twenty."
    digits = {"99 % (mm)": 2, "frames/s": 0}
    return table_of("troubles", "Mixed troubles", note, lines, digits)
