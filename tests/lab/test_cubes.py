"""A laboratory of toio cubes: no camera, no person; robots and food drive to their places by themselves."""

import math
import re
from collections.abc import Iterator

import numpy as np
import pytest

pytest.importorskip("toio")
pytest.importorskip("cv2")

from khepera_forage.envs.laboratories import virtual_cubes
from khepera_forage.lab.operator import OperatorGaveUp
from khepera_forage.lab.settings_file import parse
from khepera_forage.lab.virtual_laboratory import VirtualCubeLaboratory
from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.mat import MatPose
from khepera_forage.robots.toio import virtual
from khepera_forage.sim.world import Layout
from tests.lab.laboratories import layout_of
from tests.version_0_1 import SET_UP, V0_1

FILE = """
food_cubes = ["virtual:food1", "virtual:food2"]
[[robots]]
type = "toio"
port = "virtual:teacher"
offset = [30, 20]
[[robots]]
type = "toio"
port = "virtual:learner"
offset = [30, 256]
"""


@pytest.fixture
def lab() -> Iterator[VirtualCubeLaboratory]:
    with virtual_cubes("corridor", 2, V0_1) as lab:
        yield lab


def test_cubes_drive_to_their_places_for_every_episode_and_are_sensed(lab: VirtualCubeLaboratory) -> None:
    layout = layout_of(lab.arenas)
    for seed in range(2):
        lab.reset(np.random.default_rng(seed), layout)
        for pose, start in zip(lab.poses(), layout.starts, strict=True):
            assert math.dist(pose[:2], start[:2]) <= 15
            assert abs(math.degrees(pose.heading - start.heading)) <= 10
        for food, place in zip(lab.food_places(), layout.foods, strict=True):
            assert math.dist(food[:2], place) <= 15
        food_x = lab.food_places()[0].x
        senses = []
        for _ in range(70):
            for robot in lab.robots:
                robot.drive(Motors(6, 6, 215, 200))
            lab.advance()
            senses.append(lab.robots[0].sense())
        assert lab.food_places()[0].x > food_x + 20, "it was pushed"
        assert {own.object_presence for own in senses} == {0, 255}
        assert max(max(own.proximity[2:4]) for own in senses) > 0, "as the map shows the food"
        lab.stop()
        assert not any(lab.table.cube(name).turning for name in ("robot 0", "robot 1"))


def test_cubes_reach_their_places_by_late_commands(lab: VirtualCubeLaboratory) -> None:
    lab.table.latency = 0.25
    layout = layout_of(lab.arenas)
    lab.reset(np.random.default_rng(0), layout)
    for pose, start in zip(lab.poses(), layout.starts, strict=True):
        assert math.dist(pose[:2], start[:2]) <= 15
        assert abs(math.degrees(pose.heading - start.heading)) <= 10


@pytest.mark.parametrize(("safe_speed", "fastest"), [(1, 8), (6, 10)])
def test_cubes_drive_to_their_places_within_the_safe_speed(
    safe_speed: int, fastest: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In units of a cube's motors, of which one speed unit has 1.66, and the slowest speed 8."""
    units, effective = list[int](), virtual._effective

    def recorded(direction: int, unit: int) -> int:
        units.append(effective(direction, unit))
        return units[-1]

    monkeypatch.setattr(virtual, "_effective", recorded)
    with VirtualCubeLaboratory(parse(f"safe_speed = {safe_speed}\n{FILE}", SET_UP, 0.1)) as lab:
        lab.reset(np.random.default_rng(0), layout_of(lab.arenas))
    assert max(map(abs, units)) == fastest


def test_spare_food_cube_leaves_the_arena_of_a_recall() -> None:
    with VirtualCubeLaboratory(parse(FILE, SET_UP, 0.1).for_recall()) as lab:
        (arena,) = lab.arenas
        for seed, name in enumerate(("food1", "food2")):
            lab.table.cube(name, MatPose(arena.home.x, arena.home.y, 0.0))
            lab.reset(np.random.default_rng(seed), Layout((arena.start,), arena.foods))
            (food,) = lab.food_places()
            assert math.dist(food[:2], arena.foods[0]) <= 15


def test_spare_food_cube_without_room_is_named() -> None:
    settings = parse(FILE.replace('"virtual:food2"]', '"virtual:food2", "virtual:food3"]'), SET_UP, 0.1)
    with (
        VirtualCubeLaboratory(settings) as lab,
        pytest.raises(OperatorGaveUp, match=r"no room beside the arenas for virtual:food[123]: take it away"),
    ):
        lab.reset(np.random.default_rng(0), layout_of(lab.arenas))


def test_lost_cube_stops_all_and_takes_a_person(lab: VirtualCubeLaboratory) -> None:
    layout = layout_of(lab.arenas)
    lab.reset(np.random.default_rng(0), layout)
    lab.table.unplugged.add("robot 1")
    with pytest.raises(RobotLost, match="virtual:robot 1"):
        lab.advance()
    assert not lab.table.cube("robot 0").turning
    with pytest.raises(OperatorGaveUp, match="this needs a person: reconnect what was lost"):
        lab.reset(np.random.default_rng(1), layout)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[30, 256]", "[300, 256]", "robots[1].offset is [300.0, 256.0]: its arena leaves the mat"),
        ("[30, 256]", "[-1, 256]", "robots[1].offset is [-1.0, 256.0]: its arena leaves the mat"),
        ('type = "toio"\nport = "virtual:l', 'port = "virtual:l', "robots are of types khepera, toio; allowed: one"),
        ('port = "virtual:l', 'baud = 1\nport = "virtual:l', "robots[1].baud is given; allowed: for a robot with a"),
        ('"toio"\nport = "virtual:l', '"cube"\nport = "virtual:l', "robots[1].type is 'cube'; allowed: khepera, e"),
        ('type = "toio"', "", "food_cubes is given; allowed: for robots of type toio"),
        ('["virtual:food1", "virtual:food2"]', "[]", "food_cubes is empty; allowed with toio: a cube for each"),
        ('"virtual:food2"]', '"virtual:learner"]', "food_cubes has 'virtual:learner', which is given twice"),
    ],
)
def test_errors_in_the_file_name_the_key(old: str, new: str, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        parse(FILE.replace(old, new) + "[camera]\nsource = 0\n", SET_UP, 0.1)
