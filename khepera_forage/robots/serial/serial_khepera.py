"""The driver: a real Khepera behind a serial port."""

from collections.abc import Callable
from queue import SimpleQueue
from types import TracebackType
from typing import Any, Self

from khepera_forage.robots.khepera import CONTROL_PERIOD, MAX_SPEED, Motors, Senses, applicable, check_finite
from khepera_forage.robots.serial import emergency_stop
from khepera_forage.robots.serial.call_limits import MOTION_COMMANDS, turns_wheels
from khepera_forage.robots.serial.client import DEFAULT_BAUD, DEFAULT_TIMEOUT, DEFAULT_TRIES, ProtocolClient
from khepera_forage.robots.serial.line_timing import LineTiming
from khepera_forage.robots.serial.port_thread import Task
from khepera_forage.robots.serial.protocol import Request
from khepera_forage.robots.serial.robot_thread import RobotThread
from khepera_forage.robots.serial.traffic import LineStatistics, Traffic
from khepera_forage.robots.serial.watchdog import Watchdog, start_watchdog

_STOP_TIMEOUT = 10.0
"""Seconds that `stop` waits for the port's thread."""


class SerialKhepera:
    """A `Robot` over a serial port; `transmit` and `receive` exchange the data of one round.

    `transmit` always sends the wheel speeds (D), so that a robot that was held, or that restarted unnoticed, moves
    again. It sends the targets of arm and jaw (T,1,E and T,1,D) when they change. `receive` always requests proximity
    (N), optical barrier (T,1,G) and counters (H). It requests the positions of arm and jaw (T,1,H) until they are at
    rest, then every tenth round. An implausible reading is requested again; see `readings`.

    The wheels are stopped on every exit path: `close`, `with`, an exception, signals, the exit of the interpreter; see
    `emergency_stop`. A `watchdog` process stops them if this process is killed or frozen. After a suspension (Ctrl-Z)
    they remain stopped, and the next request raises `RobotSuspended` once. The driver notices a restart of the robot
    (its power supply failed) by the banner or by the counters. It then sends the last command again and continues the
    counters.

    All methods are thread-safe; the port itself belongs to one thread per robot.

    Args:
        port: Any argument of `serial.serial_for_url`: a device, `socket://host:port`, `rfc2217://host:port`.
        baud: 9600, 19200, 38400, 57600 or 115200, as set by the robot's mode switch.
        max_speed: Limit of the wheel speeds in speed units, 1..20.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes.
        tries: The robot counts as lost after this number of requests in a row without any reply, or of tries for the
            same request.
        watchdog: Whether to start a watchdog process. A port without a file descriptor (`loop://`) cannot have one.
        period: Seconds of a round, which the line must keep; None accepts any line. It is also the time that a wheel
            turns from one reading of its counter to the next.

    Raises:
        ValueError: An argument that is not allowed.
        ConnectionError: The port cannot be opened; as `RobotLost`, that no robot replies; as `LineTooSlow`, that the
            line does not keep the period.
        ImportError: pyserial is missing.
    """

    def __init__(
        self,
        port: str,
        *,
        baud: int = DEFAULT_BAUD,
        max_speed: int = MAX_SPEED,
        timeout: float = DEFAULT_TIMEOUT,
        tries: int = DEFAULT_TRIES,
        watchdog: bool = True,
        period: float | None = CONTROL_PERIOD,
    ) -> None:
        if not 1 <= max_speed <= MAX_SPEED:
            raise ValueError(f"max_speed {max_speed}; allowed: 1..{MAX_SPEED} speed units")
        self.port = port
        self.baud = baud
        self._max_speed = max_speed
        self._command: Motors | None = None
        self._senses: Senses | None = None
        self._closed = self._turned_by_request = False
        self._watchdog: Watchdog | None = None
        self._client = ProtocolClient(port, baud=baud, timeout=timeout, tries=tries)
        self._thread = RobotThread(self._client, period)
        emergency_stop.register(self)
        try:
            self._thread.begin(self._thread.session.begin).result()
            if watchdog:
                self._watchdog = start_watchdog(port, self._client.transport.descriptor)
        except BaseException:
            self._release()
            raise

    @property
    def stop_confirmed(self) -> bool:
        """Whether the robot has confirmed a stop, and was sent no command since that turns its wheels."""
        return self._thread.session.stop_confirmed

    @property
    def timing(self) -> LineTiming:
        """The latency of the line, and the time that a round takes on it."""
        return self._thread.session.timing

    @property
    def timeout(self) -> float:
        """Seconds that a reply may take in addition to the transmission time; on a slow line more than the argument."""
        return self._client.timeout

    @property
    def statistics(self) -> LineStatistics:
        """Counts of events on the line so far."""
        return self._client.transport.statistics

    def on_traffic(self, callback: Callable[[Traffic], None] | None) -> None:
        """Call a function, in the port's thread, with all bytes sent and received; None ends that."""
        self._client.transport.on_traffic = callback

    def drive(self, motors: Motors) -> Motors:
        """Set the command for the next `transmit`.

        Returns:
            The command as it will be sent: whole speed units within `max_speed`, arm within its travel, jaw open or
            closed.

        Raises:
            ValueError: A value that is not a finite number.
        """
        check_finite(motors)
        left, right, arm, jaw = applicable(motors)
        limit = self._max_speed
        self._command = Motors(max(-limit, min(limit, left)), max(-limit, min(limit, right)), arm, jaw)
        return self._command

    def sense(self) -> Senses:
        """The senses of the last `receive`; calls it if there was none.

        Raises:
            RobotLost: The robot does not reply.
        """
        if self._senses is None:
            self.receive()
        assert self._senses is not None
        return self._senses

    def transmit(self) -> None:
        """Send the last command.

        Raises:
            RobotLost: The robot does not reply.
        """
        self.begin_transmit().result()

    def receive(self) -> None:
        """Read the sensors.

        Raises:
            RobotLost: The robot does not reply.
        """
        self.begin_receive().result()

    def stop(self) -> None:
        """Stop the wheels, before any other request; arm and jaw still move to their last targets.

        Raises:
            RobotLost: The robot does not confirm.
        """
        self.begin_stop().result(_STOP_TIMEOUT)

    def close(self, stop: bool = True) -> None:
        """Stop the wheels and close the port, even if the robot is lost; a second call does nothing.

        Args:
            stop: False for a robot that was just stopped.
        """
        if not self._closed:
            if stop:
                emergency_stop.stop_and_log((self,), emergency_stop.PORT_CLOSED)
            self._release()

    def request(self, command: str, *values: int) -> tuple[int | str, ...]:
        """Send any other request of the protocol.

        Returns:
            The values of the reply.

        Raises:
            ValueError: An unknown command, values out of range; or G or restart, which may not be repeated.
            RobotLost: No reply; `RequestRejected` if the robot sends only error replies.
        """
        if command in MOTION_COMMANDS:
            self._turned_by_request = turns_wheels(Request(command, values))
        return self._thread.begin(lambda: self._thread.session.request(command, *values)).result()

    def begin_transmit(self, done_queue: "SimpleQueue[Task[Any]] | None" = None) -> Task[None]:
        """Begin `transmit`; the task is put into the queue when it is done."""
        return self._thread.begin(self._transmit, done_queue)

    def begin_receive(self, done_queue: "SimpleQueue[Task[Any]] | None" = None) -> Task[None]:
        """Begin `receive`; the task is put into the queue when it is done."""
        return self._thread.begin(self._receive, done_queue)

    def suspend(self) -> bool:
        """Make the next request raise `RobotSuspended` if the wheels are turning; `begin_stop` stops them.

        Returns:
            Whether they are turning.
        """
        turning = self._turned_by_request or (self._command is not None and any(self._command[:2]))
        self._thread.was_suspended = self._thread.was_suspended or turning
        return turning

    def end_watchdog(self) -> None:
        """End the watchdog: the wheels were stopped. A second call does nothing."""
        if self._watchdog is not None:
            self._watchdog.end()

    def begin_stop(self) -> Task[None]:
        """Begin `stop`; never blocks, so signal handlers may call it."""
        self._turned_by_request = False
        if self._command is not None:
            self._command = self._command._replace(left=0, right=0)
        return self._thread.begin_stop(discard_command=True)

    def begin_hold(self) -> Task[None]:
        """Begin to stop the wheels until the next `transmit`, which sends the same command again."""
        return self._thread.begin_stop(discard_command=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _release(self) -> None:
        self._closed = True
        emergency_stop.unregister(self)
        self._thread.end()
        self.end_watchdog()
        self._client.close()

    # The methods below run in the port's thread.

    def _transmit(self) -> None:
        # Read the command only now: `begin_stop` may have changed it since `begin_transmit`.
        command = self._command
        if command is not None:
            self._thread.session.transmit(command)

    def _receive(self) -> None:
        self._senses = self._thread.session.receive()
