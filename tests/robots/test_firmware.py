"""The ROM: what a Khepera answers, byte for byte, and what it does."""

import math
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.command_table import COMMANDS, RESTART
from khepera_forage.robots.serial.protocol import (
    BANNER,
    BannerLine,
    Lines,
    Refusal,
    Reply,
    decode_reply,
    decode_request,
)
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.world import Layout
from tests.robots.stage import Stage, staged

AT_POWER_ON = {
    "A,1,2,3": "a",
    "B": "b,5.02,5.01",
    "C,100,100": "c",
    "D,5,-5": "d",
    "E": "e,0,0",
    "F,1,2,3": "f",
    "G,10,-10": "g",
    "H": "h,0,0",
    "I,3": "i,0",
    "J,10,32,10,32": "j",
    "K": "k,0,0,0,0,0,0",
    "L,0,2": "l",
    "N": "n,0,0,0,0,0,0,0,0",
    "O": "o,500,500,500,500,500,500,500,500",
    "P,40,-40": "p",
    "R,32": "r,0",
    "W,170,32": "w",
    "T,1,B": "t,1,b,2,1",
    "T,1,D,1": "t,1,d",
    "T,1,E,255": "t,1,e",
    "T,1,F": "t,1,f,255",
    "T,1,G": "t,1,g,0",
    "T,1,H,0": "t,1,h,200",
    "T,1,H,1": "t,1,h,215",
    "T,1,J": "t,1,j,0",
}
"""A request and its reply, each to a robot that has just been switched on, on open floor."""


@pytest.mark.parametrize("line", AT_POWER_ON)
def test_every_reply_byte_for_byte(stage: Stage, line: str) -> None:
    for ending in ("", "\n", "\r", "\r\n"):
        fresh = staged()
        assert fresh.firmware.answer((line + ending).encode()) == AT_POWER_ON[line].encode() + b"\r\n"


def test_every_command_is_answered() -> None:
    commands = {decode_request(line.encode()).command for line in AT_POWER_ON}
    assert commands | {RESTART} == set(COMMANDS)


@pytest.mark.parametrize("line", ["M", "Q", "d,5,5", "restar", "T,1,C", "T,1,K", "", "\xff", "hello"])
def test_commands_that_there_are_not(stage: Stage, line: str) -> None:
    assert stage.firmware.answer(line.encode("latin-1")) == b"z,Command not found\r\n"


@pytest.mark.parametrize(
    "line",
    ["D", "D,5", "D,5,5,5", "D,5,128", "D,5, 5", "N,1", "L,2,0", "T", "T,1", "T,2,N", "T,1,E,256", "T,1,H"],
)
def test_commands_with_the_wrong_values(stage: Stage, line: str) -> None:
    assert stage.firmware.answer(line.encode()) == b"z,Protocol error\r\n"


@given(st.one_of(st.binary(max_size=40), st.sampled_from(sorted(AT_POWER_ON)).map(str.encode)))
def test_any_bytes_get_a_reply_that_a_host_can_read(line: bytes) -> None:
    answered = _FUZZED.firmware.answer(line)
    assert answered.endswith(b"\r\n")
    for reply in Lines().feed(answered):
        assert isinstance(decode_reply(reply), Reply | Refusal | BannerLine)


_FUZZED = staged()


class TestSpeed:
    def test_a_speed_holds_until_another_is_set(self, stage: Stage) -> None:
        stage.ask("D,5,10")
        stage.rounds(30)
        assert stage.numbers("H") == [1500, 3000]
        assert stage.numbers("E") == [5, 10]
        stage.ask("D,0,0")
        assert stage.numbers("E") == [5, 10], "as measured in the last period"
        stage.rounds(1)
        assert stage.numbers("E") == [0, 0]
        stage.rounds(5)
        assert stage.numbers("H") == [1500, 3000]

    def test_the_simulated_wheels_turn_no_faster_than_they_can(self, stage: Stage) -> None:
        assert stage.ask("D,127,-127") == "d"
        stage.rounds(1)
        assert stage.numbers("E") == [20, -20]

    def test_pwm_is_a_speed(self, stage: Stage) -> None:
        stage.ask("P,20,-20")
        stage.rounds(1)
        assert stage.numbers("E") == [10, -10]

    def test_wheels_arm_and_jaw_are_commanded_apart(self, stage: Stage) -> None:
        stage.ask("T,1,E,255")
        stage.ask("D,3,3")
        stage.ask("T,1,D,1")
        stage.rounds(25)
        assert stage.numbers("E") == [3, 3]
        assert stage.numbers("T,1,H,1") == [255]
        assert stage.numbers("T,1,H,0") == [0]


