"""Tags and markers of the table of twelve, at the resolutions of webcams; calibrations by tags on the floor."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from laboratory.sheets import Pose, SheetScene, grid_sheet, tag_sheet

from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.shapes import GRID_HOLES
from khepera_forage.vision.tags import find_floor_tags, fit_to_tags
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.tracker_settings import TrackerSettings
from tests.vision.scene_renderer import heading_error, position_error

ROBOTS = (1, 2, 5, 7, 11, 17)
TAGS = TrackerSettings(markers="tags", numbers=ROBOTS, tag_size=100.0)


def places(count: int, rng: np.random.Generator, wide: float, high: float, apart: float) -> list[Pose]:
    """Poses in the cells of a grid, so that nothing touches."""
    columns = int(wide // apart)
    cells = rng.permutation(columns * int(high // apart))[:count]
    return [
        (
            float((cell % columns + 0.5) * apart + rng.uniform(-15, 15)),
            float((cell // columns + 0.5) * apart + rng.uniform(-15, 15)),
            float(rng.uniform(-math.pi, math.pi)),
        )
        for cell in cells.tolist()
    ]


def errors(poses: Mapping[int, Pose], found: Sequence[Detection]) -> list[tuple[float, float]]:
    """Errors in mm and degrees of what is found; each is one of the robots."""
    return [(5 * position_error(d, *poses[d.holes][:2]), heading_error(d, poses[d.holes][2])) for d in found]


@pytest.mark.parametrize(
    ("width", "height", "markers", "cable"),
    [
        *((848, 480, "tags", 0.0), (1280, 720, "tags", 0.0), (1280, 720, "tags", 6.0), (1920, 1080, "tags", 0.0)),
        *((640, 480, "grid", 0.0), (848, 480, "grid", 0.0), (1280, 720, "grid", 0.0)),
    ],
)
def test_tags_and_twelve_markers_are_found_exactly_and_never_mistaken(
    width: int, height: int, markers: str, cable: float
) -> None:
    numbers = ROBOTS if markers == "tags" else tuple(GRID_HOLES)
    rng, tracker = np.random.default_rng(1), Tracker(replace(TAGS, markers=markers, numbers=numbers))
    found = []
    for seed in range(4 if cable else 2):
        scene = SheetScene(width, height, rng=seed)
        poses = dict(zip(numbers, places(len(numbers), rng, 3200, 3200 * height / width, 300), strict=True))
        for number, pose in poses.items():
            scene.put(tag_sheet(number, 100.0) if markers == "tags" else grid_sheet(number), pose)
            if cable:
                right, up = rng.uniform(-30, 30, 2)
                scene.cable(pose[0] + right, pose[1] + up, rng.uniform(0, math.pi), cable)
        if markers == "tags":
            scene.put(tag_sheet(30, 100.0), (3050.0, 150.0, 1.0))  # of another laboratory
        seen = errors(poses, tracker.detect(scene.frame()))
        assert len(seen) == len(numbers)
        found += seen
    assert max(error for error, _ in found) < (1.5 if markers == "tags" else 1)
    assert max(degrees for _, degrees in found) < (3 if markers == "tags" else 2)
    assert float(np.median([error for error, _ in found])) < 0.4


def test_one_hidden_hole_never_makes_another_marker() -> None:
    for number, holes in GRID_HOLES.items():
        others = [frozenset(other) for n, other in GRID_HOLES.items() if n != number]
        turned = [frozenset((-x, -y) for x, y in other) for other in (*others, frozenset(holes))]
        for other in (*others, *turned):
            assert len(frozenset(holes) ^ other) >= 2


def test_tagged_food_is_food_and_tags_contain_none() -> None:
    settings = TrackerSettings(markers="tags", numbers=(3,), food_tags=(20,), food_tag_size=26.0, tag_size=100.0)
    scene = SheetScene(1920, 1080)
    scene.put(tag_sheet(3, 100.0), (1000.0, 900.0, 0.5))
    scene.put(tag_sheet(4, 100.0), (2000.0, 900.0, 0.5))  # not in use
    scene.put(tag_sheet(20, 26.0), (500.0, 400.0, 0.0))
    found = sorted(Tracker(settings).detect(scene.frame()), key=lambda d: d.holes)
    assert [(d.holes, round(5 * d.x), round(5 * d.y)) for d in found] == [(0, 500, 400), (3, 1000, 900)]


def test_what_looks_like_a_larger_tag_of_the_same_id_is_none() -> None:
    """Food beside an e-puck2's tag was read as another one, and the robot lost its marker."""
    scene, tracker = SheetScene(1280, 720), Tracker(TAGS)
    scene.put(tag_sheet(5, 100.0), (500.0, 500.0, 0.0))
    scene.put(tag_sheet(5, 130.0), (1500.0, 1000.0, 0.0))
    (tag,) = tracker.detect(scene.frame())
    assert (round(5 * tag.x), round(5 * tag.y)) == (500, 500)
    assert list(tracker.warnings) == ["bright shape"]


