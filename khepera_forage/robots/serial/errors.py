"""Exceptions of a serial connection, in addition to `RobotLost`."""

from khepera_forage.robots.khepera import RobotLost


class RobotRestarted(Exception):  # noqa: N818 (an event, not an error)
    """The robot sent its restart banner: its wheels are stopped and its settings are lost."""


class RequestInterrupted(Exception):  # noqa: N818
    """An urgent task needs the port; the interrupted request must be sent again afterwards."""


class RequestRejected(RobotLost):
    """The robot sends only error replies: it lacks the command, or the turret that the command addresses."""


class RobotSuspended(RobotLost):
    """The program was suspended while the wheels turned; they were stopped, and a new command starts them again."""

    def __init__(self, port: str) -> None:
        super().__init__(port, "", 0, "the program was suspended, and the robot was stopped")


class LineTooSlow(ConnectionError):  # noqa: N818
    """The latency of a line does not allow rounds of the required duration."""
