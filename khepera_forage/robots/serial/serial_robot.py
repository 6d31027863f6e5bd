"""A robot at a serial port: what the drivers of Khepera and e-puck share."""

import time
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import ClassVar, TypeVar

from khepera_forage.extras import require
from khepera_forage.robots.khepera import CONTROL_PERIOD, Motors, RobotLost, Senses
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT, FAST, Line, LineTiming, RobotRestarted
from khepera_forage.robots.serial.protocol import Protocol, Reply, Request, wrap_counter
from khepera_forage.robots.serial.watchdog import Watchdog, start_watchdog

T = TypeVar("T")

STOP = Request("D", (0, 0))
MAX_UNATTENDED = 0.9
"""Seconds from a `transmit` after which no wheel turns if the following `receive` is not complete, whatever happens."""
HOLD_AFTER = 0.5
"""Seconds of waiting in a `transmit` and the following `receive`, together, after which the wheels are stopped."""
MAX_DURATION, _STOP_DURATION = 4.0, 2.0
"""Seconds after which a robot whose call, or stop, is not complete counts as lost; more with a longer timeout."""

LONGEST_ROUND = (8, 170)
"""Requests and bytes of a round in which arm and jaw move and all numbers have the maximum number of digits."""
_MAX_RESTARTS = 5
"""Restarts tolerated within one call; after more, the robot counts as lost: its power supply is unusable."""
_FLASH = 0.3
"""Seconds."""
_MOST_COUNTS = 1000
"""No counter changes by more in a round: after such a jump, counters nearer to zero than this were reset."""