@pytest.mark.parametrize("cable", [0.0, 6.0])
def test_tag_that_is_seen_twice_is_not_reported(cable: float) -> None:
    scene, tracker = SheetScene(1280, 720), Tracker(TAGS)
    for x, y in ((500.0, 500.0), (1500.0, 1000.0)):
        scene.put(tag_sheet(5, 100.0), (x, y, 0.0))
        if cable:
            scene.cable(x, y, 0.3, cable)
    frame = scene.frame()
    assert tracker.detect(frame) == []
    assert "tag 5 is seen twice, at (" in tracker.warnings["tag twice"]
    if cable:
        return
    with pytest.raises(ValueError, match="tag 5 is seen twice; allowed: each id once"):
        find_floor_tags(frame, (5, 6))


@pytest.mark.parametrize("side", [35.0, 50.0, 70.0, 300.0])
def test_tag_of_another_size_is_named(side: float) -> None:
    scene, tracker = SheetScene(1920, 1080), Tracker(TAGS)
    scene.put(tag_sheet(5, side), (500.0, 500.0, 0.0))
    assert [d for d in tracker.detect(scene.frame()) if d.holes] == []
    named = re.fullmatch(r"tag 5 at \((\d+), (\d+)\) mm measures (\d+) mm .*", tracker.warnings["tag size"])
    assert named is not None
    assert [int(number) for number in named.groups()] == pytest.approx([500, 500, side], abs=4)


# ---------------------------------------------------------------- tags on the floor


def floor_places(height: float) -> dict[int, Pose]:
    """Twelve tags all over the floor, each turned a little."""
    rng = np.random.default_rng(0)
    return {
        38 + i: (
            250 + 900 * (i % 4) + float(rng.uniform(-20, 20)),
            250 + (height - 500) / 2 * (i // 4) + float(rng.uniform(-20, 20)),
            float(rng.uniform(-0.2, 0.2)) + math.pi / 2,
        )
        for i in range(12)
    }


def floor_scene(
    width: int, height: int, shift: tuple[float, float] = (20.0, 10.0), turn: float = 0.03, side: float = 100.0
) -> SheetScene:
    scene = SheetScene(width, height, shift=shift, turn=turn)
    for tag, pose in floor_places(3200 * height / width).items():
        scene.put(tag_sheet(tag, side), pose)
    return scene


@pytest.mark.parametrize(("width", "height", "side"), [(640, 480, 100.0), (1280, 720, 100.0), (1280, 720, 78.7)])
def test_floor_tags_of_any_size_calibrate_to_a_millimetre(width: int, height: int, side: float) -> None:
    scene = floor_scene(width, height, side=side)
    middles = {tag: pose[:2] for tag, pose in floor_places(3200 * height / width).items()}
    frame = scene.frame()
    fit = fit_to_tags(find_floor_tags(frame, sorted(middles)), middles, None, (width, height))
    assert len(fit.calibration.tags) == 12
    inverse = np.linalg.inv(scene.matrix)
    for u in range(0, width + 1, width // 8):
        for v in range(0, height + 1, height // 8):
            x, y, _ = inverse @ (u, v, 1.0)
            found = fit.calibration.to_region(u, v)
            assert math.dist((5 * found[0], 5 * found[1]), (x, y)) < 1.5


@pytest.mark.parametrize(("width", "height", "side"), [(640, 480, 100.0), (1280, 720, 45.0)])
def test_camera_that_was_knocked_is_noticed_at_the_next_frame(
    width: int, height: int, side: float, tmp_path: Path
) -> None:
    middles = {tag: pose[:2] for tag, pose in floor_places(3200 * height / width).items()}
    frame = floor_scene(width, height, side=side).frame()
    fitted = fit_to_tags(find_floor_tags(frame, sorted(middles)), middles, None, (width, height)).calibration
    assert fitted.tag_side == pytest.approx(side, rel=0.08)
    fitted.save(tmp_path / "tags.toml")
    calibration = Calibration.load(tmp_path / "tags.toml")
    tracker = Tracker(calibration=calibration)
    for _ in range(3):
        assert tracker.update(frame).regions == ()
        assert tracker.warnings == {}
    covered = frame.copy()
    covered[:300, :400] = 60  # somebody leans over the floor
    tracker.update(covered)
    assert "camera moved" not in tracker.warnings
    for shift, turn in (((30.0, 10.0), 0.03), ((20.0, 60.0), 0.03), ((20.0, 10.0), 0.06)):
        tracker = Tracker(calibration=calibration)
        tracker.update(frame)
        tracker.update(floor_scene(width, height, shift, turn, side).frame())
        assert "the camera has moved since its calibration" in tracker.warnings["camera moved"]
    tracker.update(np.full_like(frame, 105))
    assert tracker.warnings["floor tags"].startswith("no floor tag is in sight: the camera was moved")


def test_cells_of_a_floor_tag_are_no_food() -> None:
    scene = SheetScene(1280, 720)
    scene.put(tag_sheet(17, 100.0), (1600.0, 900.0, 1.5))
    assert len(Tracker().update(scene.frame()).regions) == 1
    calibration = replace(Calibration.identity(size=(1280, 720)), tags={17: scene.pixel(1600.0, 900.0)})
    assert Tracker(calibration=calibration).update(scene.frame()).regions == ()
