"""The driver: a real Khepera behind a serial port."""

from collections.abc import Callable
from queue import SimpleQueue
from types import TracebackType
from typing import Any, Self, TypeVar

from khepera_forage.robots.khepera import MAX_SPEED, Motors, RobotLost, Senses, applicable, check_finite
from khepera_forage.robots.serial import emergency_stop
from khepera_forage.robots.serial.client import DEFAULT_BAUD, DEFAULT_TIMEOUT, DEFAULT_TRIES, ProtocolClient
from khepera_forage.robots.serial.errors import RequestInterrupted, RobotRestarted
from khepera_forage.robots.serial.port_thread import PortThread, Task
from khepera_forage.robots.serial.session import MAX_RESTARTS, TOO_MANY_RESTARTS, Session
from khepera_forage.robots.serial.traffic import LineStatistics, Traffic

T = TypeVar("T")

_STOP_TIMEOUT = 10.0
"""Seconds that `stop` waits for the port's thread."""


class SerialKhepera:
    """A `Robot` over a serial port; `transmit` and `receive` exchange the data of one round.

    `transmit` always sends the wheel speeds (D), so that a robot that was held, or that restarted unnoticed, moves
    again. It sends the targets of arm and jaw (T,1,E and T,1,D) when they change. `receive` always requests proximity
    (N), optical barrier (T,1,G) and counters (H). It requests the positions of arm and jaw (T,1,H) until they are at
    rest, then every tenth round. An implausible reading is requested again; see `readings`.

    The wheels are stopped on every exit path: `close`, `with`, an exception, signals, the exit of the interpreter; see
    `emergency_stop`. The driver notices a restart of the robot (its power supply failed) by the banner or by the
    counters. It then sends the last command again and continues the counters.

    All methods are thread-safe; the port itself belongs to one thread per robot.

    Args:
        port: Any argument of `serial.serial_for_url`: a device, `socket://host:port`, `rfc2217://host:port`.
        baud: 9600, 19200, 38400, 57600 or 115200, as set by the robot's mode switch.
        max_speed: Limit of the wheel speeds in speed units, 1..20.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes.
        tries: The robot counts as lost after this number of requests in a row without any reply, or of tries for the
            same request.

    Raises:
        ValueError: An argument that is not allowed.
        ConnectionError: The port cannot be opened; as `RobotLost`, that no robot replies.
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
    ) -> None:
        if not 1 <= max_speed <= MAX_SPEED:
            raise ValueError(f"max_speed {max_speed}; allowed: 1..{MAX_SPEED} speed units")
        self.port = port
        self.baud = baud
        self.timeout = timeout
        self._max_speed = max_speed
        self._command: Motors | None = None
        self._senses: Senses | None = None
        self._closed = False
        self._client = ProtocolClient(port, baud=baud, timeout=timeout, tries=tries)
        self._thread = PortThread(f"port {port}")
        self._client.interrupted = self._thread.must_yield
        self._session = Session(self._client)
        emergency_stop.register(self)
        try:
            self._begin(self._session.begin).result()
        except BaseException:
            self._release()
            raise

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

    def close(self) -> None:
        """Stop the wheels and close the port, even if the robot is lost; a second call does nothing."""
        if not self._closed:
            emergency_stop.stop_and_log((self,), "when its port was closed")
            self._release()

    def request(self, command: str, *values: int) -> tuple[int | str, ...]:
        """Send any other request of the protocol.

        Returns:
            The values of the reply.

        Raises:
            ValueError: An unknown command, values out of range; or G or restart, which may not be repeated.
            RobotLost: No reply; `RequestRejected` if the robot sends only error replies.
        """
        return self._begin(lambda: self._session.request(command, *values)).result()

    def begin_transmit(self, done_queue: "SimpleQueue[Task[Any]] | None" = None) -> Task[None]:
        """Begin `transmit`; the task is put into the queue when it is done."""
        return self._begin(self._transmit, done_queue)

    def begin_receive(self, done_queue: "SimpleQueue[Task[Any]] | None" = None) -> Task[None]:
        """Begin `receive`; the task is put into the queue when it is done."""
        return self._begin(self._receive, done_queue)

    def begin_stop(self) -> Task[None]:
        """Begin `stop`; never blocks, so signal handlers may call it."""
        if self._command is not None:
            self._command = self._command._replace(left=0, right=0)
        return self._submit_stop(discard_command=True)

    def begin_hold(self) -> Task[None]:
        """Begin to stop the wheels until the next `transmit`, which sends the same command again."""
        return self._submit_stop(discard_command=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _begin(self, work: Callable[[], T], done_queue: "SimpleQueue[Task[Any]] | None" = None) -> Task[T]:
        if self._closed:
            raise ConnectionError(f"{self.port} is closed")
        return self._thread.submit(Task(lambda: self._complete(work), done_queue))

    def _submit_stop(self, discard_command: bool) -> Task[None]:
        task = Task(lambda: self._session.stop(discard_command))
        if self._closed:
            task = Task(lambda: None)  # `close` has stopped the wheels.
            task.run()
            return task
        return self._thread.submit(task, urgent=True)

    def _release(self) -> None:
        self._closed = True
        emergency_stop.unregister(self)
        self._thread.end()
        self._client.close()

    # The methods below run in the port's thread.

    def _complete(self, work: Callable[[], T]) -> T:
        """Do the work; start over after an urgent stop or a restart of the robot."""
        restarts = 0
        while True:
            try:
                self._session.restore()
                return work()
            except RequestInterrupted:
                self._thread.run_urgent()
                if self._thread.ending:
                    raise ConnectionError(f"{self.port} is closed") from None
            except RobotRestarted:
                self._session.on_restart()
                restarts += 1
                if restarts > MAX_RESTARTS:
                    raise RobotLost(self.port, "restart", restarts, TOO_MANY_RESTARTS) from None

    def _transmit(self) -> None:
        # Read the command only now: `begin_stop` may have changed it since `begin_transmit`.
        command = self._command
        if command is not None:
            self._session.transmit(command)

    def _receive(self) -> None:
        self._senses = self._session.receive()
