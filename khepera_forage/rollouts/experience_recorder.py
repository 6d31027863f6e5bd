"""Recording of the experience of one attempt at a training episode, in memory and in a file."""

import logging
from itertools import count
from pathlib import Path

from khepera_forage.experience import ExperienceWriter
from khepera_forage.rollouts.interrupts import delayed_interrupts
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, StateVector

_log = logging.getLogger(__name__)


class ExperienceRecorder:
    """The experience of one attempt, in memory and, with a path, in a file that grows with every vector.

    Args:
        path: The experience file; None records in memory only.

    Attributes:
        vectors: The state vectors so far.
        behaviours: The behaviours so far.
    """

    def __init__(self, path: Path | None) -> None:
        self.vectors: list[StateVector] = []
        self.behaviours: list[Behaviour] = []
        self._path = path
        self._writer: ExperienceWriter | None = None

    def open(self, arena: str, seed: int, decisions: Decisions) -> None:
        """Create the file.

        Raises:
            FileExistsError: There is a file at the path.
        """
        if self._path is not None:
            with delayed_interrupts():
                self._writer = ExperienceWriter(self._path, arena, seed, decisions=decisions)

    def record(self, vector: StateVector, behaviour: Behaviour) -> None:
        """Append an experience vector."""
        self.vectors.append(vector)
        self.behaviours.append(behaviour)
        if self._writer is not None:
            self._writer.append(vector, behaviour)

    def close(self, complete: bool) -> None:
        """Close the file, with the closing line of a complete file or without it."""
        if self._writer is not None:
            self._writer.close(complete)

    def abort(self) -> None:
        """Close the file without a closing line after an exception; delete it if it has no vector.

        An operator may stop before anything happens; an empty file would prevent the next training at this path.
        """
        if self._writer is not None:
            self._writer.close(complete=False)
            if not self.vectors:
                self._writer.path.unlink()

    def discard(self) -> None:
        """Delete the closed file of an incomplete attempt (5.2)."""
        if self._path is not None:
            self._path.unlink()

    def keep(self, number: int, lost: str) -> None:
        """Rename the closed file of an attempt in which a robot was lost, and log the new name.

        Args:
            number: Of the attempt; part of the new name, `g1.lost-2.csv` for the second attempt at `g1.csv`.
            lost: What was lost, for the log.
        """
        where = "not kept: training has no experience file"
        if self._path is not None:
            path = self._path
            names = (path.with_name(f"{path.stem}.lost-{n}{path.suffix}") for n in count(number))
            kept = next(name for name in names if not name.exists())
            path.rename(kept)
            where = f"kept in {kept}"
        vectors = len(self.vectors)
        _log.warning("attempt %d ended: %s; its %d experience vectors are %s", number, lost, vectors, where)