class TestCounters:
    def test_they_are_set_and_go_on_from_there(self, stage: Stage) -> None:
        stage.ask("D,5,-5")
        stage.rounds(4)
        stage.ask("G,1000,-1000")
        assert stage.numbers("H") == [1000, -1000]
        stage.rounds(4)
        assert stage.numbers("H") == [1200, -1200]

    def test_they_wrap_at_32_bits(self, stage: Stage) -> None:
        stage.ask(f"G,{2**31 - 1},{-(2**31)}")
        stage.ask("D,1,-1")
        stage.rounds(1)
        assert stage.numbers("H") == [-(2**31) + 9, 2**31 - 10]


class TestPositionControl:
    def test_the_robot_drives_to_its_target(self, stage: Stage) -> None:
        stage.ask("C,1250,1250")
        assert stage.numbers("K")[:3] == [0, 1, 1250]
        stage.rounds(40)
        target, mode, error = stage.numbers("K")[:3]
        assert (target, mode) == (1, 1)
        assert abs(error) <= 5
        assert math.dist(stage.world.poses()[0][:2], (300.0, 300.0)) < 1.0, "1250 pulses of 0.08 mm"
        assert stage.numbers("E") == [0, 0]

    def test_it_turns_on_the_spot(self, stage: Stage) -> None:
        quarter = round(math.pi / 2 * 53 / 2 / 0.08)
        stage.ask(f"C,{-quarter},{quarter}")
        stage.rounds(40)
        assert abs(stage.world.poses()[0].heading - math.pi / 2) < 0.03

    def test_a_profile_slows_it(self, stage: Stage) -> None:
        stage.ask("J,4,64,4,64")
        stage.ask("C,2000,2000")
        speeds = []
        for _ in range(20):
            stage.rounds(1)
            speeds += stage.numbers("E")
        assert max(speeds) == 4

    def test_the_target_counts_from_where_the_counter_was_set(self, stage: Stage) -> None:
        stage.ask("G,5000,5000")
        stage.ask("C,4000,4000")
        stage.rounds(40)
        assert math.dist(stage.world.poses()[0][:2], (120.0, 300.0)) < 1.0

    def test_setting_the_counters_on_the_way_moves_the_goal(self, stage: Stage) -> None:
        stage.ask("C,3000,3000")
        stage.rounds(4)
        driven = stage.numbers("H")[0]
        stage.ask("G,0,0")
        stage.rounds(2)
        assert 5 < stage.numbers("E")[0] < 18, "no leap to make good what was only counted"
        stage.rounds(40)
        assert abs(stage.numbers("H")[0] - 3000) <= 5
        assert math.dist(stage.world.poses()[0][:2], (200.0 + (driven + 3000) * 0.08, 300.0)) < 1.0

    def test_a_speed_ends_it(self, stage: Stage) -> None:
        stage.ask("C,5000,5000")
        stage.rounds(5)
        stage.ask("D,0,0")
        stage.rounds(1)
        before = stage.numbers("H")
        stage.rounds(10)
        assert stage.numbers("H") == before
        assert stage.numbers("K")[1] == 0

    def test_the_arm_can_be_moved_meanwhile(self, stage: Stage) -> None:
        stage.ask("C,1000,1000")
        stage.ask("T,1,E,255")
        stage.rounds(40)
        assert stage.numbers("T,1,H,1") == [255]
        assert stage.numbers("K")[0] == 1


class TestGripper:
    def test_replies_come_at_once_and_the_motion_takes_its_time(self, stage: Stage) -> None:
        assert stage.ask("T,1,E,255") == "t,1,e"
        assert stage.ask("T,1,D,1") == "t,1,d"
        assert (stage.numbers("T,1,H,1"), stage.numbers("T,1,H,0")) == ([215], [200])
        stage.rounds(3)
        assert 215 < stage.numbers("T,1,H,1")[0] < 255
        assert 0 < stage.numbers("T,1,H,0")[0] < 200
        stage.rounds(20)
        assert (stage.numbers("T,1,H,1"), stage.numbers("T,1,H,0")) == ([255], [0])

    def test_positions_that_the_simulated_arm_has_not_are_the_nearest_it_has(self, stage: Stage) -> None:
        assert stage.ask("T,1,E,0") == "t,1,e"
        stage.rounds(20)
        assert stage.numbers("T,1,H,1") == [215]

    def test_food_is_seen_gripped_and_carried(self) -> None:
        stage = staged(food_ahead=57.0)
        assert stage.numbers("T,1,G") == [0], "the raised arm is above it"
        stage.ask("T,1,E,255")
        stage.rounds(12)
        assert stage.numbers("T,1,G")[0] > 100
        stage.ask("T,1,D,1")
        stage.rounds(8)
        assert 100 < stage.numbers("T,1,H,0")[0] < 150, "closed on 35 mm"
        stage.ask("T,1,E,215")
        stage.rounds(12)
        stage.ask("D,5,5")
        stage.rounds(10)
        food = stage.world.food_places()[0]
        assert food.lifted
        assert math.dist((food.x, food.y), (297.0, 300.0)) < 3.0

    def test_a_firmware_that_starts_with_a_full_gripper_lets_go_of_nothing(self) -> None:
        stage = staged(food_ahead=57.0)
        for line, rounds in (("T,1,E,255", 12), ("T,1,D,1", 8), ("T,1,E,215", 12)):
            stage.ask(line)
            stage.rounds(rounds)
        again = stage._replace(firmware=type(stage.firmware)(stage.robot, stage.lock))
        again.ask("D,2,2")
        again.rounds(10)
        assert again.world.food_places()[0].lifted


