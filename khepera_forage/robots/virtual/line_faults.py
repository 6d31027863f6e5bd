"""What can go wrong on a serial line to a robot, at given rates and drawn from a seed.

The protocol has no checksum: a reply that was garbled into another well-formed one cannot be told from a true one by
anybody. How often that happened is counted apart.
"""

import contextlib
import threading
from dataclasses import dataclass, fields
from typing import Literal, get_args

import numpy as np

from khepera_forage.robots.serial.protocol import CodecError, Lines, Reply, decode_reply

Fault = Literal["drop", "delay", "garble", "duplicate", "reset", "unplug"]
FAULTS: tuple[Fault, ...] = get_args(Fault)
_MOST_BYTES = 3
"""A disturbance changes, loses or inserts one to so many bytes. Assumption."""


@dataclass(frozen=True, slots=True)
class Faults:
    """How often each fault happens, as a share of all replies; a reply has at most one.

    Raises:
        ValueError: A rate that is not within 0..1, rates that add up to more than 1, or a lateness that is no time.
    """

    drop: float = 0.0
    """Lost: half of the time the request, which the robot then never carries out, half of the time the reply."""
    delay: float = 0.0
    """Late by `lateness`; what comes after it waits behind it, as in the buffers of a radio link."""
    garble: float = 0.0
    """Up to three bytes changed, lost or inserted."""
    duplicate: float = 0.0
    """Sent twice."""
    reset: float = 0.0
    """The supply fails: wheels stop, the state is lost, the banner comes instead of the reply or amidst it."""
    unplug: float = 0.0
    """The line is gone for good, and the supply with it: the cable carries both (assumption), so the wheels stop."""
    lateness: tuple[float, float] = (0.3, 1.0)
    """Seconds by which a delayed reply is late, uniform between the two: choose more than the host's timeout, so that
    it arrives after the host has asked again."""

    def __post_init__(self) -> None:
        for fault in FAULTS:
            rate = getattr(self, fault)
            if not 0 <= rate <= 1:
                raise ValueError(f"rate of fault {fault} is {rate!r}; allowed: 0..1")
        if self.total > 1 + 1e-9:
            raise ValueError(f"rates of faults add up to {self.total:g}; allowed: at most 1")
        shortest, longest = self.lateness
        if not 0 <= shortest <= longest < float("inf"):
            raise ValueError(
                f"lateness is {self.lateness!r}; allowed: two times in seconds, the shorter first"
            )

    @property
    def total(self) -> float:
        """Share of replies that are disturbed."""
        return float(sum(getattr(self, fault) for fault in FAULTS))


@dataclass(frozen=True, slots=True)
class FaultCounts:
    """How often what happened."""

    replies: int = 0
    """Requests that were heard, disturbed or not."""
    drop: int = 0
    delay: int = 0
    garble: int = 0
    unseen: int = 0
    """Of the garbled: those that read as a reply to the same command with other values, which no host can tell."""
    duplicate: int = 0
    reset: int = 0
    unplug: int = 0

    @property
    def disturbed(self) -> int:
        """Replies with any fault."""
        return sum(getattr(self, fault) for fault in FAULTS)


class FaultSource:
    """Draws the faults of one line. All methods may be called from any thread.

    Args:
        faults: Their rates.
        rng: Needed as soon as a rate is not zero.

    Raises:
        ValueError: Rates without a generator.
    """

    def __init__(self, faults: Faults | None = None, rng: np.random.Generator | None = None) -> None:
        self._rng = rng
        self._lock = threading.Lock()
        self._counts = dict.fromkeys((field.name for field in fields(FaultCounts)), 0)
        self.rates = Faults() if faults is None else faults

    @property
    def rates(self) -> Faults:
        """What happens how often; may be set at any time."""
        return self._rates

    @rates.setter
    def rates(self, faults: Faults) -> None:
        if faults.total and self._rng is None:
            raise ValueError("faults without a random generator; allowed: rng=numpy.random.default_rng(seed)")
        self._rates = faults

    @property
    def counts(self) -> FaultCounts:
        """What has happened so far."""
        with self._lock:
            return FaultCounts(**self._counts)

    def next(self) -> Fault | None:
        """What happens to the next reply."""
        rates, happens = self._rates, None
        if rates.total and self._rng is not None:
            drawn = self._rng.random()
            for fault in FAULTS:
                drawn -= getattr(rates, fault)
                if drawn < 0:
                    happens = fault
                    break
        with self._lock:
            self._counts["replies"] += 1
            if happens is not None:
                self._counts[happens] += 1
        return happens

    def either(self) -> bool:
        """One of two things, at even odds."""
        return bool(self._generator.random() < 0.5)

    def lateness(self) -> float:
        """Seconds by which a reply is late."""
        return float(self._generator.uniform(*self._rates.lateness))

    def cut(self, reply: bytes) -> bytes:
        """The beginning of a reply: neither nothing of it nor all."""
        return reply[: int(self._generator.integers(1, len(reply)))]

    def garble(self, reply: bytes) -> bytes:
        """A reply with one to three bytes changed, lost or inserted."""
        rng = self._generator
        garbled = bytearray(reply)
        kind = rng.integers(3)
        for _ in range(rng.integers(1, _MOST_BYTES + 1)):
            place = int(rng.integers(len(garbled)))
            if kind == 0:
                garbled[place] ^= int(rng.integers(1, 256))
            elif kind == 1 and len(garbled) > 1:
                del garbled[place]
            else:
                garbled.insert(place, int(rng.integers(256)))
        if _deceives(bytes(garbled), reply):
            with self._lock:
                self._counts["unseen"] += 1
        return bytes(garbled)

    @property
    def _generator(self) -> np.random.Generator:
        if self._rng is None:
            raise ValueError("a fault without a random generator")
        return self._rng


def _deceives(garbled: bytes, reply: bytes) -> bool:
    """Whether a host would read a garbled reply as another one to the same command."""
    for line in Lines().feed(garbled):
        with contextlib.suppress(CodecError):
            read, meant = decode_reply(line), decode_reply(reply)
            if isinstance(read, Reply) and isinstance(meant, Reply):
                return read.command == meant.command and read != meant
    return False
