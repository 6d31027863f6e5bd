"""The session with a Khepera: the requests of a round, in their order, and the state kept between rounds.

Runs in the thread that owns the port.
"""

import time

from khepera_forage.robots.khepera import CONTROL_PERIOD, JAW_OPEN, Motors, RobotLost, Senses
from khepera_forage.robots.serial.call_limits import HOLD_AFTER, STOP, CallLimits, turns_wheels
from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.errors import RobotRestarted
from khepera_forage.robots.serial.line_timing import MAX_ROUND_BYTES, LineTimer, LineTiming
from khepera_forage.robots.serial.protocol import Reply, Request, encode_reply, encode_request
from khepera_forage.robots.serial.sensor_reader import SensorReader

MAX_RESTARTS = 5
"""Restarts tolerated within one call; after more, the robot counts as lost: its power supply is unusable."""
TOO_MANY_RESTARTS = "it restarts again and again"

_PIPELINED_ROUNDS = 50
"""Rounds that are pipelined on a fast line after a late reply: late replies then do not add up."""


class Session:
    """The exchange with one robot, round by round.

    Args:
        client: The connection to the robot.
        period: Seconds of a round, which the line must keep; None accepts any line.

    Attributes:
        timing: The timing of the line, from `begin` on.
        stop_confirmed: Whether the robot has confirmed a stop, and was sent no command since that turns its wheels.
    """

    def __init__(self, client: ProtocolClient, period: float | None) -> None:
        self.timing = LineTiming(client.baud)
        self.stop_confirmed = False
        self._client = client
        self._period = period
        self._limits = CallLimits(client, lambda: not self.stop_confirmed)
        self._speeds = (0, 0)
        self._command: Motors | None = None
        self._sent_arm: int | None = None
        self._sent_jaw: int | None = None
        self._unconfirmed: list[Request] = []
        self._pipelined_rounds = 0
        self._last_round = float("-inf")
        self._sensors = SensorReader(client, CONTROL_PERIOD if period is None else period)
        self._must_restore = False

    def begin(self) -> None:
        """Check that a Khepera replies, stop its wheels, and measure the line.

        Request B comes first: it is sent again if the robot rejects it because another program left an unfinished
        request on the line.

        Raises:
            RobotLost: The robot does not reply.
            LineTooSlow: The line does not keep the period.
        """
        timer = LineTimer(self._client)
        timer.request(Request("B"))
        if timer.is_late and self._period is not None:
            self.stop_confirmed = timer.request_after_late_reply(STOP)
        else:
            timer.request(STOP)
            self.stop_confirmed = True
        self.timing = timer.finish()
        if self._period is not None:
            self.timing.check(self._client.port, self._period)

    def request(self, command: str, *values: int) -> tuple[int | str, ...]:
        """Send one request; returns the values of the reply."""
        self._limits.begin()
        self._confirm()
        return self._request(Request(command, values)).values

    def transmit(self, command: Motors) -> None:
        """Send the wheel speeds, and the targets of arm and jaw if they have changed."""
        self._limits.begin()
        self._confirm()
        self._command = command
        requests = [Request("D", (int(command.left), int(command.right)))]
        if command.arm != self._sent_arm:
            requests.append(Request("T,1,E", (command.arm,)))
        if command.jaw != self._sent_jaw:
            requests.append(Request("T,1,D", (0 if command.jaw == JAW_OPEN else 1,)))
        if any(map(turns_wheels, requests)):
            self.stop_confirmed = False
        # A fast line confirms the speeds at once: after a lost request the wheels would keep their last speeds.
        held = False
        if self.timing.pipelined and self._client.send(requests):
            self.stop_confirmed = False
            self._unconfirmed = requests
        else:
            begin, holds = time.monotonic(), self._limits.holds
            self._exchange(requests)
            self._note_lateness(begin, len(requests))
            held = self._limits.holds > holds
        for request in requests:
            self._record(request, command)
        if held:
            self._speeds = (0, 0)  # until the next command
            self.stop_confirmed = False

    def receive(self) -> Senses:
        """Read the sensors."""
        self._limits.begin()
        begin = time.monotonic()
        requests = self._sensors.begin_round()
        self._pipelined_rounds -= 1
        if self._unconfirmed:
            received = self._client.request_all(requests, self._unconfirmed)[len(self._unconfirmed) :]
            self._unconfirmed = []
            self.stop_confirmed = self._speeds == (0, 0)
        else:
            received = self._exchange(requests)
        limit = self._repetition_limit(begin, self._note_lateness(begin, len(requests)))
        again = self._sensors.doubtful(requests, received, self._speeds)
        lengths = {
            request: len(encode_request(request) + encode_reply(reply))
            for request, reply in zip(requests, received, strict=True)
        }

        def has_time(*more: Request) -> bool:
            needed = self.timing.duration(len(more), sum(lengths[request] for request in more))
            return time.monotonic() + needed <= limit

        if again and has_time(*again):
            received += self._exchange(again)
            requests += again
        senses = self._sensors.read(requests, received, self._speeds, has_time)
        if self._sensors.counters.restart_noticed:
            self._must_restore = True
        self._note_lateness(begin, len(requests))
        self._last_round = time.monotonic()
        return senses

    def _exchange(self, requests: list[Request]) -> list[Reply]:
        """The replies to requests; pipelined, if one reply was late a short time ago or the latency is long."""
        if not self.timing.can_pipeline:
            return [self._client.request(request) for request in requests]
        if self.timing.pipelined or self._pipelined_rounds > 0:
            return self._client.request_all(requests)
        return self._client.request_in_turn(requests)

    def _note_lateness(self, begin: float, requests: int) -> bool:
        """Whether requests took so long that a reply must have been late or lost: then pipeline the next rounds."""
        expected = self.timing.duration(requests, MAX_ROUND_BYTES)
        is_late = time.monotonic() - begin > self._client.timeout + expected
        if is_late:
            self._pipelined_rounds = _PIPELINED_ROUNDS
        return is_late

    def _repetition_limit(self, begin: float, is_late: bool) -> float:
        """Moment until which implausible readings may be requested again.

        Without late replies, a round must not end too long after the last one. A caller that begins to
        receive more than one period after the last round does not keep the period itself.
        """
        period = self._period
        if not is_late and period is not None and begin <= self._last_round + period:
            return self._last_round + self.timing.longest_round(period)
        return begin + max(HOLD_AFTER, self._client.timeout) + self.timing.latency

    def stop(self, discard_command: bool) -> None:
        """Stop the wheels.

        Args:
            discard_command: Whether the wheels also remain stopped after a restart of the robot; otherwise the last
                command is then restored.

        Raises:
            RobotLost: The robot does not confirm.
        """
        self._limits.begin()
        if discard_command and self._command is not None:
            self._command = self._command._replace(left=0, right=0)
        if self._unconfirmed:
            # Their replies can no longer be told from others: send the targets again with the next command.
            self._unconfirmed = []
            self._sent_arm = self._sent_jaw = None
        for _ in range(MAX_RESTARTS):
            try:
                self._client.request_at_once(STOP)
                self._speeds = (0, 0)
                self.stop_confirmed = True
                return
            except RobotRestarted:
                self.on_restart()
        raise RobotLost(self._client.port, "D,0,0", MAX_RESTARTS, TOO_MANY_RESTARTS)

    def on_restart(self) -> None:
        """Record that the robot sent its banner."""
        self._unconfirmed = []
        self._sensors.counters.restarted()
        self._must_restore = True

    def restore(self) -> None:
        """After a restart of the robot, send the last command again."""
        if not self._must_restore:
            return
        self._sent_arm = self._sent_jaw = None
        self._sensors.arm.set_target(None)
        self._sensors.jaw.set_target(None)
        if self._command is not None:
            self.transmit(self._command)
        self._must_restore = False

    def _confirm(self) -> None:
        """Wait for the replies to the requests of the last `transmit`."""
        if self._unconfirmed:
            self._client.request_all((), self._unconfirmed)
            self._unconfirmed = []
            self.stop_confirmed = self._speeds == (0, 0)

    def _request(self, request: Request) -> Reply:
        """Send one request; again, if the wheels were stopped while its reply was overdue."""
        turns = turns_wheels(request)
        if turns:
            self.stop_confirmed = False
        while True:
            holds = self._limits.holds
            reply = self._client.request(request)
            if not turns or self._limits.holds == holds:
                return reply
            self._limits.resume()

    def _record(self, request: Request, command: Motors) -> None:
        """Record that the robot has received a part of a command."""
        if request.command == "D":
            self._speeds = request.values[0], request.values[1]
            self.stop_confirmed = not (self._unconfirmed or turns_wheels(request))
        elif request.command == "T,1,E":
            self._sent_arm = command.arm
            self._sensors.arm.set_target(command.arm)
        else:
            self._sent_jaw = command.jaw
            self._sensors.jaw.set_target(command.jaw)
