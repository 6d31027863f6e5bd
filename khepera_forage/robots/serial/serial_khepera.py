"""A real Khepera behind a serial port."""

from collections.abc import Callable
from queue import SimpleQueue
from types import TracebackType
from typing import Any, Self, TypeVar

from khepera_forage.robots.khepera import MAX_SPEED, Motors, RobotLost, Senses, applicable, check_finite
from khepera_forage.robots.serial import emergency_stop as stopping
from khepera_forage.robots.serial.line_events import Interrupted, LineCounts, Restarted, Traffic
from khepera_forage.robots.serial.link import SerialLink
from khepera_forage.robots.serial.port_thread import PortThread, Task
from khepera_forage.robots.serial.session import Dialogue

T = TypeVar("T")

BAUD = 38400
TIMEOUT = 0.1
TRIES = 6
_RESTARTS = 5
"""Restarts borne within one call: a supply that fails more often than that will not do."""
_STOPPING = 10.0
"""Seconds after which a port's thread that has not stopped its robot is given up."""


class SerialKhepera:
    """A `Robot` over a serial port, told and asked once a round by `transmit` and `receive`.

    What goes over the line in a round is what a step needs. `transmit` sends the wheels' speeds always (D; 12 bytes
    that also set a robot going again that was held, or that lost its supply unseen), arm and jaw (T,1,E and T,1,D) when
    they change. `receive` asks for proximity (N), optical barrier (T,1,G) and counters (H) always, and for the
    positions of arm and jaw (T,1,H) until they rest, then every tenth round. A surprising reading is asked for again;
    see `readings`.

    The wheels are stopped on every way out: `close`, `with`, an error, signals, the interpreter's exit; see `stopping`.
    A restart of the robot (its supply broke down) is noticed by its banner or by its counters. It is then told again
    what it was told before, and its counters are continued.

    All methods may be called from any thread; the port itself belongs to a thread of the robot's own.

    Args:
        port: What `serial.serial_for_url` takes: a device, `socket://host:port`, `rfc2217://host:port`.
        baud: 9600, 19200, 38400, 57600 or 115200, as the robot's mode switch is set.
        max_speed: Speed units that no wheel exceeds, 1..20.
        timeout: Seconds that a reply may take beyond the time that the bytes need on the wire.
        tries: The robot is lost when so many requests in a row bring no answer, or so many for the same thing.

    Raises:
        ValueError: An argument that is not allowed.
        ConnectionError: The port cannot be opened; as `RobotLost`, that nobody answers there.
        ImportError: pyserial is missing.
    """

    def __init__(
        self,
        port: str,
        *,
        baud: int = BAUD,
        max_speed: int = MAX_SPEED,
        timeout: float = TIMEOUT,
        tries: int = TRIES,
    ) -> None:
        if not 1 <= max_speed <= MAX_SPEED:
            raise ValueError(f"max_speed {max_speed}; allowed: 1..{MAX_SPEED} speed units")
        self.port = port
        self.baud = baud
        self._max_speed = max_speed
        self._command: Motors | None = None
        self._senses: Senses | None = None
        self._closed = False
        self._link = SerialLink(port, baud=baud, timeout=timeout, tries=tries)
        self._thread = PortThread(f"port {port}")
        self._link.interrupted = self._thread.pressing
        self._dialogue = Dialogue(self._link)
        stopping.watch(self)
        try:
            self._begin(self._dialogue.greet).result()
        except BaseException:
            self._let_go()
            raise

    @property
    def counts(self) -> LineCounts:
        """What happened on the line so far."""
        return self._link.wire.counts

    def listen(self, hear: Callable[[Traffic], None] | None) -> None:
        """Have all bytes that pass handed to a function, in the port's thread; None ends that."""
        self._link.wire.traffic = hear

    def drive(self, motors: Motors) -> Motors:
        """Remember a command for the next `transmit`.

        Returns:
            What will be applied: whole speed units within `max_speed`, arm within its travel, jaw open or shut.

        Raises:
            ValueError: A value that is not a finite number.
        """
        check_finite(motors)
        left, right, arm, jaw = applicable(motors)
        limit = self._max_speed
        self._command = Motors(max(-limit, min(limit, left)), max(-limit, min(limit, right)), arm, jaw)
        return self._command

    def sense(self) -> Senses:
        """What was last received; received now if nothing was yet.

        Raises:
            RobotLost: The robot does not answer.
        """
        if self._senses is None:
            self.receive()
        assert self._senses is not None
        return self._senses

    def transmit(self) -> None:
        """Send what was commanded.

        Raises:
            RobotLost: The robot does not answer.
        """
        self.begin_transmit().result()

    def receive(self) -> None:
        """Read what a step needs of the sensors.

        Raises:
            RobotLost: The robot does not answer.
        """
        self.begin_receive().result()

    def stop(self) -> None:
        """Wheels to zero, before anything else that the line is busy with; arm and jaw finish what they were told.

        Raises:
            RobotLost: The robot does not confirm it.
        """
        self.begin_stop().result(_STOPPING)

    def close(self) -> None:
        """Stop, and close the port; a second call does nothing. A robot that is lost is let go all the same."""
        if not self._closed:
            stopping.stop_and_tell((self,), "its closing")
            self._let_go()

    def ask(self, command: str, *values: int) -> tuple[int | str, ...]:
        """Ask or tell the robot anything else of the protocol.

        Returns:
            The values of its reply.

        Raises:
            ValueError: No such command, values out of range; or G or restart, which may not be repeated.
            RobotLost: No answer; `Refused` if the robot answers with an error.
        """
        return self._begin(lambda: self._dialogue.ask(command, *values)).result()

    def begin_transmit(self, finished: "SimpleQueue[Task[Any]] | None" = None) -> Task[None]:
        """Begin `transmit`; the task is put into the queue when it is done."""
        return self._begin(self._transmit, finished)

    def begin_receive(self, finished: "SimpleQueue[Task[Any]] | None" = None) -> Task[None]:
        """Begin `receive`; the task is put into the queue when it is done."""
        return self._begin(self._receive, finished)

    def begin_stop(self) -> Task[None]:
        """Begin `stop`; never blocks, so a signal handler may."""
        if self._command is not None:
            self._command = self._command._replace(left=0, right=0)
        return self._begin_halt(for_good=True)

    def begin_hold(self) -> Task[None]:
        """Begin to stop the wheels until the next `transmit`: the command stays."""
        return self._begin_halt(for_good=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _begin(self, work: Callable[[], T], finished: "SimpleQueue[Task[Any]] | None" = None) -> Task[T]:
        if self._closed:
            raise ConnectionError(f"{self.port} is closed")
        return self._thread.begin(Task(lambda: self._persist(work), finished))

    def _begin_halt(self, for_good: bool) -> Task[None]:
        task = Task(lambda: self._dialogue.stop(for_good))
        if self._closed:
            task = Task(lambda: None)  # It was stopped then.
            task.run()
            return task
        return self._thread.begin(task, urgent=True)

    def _let_go(self) -> None:
        self._closed = True
        stopping.unwatch(self)
        self._thread.end()
        self._link.close()

    # What follows runs in the port's thread.

    def _persist(self, work: Callable[[], T]) -> T:
        """Do it, from its beginning again after a stop that came between, or a restart."""
        restarts = 0
        while True:
            try:
                self._dialogue.set_up()
                return work()
            except Interrupted:
                self._thread.do_urgent()
                if self._thread.ending:
                    raise ConnectionError(f"{self.port} is closed") from None
            except Restarted:
                self._dialogue.restarted()
                restarts += 1
                if restarts > _RESTARTS:
                    reason = "it starts anew again and again"
                    raise RobotLost(self.port, "restart", restarts, reason) from None

    def _transmit(self) -> None:
        # Read here and not before: a stop that came between has changed it.
        command = self._command
        if command is not None:
            self._dialogue.transmit(command)

    def _receive(self) -> None:
        self._senses = self._dialogue.receive()
