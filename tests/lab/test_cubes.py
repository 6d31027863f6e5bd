"""A laboratory of toio cubes: no camera, no person; robots and food drive to their places by themselves."""

import math

import numpy as np
import pytest

pytest.importorskip("toio")
pytest.importorskip("cv2")

from khepera_forage.lab.clock import SimulatedClock
from khepera_forage.lab.cube_operator import CubeOperator
from khepera_forage.lab.laboratory import Laboratory
from khepera_forage.lab.operator import OperatorGaveUp
from khepera_forage.lab.settings_file import LabFileError, parse
from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.toio.driver import ToioRobot
from khepera_forage.robots.toio.mat import SIMPLE_MAT
from khepera_forage.robots.toio.virtual import Table, use_table
from khepera_forage.sim.world import Layout
from tests.version_0_1 import SET_UP

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


class CubeLaboratory:
    """A laboratory on a table with a clock of its own."""

    def __init__(self) -> None:
        self.now = 0.0
        self.table = Table(SIMPLE_MAT, lambda: self.now, interval=0.001)
        use_table(self.table)
        self.lab = Laboratory(
            parse(FILE, SET_UP, 0.1),
            CubeOperator(self.robots, self.foods, self.sleep),
            clock=SimulatedClock(lambda: self.sleep(0.1)),
        )
        arenas = self.lab.arenas
        self.layout = Layout(tuple(a.start for a in arenas), tuple(f for a in arenas for f in a.foods))

    def robots(self) -> list[ToioRobot]:
        return self.lab._devices.cubes

    def foods(self) -> list[ToioRobot]:
        return self.lab._devices.foods

    def sleep(self, seconds: float) -> None:
        self.now += seconds
        self.table.advance()


def test_cubes_drive_to_their_places_for_every_episode_and_are_sensed() -> None:
    cubes = CubeLaboratory()
    with cubes.lab as lab:
        for seed in range(2):
            lab.reset(np.random.default_rng(seed), cubes.layout)
            for pose, start in zip(lab.poses(), cubes.layout.starts, strict=True):
                assert math.dist(pose[:2], start[:2]) <= 15
                assert abs(math.degrees(pose.heading - start.heading)) <= 10
            for food, place in zip(lab.food_places(), cubes.layout.foods, strict=True):
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
            assert not any(cubes.table.cube(name).turning for name in ("teacher", "learner"))


def test_lost_cube_stops_all_and_takes_a_person() -> None:
    cubes = CubeLaboratory()
    with cubes.lab as lab:
        lab.reset(np.random.default_rng(0), cubes.layout)
        cubes.table.unplugged.add("learner")
        with pytest.raises(RobotLost, match="virtual:learner"):
            lab.advance()
        assert not cubes.table.cube("teacher").turning
        with pytest.raises(OperatorGaveUp, match="this needs a person: reconnect what was lost"):
            lab.reset(np.random.default_rng(1), cubes.layout)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("offset = [30, 256]", "offset = [300, 256]"),
            r"robots[1].offset is [300.0, 256.0]: its arena leaves the mat",
        ),
        (
            ('type = "toio"\nport = "virtual:l', 'port = "virtual:l'),
            "robots are of types khepera, toio; allowed: toio",
        ),
        (
            ('port = "virtual:l', 'baud = 9600\nport = "virtual:l'),
            "robots[1].baud is given; allowed: for a robot with a",
        ),
        (
            ('type = "toio"\nport = "virtual:l', 'type = "cube"\nport = "virtual:l'),
            "robots[1].type is 'cube'; allowed: k",
        ),
    ],
)
def test_errors_in_the_file_name_the_key(change: tuple[str, str], message: str) -> None:
    with pytest.raises(LabFileError) as error:
        parse(FILE.replace(*change), SET_UP, 0.1)
    assert message in str(error.value)


def test_food_cubes_need_toio_robots() -> None:
    with pytest.raises(LabFileError, match="food_cubes is given; allowed: for robots of type toio"):
        parse('food_cubes = ["a"]\n[camera]\nsource = 0\n[[robots]]\nport = "/dev/a"\n', SET_UP, 0.1)
