"""The tracker through mixed troubles at the resolutions of webcams: identities, errors and speed.

Two robots drive in circles over a floor that is 3.2 m wide, drawn by the scenes of the tests. Every other frame has a
trouble: glare on a marker, the hard edge of a shadow, a hand, a cable over each marker, compression, another exposure.
"""

import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # for the scenes of the tests

from khepera_forage.estimates import Column, Table, Value
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.tracker_settings import TrackerSettings
from tests.vision.tag_scenes import Picture, Scene, grid_sheet, tag_sheet

SETUPS = (
    (640, 480, "holes"),
    (1280, 720, "holes"),
    (1280, 720, "tags"),
    (1920, 1080, "holes"),
    (1920, 1080, "tags"),
)
"""Width, height and kind of markers."""
_ROBOTS, _CIRCLE, _STEP = (1, 2), 420.0, 0.04
"""Numbers of the robots, radius of their circles in mm, and radians from one frame to the next: 17 mm."""
_WRONG, _OFF = 60.0, 5.0
"""mm from its robot from which a marker is another's, and from which it is off."""
_TROUBLES = ("glare", "shadow", "hand", "cables", "compression", "exposure")


@dataclass(frozen=True, slots=True)
class Trouble:
    """What the tracker made of all frames at one resolution.

    Attributes:
        size: Of the frames.
        markers: Their kind.
        frames: Their number, with two markers each.
        found: Markers found, each with its number and heading, or not.
        warned: Markers lost in frames with a warning.
        silent: Markers lost in frames without one.
        wrong: Markers with the number or the heading of another, and frames with a marker too many.
        off: Found markers that are more than 5 mm from their robot.
        median: Of the errors of centres in mm.
        most: Their 99th percentile.
        rate: Frames a second, by the processor time of one thread.
    """

    size: str
    markers: str
    frames: int
    found: int
    warned: int
    silent: int
    wrong: int
    off: int
    median: float
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
        frame, poses = _frame(width, height, markers, number, rng)
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
    median, most = np.quantile(distances, (0.5, 0.99)).tolist()
    size, rate = f"{width} x {height}", frames / seconds
    counts = (frames, len(distances), warned, silent, wrong, off)
    return [Trouble(size, markers, *counts, median, most, rate)]


def _frame(
    width: int, height: int, markers: str, number: int, rng: np.random.Generator
) -> tuple[Picture, dict[int, tuple[float, float, float]]]:
    """A frame, and the pose of each robot in mm and radians."""
    scene = Scene(width, height, seed=number)
    middle = 1600 * height / width
    poses = {}
    for i, robot in enumerate(_ROBOTS):
        angle = _STEP * number + i
        x, y = 800.0 + 1600 * i + _CIRCLE * math.cos(angle), middle + _CIRCLE * math.sin(angle)
        poses[robot] = x, y, angle + math.pi / 2
        sheet = grid_sheet(robot, thesis=True) if markers == "holes" else tag_sheet(robot, 100.0)
        scene.put(sheet, poses[robot])
    trouble = _TROUBLES[int(rng.integers(len(_TROUBLES)))] if number % 2 else ""
    if trouble == "cables":
        for x, y, _ in poses.values():
            scene.cable(x + rng.uniform(-20, 20), y + rng.uniform(-20, 20), rng.uniform(0, math.pi), 8.0)
    x, y, _ = poses[int(rng.choice(_ROBOTS))]
    return _troubled(scene, trouble, x, y, rng), poses


def _troubled(scene: Scene, name: str, x: float, y: float, rng: np.random.Generator) -> Picture:
    """A frame with a trouble at a place in mm."""
    u, v = scene.pixel(x + rng.uniform(-60, 60), y + rng.uniform(-60, 60))
    across = np.arange(scene.width, dtype=np.float32) - u
    down = np.arange(scene.height, dtype=np.float32)[:, None] - v
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
    elif name == "exposure":
        scene.picture *= rng.uniform(0.4, 1.5)
    frame = scene.frame()
    if name == "compression":
        coded = cv2.imencode(".jpg", frame, (cv2.IMWRITE_JPEG_QUALITY, 15))[1]
        frame = cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)  # type: ignore[assignment]
    return frame


def troubles_table(rows: Sequence[Trouble]) -> Table:
    """All resolutions."""
    lines: list[tuple[Value, ...]] = [
        (
            *(f"{row.frames} of {row.size}", row.markers, 100 * row.found / row.frames / len(_ROBOTS)),
            *(row.warned, row.silent, row.wrong, row.off, row.median, row.most, row.rate),
        )
        for row in rows
    ]
    columns = (
        *map(Column, ("frames", "markers", "found (%)", "lost with a warning", "lost without")),
        *map(Column, ("wrong number, front or phantom", "off by more than 5 mm")),
        *(Column("median error (mm)", 2), Column("99 % (mm)", 2), Column("frames/s", 0)),
    )
    note = "Two robots drive over a floor of 3.2 m, and every other frame has a trouble."
    return Table("troubles", "Mixed troubles", note, columns, lines)