class SerialRobot(RealRobot):
    """A `Robot` over a serial port. See `RealRobot`; the port belongs to the robot's thread.

    `transmit` always sends the wheel speeds, so that a robot that was held, or that restarted unnoticed, moves again. A
    robot whose replies are lost or late drives on at its last speed: its wheels are therefore stopped 0.5 s after the
    beginning of a call that is not complete, and *held* until the next `transmit`, like those of a robot in a fleet
    whose others are late: whatever would turn them is sent as a stop meanwhile. After a restart of the robot (its power
    supply failed), which the banner or the counters show, the driver sends the last command again. After a banner it
    continues the counters.

    Args:
        port: Any argument of `serial.serial_for_url`: a device, `socket://host:port`, `rfc2217://host:port`.
        baud: Of the line.
        max_speed: Limit of the wheel speeds in speed units.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes.
        watchdog: Whether a process stops the wheels when this one ends in any way or is frozen. `loop://` has none.
        period: Seconds of a round, which the line must keep; None accepts any line.

    Raises:
        ValueError: An argument that is not allowed.
        ConnectionError: The port cannot be opened; as `RobotLost`, that no robot replies; as `LineTooSlow`, that the
            line does not keep the period.
        ImportError: pyserial is missing.
    """

    protocol: ClassVar[Protocol]

    def __init__(
        self,
        port: str,
        *,
        baud: int | None = None,
        max_speed: int | None = None,
        timeout: float = DEFAULT_TIMEOUT,
        watchdog: bool = True,
        period: float | None = CONTROL_PERIOD,
    ) -> None:
        super().__init__(port, max_speed=max_speed, period=period)
        self.baud = self.protocol.baud if baud is None else baud
        self._base_timeout = timeout
        self._watchdog: Watchdog | None = None
        self._moves = False
        """Whether the last speeds that were sent turn the wheels."""
        self._held = self._must_restore = False
        self._hold_at = float("inf")
        self._time_left: float | None = None
        """Of the seconds after which wheels are held, what `transmit` has left to the following `receive`."""
        self._line = Line(
            port,
            self.protocol,
            baud=self.baud,
            timeout=timeout,
            replace=lambda request: STOP if self._held and request.command == STOP.command else request,
            check=self._check,
        )
        self.statistics = self._line.statistics
        self._raw_counts = self._counts = (0, 0)
        """The last reading of the counters; and the counts of the wheels, without wrap-around and restarts."""
        self._open(self._begin_session)
        if watchdog:
            self._watchdog = start_watchdog(port, self._line.descriptor, self.protocol.encode_request(STOP))

    @property
    def timing(self) -> LineTiming:
        """The latency of the line, and the time that a round takes on it."""
        return self._line.timing

    @property
    def longest_exchange(self) -> float:
        """See `RealRobot`."""
        return self._line.timeout + self.timing.duration(*LONGEST_ROUND)

    def request(self, command: str, *values: int) -> tuple[int | str, ...]:
        """Send any other request of the protocol; returns the values of the reply.

        Raises:
            ValueError: An unknown command, values out of range; or G or restart, which may not be repeated.
            RobotLost: No reply; `RequestRejected` if the robot sends only error replies.
        """
        return self.begin(lambda: self._request(Request(command, values))).result().values

    @staticmethod
    def find() -> list[str]:
        """See `RealRobot`."""
        require("a serial port", "robots")
        from serial.tools.list_ports import comports

        return [f"{port.device}   {port.description}" for port in comports()]

    def flash(self) -> None:
        """See `RealRobot`."""
        for action in (1, 0, 1, 0):
            for lamp in self.protocol.lamps:
                self.request("L", lamp, action)
            time.sleep(_FLASH)

    # The methods below run in the robot's thread.

    def _begin_session(self) -> None:
        """Check that a robot replies, stop its wheels, and measure the line."""
        try:
            self._line.measure(STOP)
        except RobotLost as lost:
            lost.args = (f"{lost}; {self.protocol.hint}",)
            raise
        self.stop_confirmed = True
        if self._period is not None:
            self.timing.check(self.port, self._period)

    def _begin_call(self, duration: float = MAX_DURATION, hold_after: float | None = None) -> None:
        """Begin a call, with the seconds until the robot counts as lost, and until its wheels are held."""
        now = self._line.now()
        self._line.deadline = now + duration * max(1.0, self._base_timeout / DEFAULT_TIMEOUT)
        self._hold_at = now + (self._hold_after if hold_after is None else hold_after)

    @property
    def _hold_after(self) -> float:
        """Seconds of waiting after which the wheels are held; who keeps the period pauses for the rest of it."""
        longest = max(HOLD_AFTER, self._base_timeout)
        if self._period is None:
            return longest
        return min(longest, MAX_UNATTENDED - (self._period - self.timing.round_time))

    def _check(self) -> None:
        """While waiting: pause for a stop, and hold the wheels of a robot that has not replied in time."""
        self._check_interruption()
        now = self._line.now()
        if now >= self._hold_at and not self.stop_confirmed:
            self._hold_at = now + self._hold_after
            self._held = True
            self._line.send_aside(STOP)

    def _attempt(self, work: Callable[[], T], restore: bool = True) -> T:
        """Run work; after a restart of the robot, send the last command again and run it from its beginning."""
        restarts = 0
        while True:
            try:
                # Sent twice, the command would turn wheels that were held meanwhile.
                if restore and self._must_restore and work != self._transmit:
                    self._transmit(self._held)
                return work()
            except RobotRestarted:
                self._must_restore = True
                self._raw_counts = 0, 0
                restarts += 1
                if restarts > _MAX_RESTARTS:
                    raise RobotLost(self.port, "restart", restarts, "it restarts again and again") from None

    def _transmit(self, held: bool = False) -> None:
        """Send the command; as a stop if the wheels are held."""
        command = self._command
        if command is None:
            return
        self._begin_call()
        self._held, self._moves = held, not held and any(command[:2])
        if self._moves:
            self.stop_confirmed = False
        if self._must_restore:
            self._note_sent(None)
        requests = self._requests(command)
        # A fast line confirms the speeds at once: after a lost request the wheels would keep their last speeds.
        if self.timing.latency <= FAST or not self.timing.pipelined:
            self._exchange(requests)
        else:
            self._line.send_ahead(requests)
        self._note_sent(command)
        self._must_restore = False
        self._time_left = self._hold_at - self._line.now()

    def _receive(self) -> None:
        self._begin_call(hold_after=self._time_left)
        self._senses = self._read_senses()
        self._time_left = None

    def _exchange(self, requests: Sequence[Request]) -> list[Reply]:
        """Send requests; returns their replies, once those to the last command have arrived, too."""
        replies = self._line.exchange(requests)
        if not (self._moves or self._held):
            self.stop_confirmed = True
        return replies

    def _request(self, request: Request) -> Reply:
        self._begin_call()
        if request.command == STOP.command:
            self._moves = any(request.values)
            if self._moves:
                self._held = self.stop_confirmed = False
        return self._exchange([request])[0]

    def _count(self, left: int, right: int) -> None:
        """Add a reading of the counters; the next one corrects one whose digits were changed."""
        reading, bits = (left, right), self.protocol.counters[1]
        changes = [wrap_counter(new - old, bits) for new, old in zip(reading, self._raw_counts, strict=True)]
        # Perhaps a restart whose banner was lost: a command that is sent twice does no harm.
        self._must_restore |= max(map(abs, changes)) > _MOST_COUNTS > max(map(abs, reading))
        self._counts = self._counts[0] + changes[0], self._counts[1] + changes[1]
        self._raw_counts = reading

    def _stop_wheels(self) -> None:
        self._begin_call(_STOP_DURATION)
        self._held = True
        if self._line.forget_ahead():
            self._note_sent(None)  # Their replies can no longer be told from others: send them again.
        self._attempt(lambda: self._line.exchange([STOP]), restore=False)
        self._moves, self.stop_confirmed = False, True

    def _disconnect(self) -> None:
        if self._watchdog is not None:
            self._watchdog.end()
        self._line.close()

    # What differs between the robots.

    @abstractmethod
    def _requests(self, command: Motors) -> list[Request]:
        """The requests that transmit a command, the wheel speeds first."""

    @abstractmethod
    def _read_senses(self) -> Senses:
        """Request all readings."""

    def _note_sent(self, command: Motors | None) -> None:
        """Record that a command was sent; None if what was sent is lost, and must be sent again completely."""
