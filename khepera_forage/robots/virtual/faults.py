"""Fault injection on a virtual serial line: faults at given rates, drawn from a seed.

The protocol has no checksum: no host can detect a reply garbled into another well-formed one. These are counted
separately.
"""

import contextlib
import threading
from dataclasses import dataclass, fields
from typing import Literal, get_args

import numpy as np

from khepera_forage.robots.serial.protocol import LineSplitter, Protocol, ProtocolError, Reply

Fault = Literal["drop", "delay", "garble", "duplicate", "reset", "unplug"]
FAULTS: tuple[Fault, ...] = get_args(Fault)
_MAX_GARBLED_BYTES = 3
"""Garbling changes, deletes or inserts one to this number of bytes. Assumption."""


@dataclass(frozen=True, slots=True)
class Faults:
    """Rates of the faults, as shares of all replies; a reply has at most one fault.

    Raises:
        ValueError: A rate outside 0..1, rates that add up to more than 1, or an invalid lateness.
    """

    drop: float = 0.0
    """Lost, with equal probability the request, which the robot then does not execute, or the reply."""
    delay: float = 0.0
    """Late by `lateness`; later replies wait behind it, as in the buffers of a radio link."""
    garble: float = 0.0
    """One to three bytes changed, deleted or inserted."""
    duplicate: float = 0.0
    """Sent twice."""
    reset: float = 0.0
    """The power supply fails: wheels stop, settings are lost, the banner replaces the reply or cuts it off."""
    unplug: float = 0.0
    """The cable is unplugged for good. It also carries the power supply (assumption), so the wheels stop."""
    lateness: tuple[float, float] = (0.3, 1.0)
    """Seconds by which a delayed reply is late, uniform between the two: choose more than the host's timeout, so that
    the reply arrives after the host has repeated its request."""

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
        """Share of replies with any fault."""
        return float(sum(getattr(self, fault) for fault in FAULTS))


@dataclass(frozen=True, slots=True)
class FaultCounts:
    """How often each fault occurred."""

    replies: int = 0
    """Requests received, with or without a fault."""
    drop: int = 0
    delay: int = 0
    garble: int = 0
    undetectable: int = 0
    """Garbled replies that decode to a reply to the same command with other values."""
    duplicate: int = 0
    reset: int = 0
    unplug: int = 0

    @property
    def disturbed(self) -> int:
        """Replies with any fault."""
        return sum(getattr(self, fault) for fault in FAULTS)


class FaultInjector:
    """Draws the faults of one line. All methods are thread-safe.

    Args:
        protocol: Of the line.
        faults: Rates of the faults.
        rng: Required if any rate is not zero.

    Raises:
        ValueError: Rates without a random generator.
    """

    def __init__(
        self, protocol: Protocol, faults: Faults | None = None, rng: np.random.Generator | None = None
    ) -> None:
        self._protocol, self._rng = protocol, rng
        self._lock = threading.Lock()
        self._counts = dict.fromkeys((field.name for field in fields(FaultCounts)), 0)
        self.rates = Faults() if faults is None else faults

    @property
    def rates(self) -> Faults:
        """Rates of the faults; may be set at any time."""
        return self._rates

    @rates.setter
    def rates(self, faults: Faults) -> None:
        if faults.total and self._rng is None:
            raise ValueError("faults without a random generator; allowed: rng=numpy.random.default_rng(seed)")
        self._rates = faults

    @property
    def counts(self) -> FaultCounts:
        """Faults so far."""
        with self._lock:
            return FaultCounts(**self._counts)

    def draw(self) -> Fault | None:
        """The fault of the next reply, or None."""
        rates, fault = self._rates, None
        if rates.total and self._rng is not None:
            drawn = self._rng.random()
            for candidate in FAULTS:
                drawn -= getattr(rates, candidate)
                if drawn < 0:
                    fault = candidate
                    break
        with self._lock:
            self._counts["replies"] += 1
            if fault is not None:
                self._counts[fault] += 1
        return fault

    def coin_toss(self) -> bool:
        """True or False with equal probability."""
        return bool(self._generator.random() < 0.5)

    def lateness(self) -> float:
        """Seconds by which a reply is late."""
        return float(self._generator.uniform(*self._rates.lateness))

    def truncate(self, reply: bytes) -> bytes:
        """The beginning of a reply: at least one byte, but not all."""
        return reply[: int(self._generator.integers(1, len(reply)))]

    def garble(self, reply: bytes) -> bytes:
        """A reply with one to three bytes changed, deleted or inserted."""
        rng = self._generator
        garbled = bytearray(reply)
        kind = rng.integers(3)
        for _ in range(rng.integers(1, _MAX_GARBLED_BYTES + 1)):
            place = int(rng.integers(len(garbled)))
            if kind == 0:
                garbled[place] ^= int(rng.integers(1, 256))
            elif kind == 1 and len(garbled) > 1:
                del garbled[place]
            else:
                garbled.insert(place, int(rng.integers(256)))
        if self._undetectable(bytes(garbled), reply):
            with self._lock:
                self._counts["undetectable"] += 1
        return bytes(garbled)

    def _undetectable(self, garbled: bytes, reply: bytes) -> bool:
        """Whether a garbled reply decodes to another reply to the same command."""
        for line in LineSplitter().feed(garbled):
            with contextlib.suppress(ProtocolError):
                decoded, original = self._protocol.decode_reply(line), self._protocol.decode_reply(reply)
                if isinstance(decoded, Reply) and isinstance(original, Reply):
                    return decoded.command == original.command and decoded != original
        return False

    @property
    def _generator(self) -> np.random.Generator:
        if self._rng is None:
            raise ValueError("faults without a random generator; allowed: rng=numpy.random.default_rng(seed)")
        return self._rng