class TestPowerOn:
    def test_the_banner_comes_and_everything_is_forgotten(self, stage: Stage) -> None:
        for line in ("A,1,2,3", "F,4,5,6", "J,1,1,1,1", "L,0,1", "W,9,9", "G,77,77", "D,8,8"):
            stage.ask(line)
        stage.rounds(5)
        banner = stage.firmware.answer(b"restart")
        assert banner == b"".join(line.encode() + b"\r\n" for line in BANNER)
        assert banner.startswith(b"ROM of minirobot KHEPERA")
        registers = stage.firmware.registers
        assert (registers.speed_gains, registers.position_gains) == ((3800, 800, 100), (3000, 20, 4000))
        assert registers.leds == [False, False]
        assert stage.numbers("R,9") == [0]
        assert stage.numbers("H") == [0, 0]
        assert stage.numbers("E") == [0, 0]
        stage.rounds(5)
        assert stage.numbers("H") == [0, 0], "the wheels stand"

    def test_it_stops_position_control(self, stage: Stage) -> None:
        stage.ask("C,3000,3000")
        stage.rounds(5)
        assert stage.firmware.power_on().startswith(b"ROM of")
        stage.rounds(10)
        assert stage.numbers("H") == [0, 0]

    def test_the_gripper_finishes_what_it_was_told(self, stage: Stage) -> None:
        stage.ask("T,1,E,255")
        stage.rounds(2)
        stage.firmware.power_on()
        stage.rounds(20)
        stage.ask("D,1,1")
        stage.rounds(20)
        assert stage.numbers("T,1,H,1") == [255]


def test_what_was_set_is_kept(stage: Stage) -> None:
    stage.ask("A,1,2,3")
    stage.ask("F,4,5,6")
    assert stage.firmware.registers.speed_gains == (1, 2, 3)
    assert stage.firmware.registers.position_gains == (4, 5, 6)
    for action, on in ((1, True), (2, False), (2, True), (0, False)):
        stage.ask(f"L,1,{action}")
        assert stage.firmware.registers.leds == [False, on]
    stage.ask("W,170,32")
    assert stage.numbers("R,32") == [170]
    assert stage.numbers("R,33") == [0]
    stage.firmware.registers.analogue[2] = 1023
    assert stage.numbers("I,2") == [1023]


def test_proximity_is_what_the_robot_senses() -> None:
    stage = staged()
    stage.world.place(0, Pose(330.0, 567.0, 0.0))
    stage.rounds(1)
    values = stage.numbers("N")
    assert values == list(stage.robot.sense().proximity)
    assert values[0] > 500, "the wall is on the left"
    assert values[5] == 0


def test_another_body_carries_on(stage: Stage) -> None:
    stage.ask("T,1,E,255")
    stage.ask("D,5,5")
    stage.rounds(20)
    stage.world.reset(np.random.default_rng(1), Layout((Pose(300.0, 200.0, 1.0),), (Point(600.0, 560.0),)))
    stage.firmware.attach(stage.robot)
    assert stage.numbers("H") == [1000, 1000]
    stage.rounds(20)
    assert stage.numbers("H") == [2000, 2000]
    assert stage.numbers("T,1,H,1") == [255]


def test_asked_from_threads_while_the_world_advances(stage: Stage) -> None:
    """Each thread sets a register of its own and reads back what it set; the world goes on meanwhile."""
    wrong: list[str] = []

    def talk(address: int) -> None:
        for value in range(200):
            stage.ask(f"W,{value},{address}")
            stage.ask("D,5,5")
            if stage.numbers(f"R,{address}") != [value] or stage.numbers("E") not in ([0, 0], [5, 5]):
                wrong.append(f"{address}: {value}")

    threads = [threading.Thread(target=talk, args=(address,)) for address in range(4)]
    for thread in threads:
        thread.start()
    for _ in range(20):
        with stage.lock:
            stage.world.advance()
            stage.firmware.tick()
    for thread in threads:
        thread.join()
    assert not wrong
