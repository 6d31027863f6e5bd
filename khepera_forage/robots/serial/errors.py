"""Exceptions of a serial connection, in addition to `RobotLost`."""

from khepera_forage.robots.khepera import RobotLost


class RobotRestarted(Exception):  # noqa: N818 (an event, not an error)
    """The robot sent its restart banner: its wheels are stopped and its settings are lost."""


class RequestInterrupted(Exception):  # noqa: N818
    """An urgent task needs the port; the interrupted request must be sent again afterwards."""


class RequestRejected(RobotLost):
    """The robot sends only error replies: it lacks the command, or the turret that the command addresses."""
