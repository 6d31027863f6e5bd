"""Faults of a virtual serial line: their rates, and what they do to a reply.

The protocol has no checksum: no host can detect a reply garbled into another well-formed one. These are counted
separately.
"""

import contextlib
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from khepera_forage.robots.serial.protocol import LineSplitter, Protocol, ProtocolError, Reply

Fault = Literal["drop", "delay", "garble", "duplicate", "reset", "unplug"]
FAULTS: tuple[Fault, ...] = get_args(Fault)
_MAX_GARBLED_BYTES = 3
"""Assumption."""


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

    def draw(self, rng: np.random.Generator) -> Fault | None:
        """The fault of the next reply, or None."""
        drawn = rng.random() if self.total else 1.0
        for fault in FAULTS:
            drawn -= getattr(self, fault)
            if drawn < 0:
                return fault
        return None


@dataclass(slots=True)
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


def garbled(reply: bytes, rng: np.random.Generator) -> bytes:
    """A reply with one to three bytes changed, deleted or inserted."""
    data = bytearray(reply)
    kind = rng.integers(3)
    for _ in range(rng.integers(1, _MAX_GARBLED_BYTES + 1)):
        place = int(rng.integers(len(data)))
        if kind == 0:
            data[place] ^= int(rng.integers(1, 256))
        elif kind == 1 and len(data) > 1:
            del data[place]
        else:
            data.insert(place, int(rng.integers(256)))
    return bytes(data)


def is_undetectable(data: bytes, reply: bytes, protocol: Protocol) -> bool:
    """Whether a garbled reply decodes to another reply to the same command."""
    original = protocol.decode_reply(reply)
    for line in LineSplitter().feed(data):
        with contextlib.suppress(ProtocolError):
            decoded = protocol.decode_reply(line)
            if isinstance(decoded, Reply) and isinstance(original, Reply):
                return decoded.command == original.command and decoded != original
    return False
