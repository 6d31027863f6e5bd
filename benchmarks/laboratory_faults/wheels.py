"""The wheels of the simulated robots: which turn, and for how long without a round of the training."""

import math
import threading
import time

from khepera_forage.lab.virtual_laboratory import VirtualLaboratory

_INTERVAL = 0.002
"""Seconds from one look at the wheels to the next."""
_SETTLING = 0.5
"""mm by which a standing robot that touches a wall or food may be pushed back by it."""
_ROUNDS = 3
"""Rounds for which bodies are observed that should stand still."""


class WheelWatch:
    """Measures how long wheels turn without control: from the end of the last round, while any wheel is commanded.

    The virtual laboratory simulates no time while the driver waits, but the commands at the robots' ends of the lines
    are real, and so are the driver's timeouts.

    Args:
        lab: The laboratory.

    Attributes:
        longest: Seconds, since the last `restart`.
        left_out: Robots that nothing can reach.
    """

    def __init__(self, lab: VirtualLaboratory) -> None:
        self.longest = 0.0
        self.left_out: frozenset[int] = frozenset()
        self._firmwares = lab.firmwares
        self._round_end = time.monotonic()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def restart(self) -> None:
        """Forget what was measured."""
        self.longest, self._round_end = 0.0, time.monotonic()

    def end_round(self) -> None:
        """A round has ended."""
        self._round_end = time.monotonic()

    def close(self) -> None:
        """End the thread."""
        self._closing.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._closing.wait(_INTERVAL):
            since = self._round_end
            if any(f.turning for i, f in enumerate(self._firmwares) if i not in self.left_out):
                self.longest = max(self.longest, time.monotonic() - since)


def moving(lab: VirtualLaboratory) -> set[int]:
    """Numbers of the robots that move or turn a wheel while the simulation advances."""
    bodies = lab.simulation.robots
    before = [(body.pose, body.sense()[1:3]) for body in bodies]
    for _ in range(_ROUNDS):
        lab.simulation.advance()
    return {
        i
        for i, (body, (pose, pulses)) in enumerate(zip(bodies, before, strict=True))
        if body.sense()[1:3] != pulses or math.dist(body.pose[:2], pose[:2]) > _SETTLING
    }
