"""Tracks continued by place alone (3.5)."""

from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.vision.association import GATE, Detection
from khepera_forage.vision.tracks import Tracks


def seen(x: float, y: float, holes: int = 0) -> Detection:
    return Detection(x, y, holes, 0, False, x, y + 3, 40.0, 22.0, 12.1)


def everywhere(x: float, y: float) -> bool:
    return True


def nowhere(x: float, y: float) -> bool:
    return False


coordinates = st.integers(0, 40).map(float)
frames = st.lists(st.builds(seen, coordinates, coordinates, st.sampled_from([0, 1, 2])), max_size=5)


@given(st.lists(frames, max_size=6))
def test_found_regions_are_the_detections_and_nothing_jumps(film: list[list[Detection]]) -> None:
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


def test_a_marker_that_reappears_elsewhere_is_another() -> None:
    tracks = Tracks(by_place=True)
    tracks.update([seen(10, 10, 1)], nowhere)
    tracks.update([], nowhere)
    regions = tracks.update([seen(10 + GATE + 1, 10, 1)], nowhere).regions
    assert [(r.label, r.found) for r in regions] == [(0, False), (1, True)]


def test_two_that_meet_can_be_mistaken_for_each_other() -> None:
    """What feature-based tracking is preferred for (3.5): after a jump, places alone swap teacher and learner."""
    tracks = Tracks(by_place=True)
    tracks.update([seen(10, 10, 1), seen(14, 10, 2)], nowhere)
    regions = tracks.update([seen(14, 10, 1), seen(10, 10, 2)], nowhere).regions
    assert sorted((r.label, r.holes) for r in regions) == [(0, 2), (1, 1)]


def test_a_lost_marker_is_dropped_like_food() -> None:
    tracks = Tracks(by_place=True)
    tracks.update([seen(10, 10, 1)], nowhere)
    assert [r.found for r in tracks.update([], nowhere).regions] == [False]
    assert tracks.update([], everywhere).regions == ()
