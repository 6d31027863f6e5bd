"""The driver of toio cubes, on virtual cubes below toio-py."""

import pytest

pytest.importorskip("toio")

from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.mat import MatPose
from khepera_forage.robots.toio.driver import ToioRobot
from khepera_forage.robots.toio.virtual import RADIUS, VirtualTable, use_table


class SteppedTable:
    """A table with one cube, whose time passes only in `advance`."""

    def __init__(self) -> None:
        self.now = 0.0
        self.table = VirtualTable(lambda: self.now, interval=0.001)
        self.cube = self.table.cube("a", MatPose(200.0, 200.0, 0.0))
        use_table(self.table)

    def advance(self, seconds: float) -> None:
        self.now += seconds
        self.table.advance()

    def drive(self, robot: ToioRobot, left: int, right: int, rounds: int) -> None:
        for _ in range(rounds):
            robot.drive(Motors(left, right, 215, 0))
            robot.transmit()
            self.advance(0.1)
            robot.receive()


@pytest.fixture
def stepped() -> SteppedTable:
    return SteppedTable()


@pytest.mark.parametrize(("left", "right"), [(6, 6), (1, -1), (2, 2), (-3, 3)])
def test_wheels_turn_at_the_commanded_speed_and_counters_follow(stepped: SteppedTable, left: int, right: int) -> None:
    """A wheel does not turn slower than 4.8 speed units: slow speeds are short motions."""
    with ToioRobot("virtual:a") as robot:
        stepped.drive(robot, left, right, 20)
        senses, pose = robot.sense(), robot.pose
    assert senses.left_pulses == pytest.approx(left * 200, abs=110)
    assert senses.right_pulses == pytest.approx(right * 200, abs=110)
    assert pose.x - 200 == pytest.approx((senses.left_pulses + senses.right_pulses) / 2 * 0.08, abs=3)
    assert (senses.arm, senses.jaw, senses.object_presence) == (255, 200, 0)


@pytest.mark.parametrize(("period", "longest"), [(0.1, 0.3), (0.5, 1.0)])
def test_command_ends_by_itself(stepped: SteppedTable, period: float, longest: float) -> None:
    """A program that is killed, crashes or is frozen sends nothing more."""
    with ToioRobot("virtual:a", period=period) as robot:
        robot.drive(Motors(8, 8, 215, 200))
        robot.transmit()
        assert not robot.stop_confirmed
        stepped.advance(period)
        assert stepped.cube.turning
        stepped.advance(longest - period + 0.05)
        robot.receive()
        there = robot.pose
        stepped.advance(5.0)
        robot.receive()
        assert robot.pose == there


def test_stop_and_close_stop_the_cube(stepped: SteppedTable) -> None:
    for stop in (True, False):
        robot = ToioRobot("virtual:a")
        robot.drive(Motors(8, 8, 215, 200))
        robot.transmit()
        if stop:
            robot.stop()
            assert robot.stop_confirmed
        robot.close()
        assert not stepped.cube.turning


def test_cube_does_not_leave_its_walls(stepped: SteppedTable) -> None:
    with ToioRobot("virtual:a") as robot:
        robot.clearance = lambda x, y: 300.0 - x
        stepped.drive(robot, 8, 8, 60)
        assert 300.0 - 2 * RADIUS < robot.pose.x < 300.0 - RADIUS + 10


def test_cube_off_the_mat_keeps_its_last_place(stepped: SteppedTable) -> None:
    with ToioRobot("virtual:a") as robot:
        robot.receive()
        there = robot.pose
        stepped.cube.pose = MatPose(-100.0, 0.0, 0.0)
        robot.receive()
        assert not robot.on_mat
        assert robot.pose == there


def test_cube_that_is_not_found_is_reported_in_one_message(stepped: SteppedTable) -> None:
    stepped.table.unplugged.add("a")
    with pytest.raises(RobotLost, match=r"^virtual:a: it cannot be connected, .*: the cube does not advertise itself$"):
        ToioRobot("virtual:a")
