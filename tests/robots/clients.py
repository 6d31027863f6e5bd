"""A protocol client connected to a scripted robot."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.protocol import Reply
from tests.robots.scripted_robot import Action, ScriptedRobot


@contextmanager
def connected_client(
    script: Callable[[bytes, int], list[Action]], *, timeout: float = 0.08, tries: int = 6
) -> Iterator[tuple[ProtocolClient, ScriptedRobot]]:
    with ScriptedRobot(script) as scripted:
        client = ProtocolClient(scripted.url, baud=115200, timeout=timeout, tries=tries)
        try:
            yield client, scripted
        finally:
            client.close()


def reply_to_n(value: int) -> Reply:
    return Reply("N", (value,) * 8)
