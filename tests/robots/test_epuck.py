"""The driver of an e-puck2, connected to a virtual one."""

import itertools

import pytest

from khepera_forage.robots.epuck.driver import PROTOCOL as E_PUCK
from khepera_forage.robots.epuck.driver import SerialEPuck
from khepera_forage.robots.epuck.firmware import EPuckFirmware
from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.serial.protocol import Reply, Request
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from tests.robots.rig import make_rig

EXAMPLES = [
    (Request("D", (395, -79)), b"D,395,-79\r", Reply("D"), b"d\r\n"),
    (Request("N"), b"N\r", Reply("N", (0, -3, 4095, 1, 2, 3, 4, 5)), b"n,0,-3,4095,1,2,3,4,5\r\n"),
    (Request("Q"), b"Q\r", Reply("Q", (-32768, 65535)), b"q,-32768,65535\r\n"),
    (Request("V"), b"V\r", Reply("V", ("Version 2.0 January 2018",)), b"v,Version 2.0 January 2018\r\n"),
]


@pytest.mark.parametrize(("request_", "sent", "reply", "received"), EXAMPLES)
def test_bytes_of_commands(request_: Request, sent: bytes, reply: Reply, received: bytes) -> None:
    assert E_PUCK.encode_request(request_) == sent
    assert E_PUCK.decode_request(sent) == request_
    assert E_PUCK.encode_reply(reply) == received
    assert E_PUCK.decode_reply(received) == reply


def test_motion_and_counters_are_those_of_the_simulated_robot() -> None:
    with make_rig(kind=EPuckFirmware) as rig, SerialEPuck(rig.url, timeout=5.0) as robot:
        for motors in (Motors(5, 4, 215, 200), Motors(-3, 6, 255, 0)):
            for _ in range(20):
                assert robot.drive(motors)[:2] == motors[:2]
                robot.transmit()
                rig.advance()
                robot.receive()
                truth, senses = rig.robots[0].sense(), robot.sense()
                assert abs(senses.left_pulses - truth.left_pulses) <= 2
                assert abs(senses.right_pulses - truth.right_pulses) <= 2
                assert (senses.arm, senses.jaw) == (255, 200), "it has no gripper: the arm counts as lowered"
        assert robot.statistics.sent == robot.statistics.answered
        assert robot.statistics.garbled == 0
        robot.stop()
        assert rig.is_stopped()


def test_infra_reds_are_in_the_order_of_the_khepera() -> None:
    with make_rig(kind=EPuckFirmware) as rig, SerialEPuck(rig.url, watchdog=False) as robot:
        rig.intercept(lambda line: b"n,400,800,1200,1600,2000,2400,2800,3200\r\n" if line == b"N" else None)
        assert robot.sense().proximity == (600, 700, 800, 100, 200, 300, 400, 500)
        assert robot.sense().object_presence == 0
        robot.note_surroundings(True, None)
        assert robot.sense().object_presence == 255, "its front sensors and the camera show an object"


@pytest.mark.parametrize(("begin", "wrap"), [(30000, 2**15), (60000, 2**16)], ids=["signed", "unsigned"])
def test_counters_continue_across_16_bits(begin: int, wrap: int) -> None:
    counts = (n - 2**16 if n >= wrap else n for n in itertools.count(begin, 900))
    with make_rig(kind=EPuckFirmware) as rig, SerialEPuck(rig.url, watchdog=False) as robot:
        rig.intercept(lambda line: b"q,%d,0\r\n" % next(counts) if line == b"Q" else None)
        travelled = []
        for _ in range(12):
            robot.receive()
            travelled.append(robot.sense().left_pulses)
    steps = [later - earlier for earlier, later in itertools.pairwise(travelled)]
    assert steps == pytest.approx([900 * 0.1288 / (35 / 27.5) / 0.08] * 11, abs=1), "pulses of 0.08 mm"


def test_port_of_another_robot_is_refused_before_anything_moves() -> None:
    with make_rig() as rig, pytest.raises(RobotLost, match=r"is this the port of an e-puck2, .* selector") as lost:
        SerialEPuck(rig.url, baud=115200)
    assert "'V'" in str(lost.value)
    with make_rig(kind=EPuckFirmware) as rig:
        with pytest.raises(RobotLost, match=r"'B' .*is this the port of a Khepera"):
            SerialKhepera(rig.url, timeout=0.02)
        assert rig.is_stopped()
