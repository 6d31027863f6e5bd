"""The rule that turns detections into tracks, on its own: it decides outcomes."""

import math
import random
from collections.abc import Callable, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.vision.association import GATE, Detection
from khepera_forage.vision.scene import Region
from khepera_forage.vision.tracker import Tracks

Visible = Callable[[float, float], bool]


def seen(x: float, y: float, holes: int = 0, orientation: int = 0) -> Detection:
    return Detection(x, y, holes, orientation, False, x, y + 3, 40.0, 22.0)


def right_of(line: float) -> Visible:
    return lambda x, y: x >= line


everywhere, nowhere = right_of(-math.inf), right_of(math.inf)


def as_detection(region: Region) -> Detection:
    return Detection(*region[1:5], region.edge, *region[7:])


coordinates = st.floats(0, 640, allow_subnormal=False) | st.integers(0, 40).map(float)
detections = st.builds(seen, coordinates, coordinates, st.sampled_from([0, 0, 1, 2]), st.integers(0, 359))
frames = st.lists(detections, max_size=6)
# A frame, and the part of the floor that can be seen in it: everything right of a line.
films = st.lists(st.tuples(frames, st.sampled_from([0.0, 20.0, 300.0, 641.0])), max_size=8)


@given(films)
def test_scene_follows_the_rules(film: Sequence[tuple[list[Detection], float]]) -> None:
    tracks, before, holes = Tracks(), dict[int, Region](), dict[int, int]()
    most = {1: 0, 2: 0}
    for frame, line in film:
        visible = right_of(line)
        scene = tracks.update(frame, visible)
        assert sorted(as_detection(r) for r in scene.regions if r.found) == sorted(frame)
        labels = [r.label for r in scene.regions]
        assert labels == sorted(set(labels))
        new = [label for label in labels if label not in before]
        assert new == list(range(len(holes), len(holes) + len(new))), "labels are never reused"
        now = {r.label: r for r in scene.regions}
        for label, old in before.items():
            if label not in now:
                assert old.holes == 0, "a marker was dropped"
                assert visible(old.x, old.y), "food was dropped though its place was hidden"
            elif not now[label].found:
                assert now[label] == old._replace(found=False)
                assert old.holes > 0 or not visible(old.x, old.y), "visible and empty, yet kept"
            elif old.holes == 0:
                assert (now[label].x - old.x) ** 2 + (now[label].y - old.y) ** 2 <= GATE**2
        for region in scene.regions:
            assert holes.setdefault(region.label, region.holes) == region.holes
        for kind in most:
            most[kind] = max(most[kind], sum(d.holes == kind for d in frame))
            assert sum(r.holes == kind for r in scene.regions) == most[kind]
        before = now


@given(films, st.randoms(use_true_random=False))
def test_the_order_of_detections_does_not_matter(
    film: Sequence[tuple[list[Detection], float]], shuffler: random.Random
) -> None:
    one, other = Tracks(), Tracks()
    for frame, line in film:
        shuffled = shuffler.sample(frame, len(frame))
        assert one.update(frame, right_of(line)) == other.update(shuffled, right_of(line))


def test_first_frame_is_numbered_in_reading_order() -> None:
    scene = Tracks().update([seen(5, 10), seen(90, 300, 2), seen(20, 300, 1), seen(50, 200)], nowhere)
    assert [(r.label, r.x) for r in scene.regions] == [(0, 20), (1, 90), (2, 50), (3, 5)]
    assert all(r.found for r in scene.regions)


@pytest.mark.parametrize(("distance", "labels"), [(6.0, [0]), (6.01, [0, 1])])
def test_food_that_reappears_near_its_last_place_is_the_same(distance: float, labels: list[int]) -> None:
    tracks = Tracks()
    tracks.update([seen(50, 60)], nowhere)
    tracks.update([], nowhere)
    regions = tracks.update([seen(50 + distance, 60)], nowhere).regions
    assert [r.label for r in regions] == labels
    assert [r.found for r in regions] == [label == labels[-1] for label in labels]


def test_a_lost_learner_does_not_take_the_marker_of_one_that_passes_its_last_place() -> None:
    tracks = Tracks()
    tracks.update([seen(100, 90, 2), seen(117, 89, 2)], nowhere)
    tracks.update([seen(117, 89, 2)], everywhere)
    for x in range(113, 80, -4):
        scene = tracks.update([seen(x, 89, 2)], everywhere)
        assert [(r.label, r.x, r.found) for r in scene.regions] == [(0, 100, False), (1, x, True)]


@pytest.mark.parametrize(("x", "label"), [(101, 0), (103, 1)])
def test_one_candidate_for_two_tracks_continues_the_nearest(x: float, label: int) -> None:
    tracks = Tracks()
    tracks.update([seen(100, 100), seen(104, 100)], nowhere)
    assert [(r.label, r.x) for r in tracks.update([seen(x, 100)], everywhere).regions] == [(label, x)]


# ---------------------------------------------------------------- by place alone (3.5)


@given(st.lists(frames, max_size=6))
def test_by_place_nothing_jumps(film: list[list[Detection]]) -> None:
    tracks = Tracks(by_place=True)
    places: dict[int, tuple[float, float]] = {}
    for frame in film:
        scene = tracks.update(frame, nowhere)
        assert sorted((r.x, r.y, r.holes) for r in scene.regions if r.found) == sorted(
            (d.x, d.y, d.holes) for d in frame
        )
        labels = [r.label for r in scene.regions]
        assert labels == sorted(set(labels))
        for region in scene.regions:
            x, y = places.get(region.label, (region.x, region.y))
            assert (region.x - x) ** 2 + (region.y - y) ** 2 <= GATE**2
            places[region.label] = region.x, region.y


def test_a_wrong_number_of_holes_does_not_end_a_track() -> None:
    tracks = Tracks(by_place=True)
    for holes in (2, 1, 0, 2):
        (region,) = tracks.update([seen(10, 10, holes)], nowhere).regions
        assert (region.label, region.holes) == (0, holes)
