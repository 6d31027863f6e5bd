"""What an experiment is: a question, work that can be done in any order, and a report on the rows."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from _further_work.rows import Done, Size, Unit
from khepera_forage.thesis.claims.claim import Claim
from khepera_forage.thesis.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Report(NamedTuple):
    """What came out.

    Attributes:
        claims: Each with its effect, interval, verdict and a sentence.
        tables: All figures behind them.
        figure: The picture.
        summary: What came out in a plain sentence, made of the figures; empty where the claims say it all.
    """

    claims: tuple[Claim, ...]
    tables: tuple[Table, ...]
    figure: "Figure"
    summary: str = ""


@dataclass(frozen=True, slots=True)
class Experiment:
    """One of the thesis' further works.

    Attributes:
        name: For `--only` and file names.
        title: Heading of its page.
        section: Of the thesis, where the question stands.
        question: What is asked.
        method: What was done to answer it.
        conditions: What is done differently; one piece of work each and a replication.
        run: Does one piece of work.
        report: Turns all rows into a report; the generator draws the resamples.
    """

    name: str
    title: str
    section: str
    question: str
    method: str
    conditions: tuple[str, ...]
    run: Callable[[Unit], Done]
    report: Callable[[Done, np.random.Generator], Report]

    def units(self, seed: int, size: Size) -> list[Unit]:
        """All work, the slowest kind not last."""
        return [
            Unit(seed, n, condition, size) for n in range(size.replications) for condition in self.conditions
        ]
