"""Food tracking and association: dataclasses in Python and records in compiled code come to the same."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from khepera_forage.compilation.decorators import entrance
from khepera_forage.envs.compiled import rules  # noqa: F401 (registers the rules)
from khepera_forage.envs.compiled.parameters import (
    arena_map,
)
from khepera_forage.envs.compiled.records import (
    food_object_dtype,
    link_dtype,
    tracker_dtype,
)
from khepera_forage.envs.compiled.worlds import known_ways
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.compiled import tracking  # noqa: F401 (registers the rules of association)
from khepera_forage.sim.compiled.records import detection_dtype, track_dtype
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.food_links import Link
from khepera_forage.task.food_tracking import (
    NOWHERE,
    FoodObject,
    FoodTracker,
    is_collected,
    share_identified,
    update_food,
)
from khepera_forage.task.way_finding import KnownWays, no_known_ways
from khepera_forage.vision.association import Detection, Track, match, may_vanish, start_tracks
from tests.compiled.rule_records import DECISIONS, IDS, check_same, records, task_of
from tests.version_0_1 import CORRIDOR, RECTANGLE

BLOCK = replace(
    RECTANGLE,
    home=CORRIDOR.home,
    obstacles=((Point(300, 60), Point(340, 60), Point(340, 160), Point(300, 160)),),
)


@entrance
def _update_food(
    tracker: Any,
    foods: Any,
    straight_ways: Any,
    to_waypoints: Any,
    food_lengths: Any,
    links: Any,
    tracks: Any,
    task: Any,
    pose: Any,
    present: bool,
    explored: bool,
    arm: int,
) -> None:
    arena, decisions = arena_map(task), task.decisions[0]
    update_food(
        tracker[0],
        foods,
        KnownWays(straight_ways, to_waypoints, food_lengths),
        links,
        tracks,
        arena,
        pose[0],
        pose[1],
        pose[2],
        present,
        explored,
        arm,
        decisions,
    )


def check_known_ways(arrays: tuple[Any, ...], tracker: FoodTracker) -> None:
    known = tracker.known_ways
    check_same(arrays[0], known.straight)
    check_same(arrays[1], known.to_waypoints)
    seen = [food.lengths_x > NOWHERE for food in tracker.foods]
    np.testing.assert_allclose(arrays[2][seen], np.array(known.food_lengths)[seen])


@pytest.mark.parametrize("decisions", DECISIONS, ids=IDS)
@pytest.mark.parametrize("where", [CORRIDOR, BLOCK], ids=["corridor", "room_with_a_block"])
@pytest.mark.parametrize("count", [1, 3])
def test_update_food_is_the_same_on_records(count: int, where: Arena, decisions: Decisions) -> None:
    """Sequences of rounds in which tracks appear, move, vanish and return with other labels."""
    rng, arena, task = np.random.default_rng(count), arena_map_of(where), task_of(where, decisions)
    waypoints, values = len(arena.ways.waypoints), decisions.values()
    delivered = held = identified = 0
    for _ in range(40):
        foods = [
            FoodObject(float(rng.uniform(20, 125)), float(rng.uniform(0, 45)), int(rng.integers(1, 4)))
            for _ in range(count)
        ]
        tracker = FoodTracker(
            foods=foods,
            known_ways=no_known_ways(count, waypoints),
            links=[Link() for _ in range(2 * count)],
            deliverable=count,
        )
        straight, to_waypoints, lengths = (array[0, 0] for array in known_ways(1, 1, count, waypoints))
        arrays = (
            records(tracker_dtype, [tracker]),
            records(food_object_dtype, foods),
            records(link_dtype, tracker.links),
        )
        tracks = [Track() for _ in range(2 * count)]
        for number in range(25):
            for track in tracks:
                chance = rng.random()
                if chance < 0.1:
                    x, y = rng.uniform((20, -8), (125, 55))
                    track.label, track.x, track.y = int(rng.integers(0, 40)) * 50 + number, float(x), float(y)
                elif chance < 0.15:
                    track.label = -1
                track.x += float(rng.normal(0, 1))
                track.found, track.holes = bool(rng.random() < 0.8), int(rng.random() < 0.1)
            x, y = rng.uniform((20, 5), (125, 40))
            present = bool(rng.random() < 0.5)
            explored = present and bool(rng.random() < 0.3)
            pose = (float(x), float(y), int(rng.integers(0, 360)))
            arm = int(rng.choice((215, 255)))
            known = tracker, foods, tracker.known_ways, tracker.links, tracks
            update_food(*known, arena, *pose, present, explored, arm, values)
            ways, links = (straight, to_waypoints, lengths), arrays[2]
            slots = arrays[0], arrays[1], *ways, links, records(track_dtype, tracks)
            _update_food(*slots, task, np.array(pose), present, explored, arm)
            check_known_ways(ways, tracker)
            for array, things in zip(arrays, ([tracker], foods, tracker.links), strict=True):
                check_same(array, things)
            held += tracker.held >= 0
        delivered += tracker.delivered + tracker.poison_home
        identified += sum(food.known > 0 for food in foods)
    assert delivered > 10
    assert held > 200
    assert identified > 20


@entrance
def _share(foods: Any, others: Any, collected: Any) -> None:
    share_identified(foods, others)
    for k in range(len(others)):
        collected[k] = is_collected(others[k])


def test_share_identified_is_the_same_on_records() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        foods, others = (
            [
                FoodObject(0.0, 0.0, known=int(rng.integers(0, 4)), delivered=bool(rng.integers(0, 2)))
                for _ in range(4)
            ]
            for _ in range(2)
        )
        changed, collected = records(food_object_dtype, others), np.zeros(4, np.bool_)
        _share(records(food_object_dtype, foods), changed, collected)
        share_identified(foods, others)
        check_same(changed, others)
        assert collected.tolist() == [is_collected(food) for food in others]


@entrance
def _associate(
    tracks: Any, detections: Any, count: int, by_place: bool, visible: Any, next_label: int
) -> tuple[int, int]:
    new = match(tracks, detections, count, by_place)
    for k in range(len(tracks)):
        if may_vanish(tracks[k], by_place) and visible[k]:
            tracks[k].label = -1
    if new:
        next_label = start_tracks(tracks, detections, count, next_label)
    return new, next_label


@pytest.mark.parametrize("by_place", [False, True])
def test_association_is_the_same_on_records(by_place: bool) -> None:
    """Regions on a grid of half the gate, so that costs and distances tie often."""
    rng, slots = np.random.default_rng(int(by_place)), 6
    python: Any = _associate.py_func  # type: ignore[attr-defined]
    matched = started = vanished = 0
    for _ in range(60):
        tracks, next_label = [Track() for _ in range(slots)], 0
        arrays, record_label = records(track_dtype, tracks), 0
        for _ in range(20):
            places = rng.integers(0, 6, (int(rng.integers(0, 5)), 2)) * 3.0
            detections = [
                Detection(x, y, int(rng.choice((0, 0, 1, 2))), 0, False, x, y, 1.0, 1.0, 1.0)
                for x, y in places.tolist()
            ]
            visible = rng.random(slots) < 0.3
            arguments = (len(detections), by_place, visible)
            before = sum(track.label >= 0 for track in tracks)
            new, next_label = python(tracks, detections, *arguments, next_label)
            given = records(detection_dtype, [*detections, Detection(*[0] * 10)])  # type: ignore[arg-type]
            assert _associate(arrays, given, *arguments, record_label) == (new, next_label)
            record_label = next_label
            check_same(arrays, tracks)
            matched += len(detections) - new
            started += new
            vanished += before > sum(track.label >= 0 for track in tracks)
    assert matched > 300
    assert started > 300
    assert vanished > 100
