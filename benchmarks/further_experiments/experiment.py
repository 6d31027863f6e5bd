"""An experiment: a question, units of work, and a report on their rows."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from further_experiments.analysis import Analysis
from further_experiments.rows import Row
from khepera_forage.estimates import Column, Table
from khepera_forage.study import Page, Picture
from khepera_forage.thesis.claims.claim import Claim, Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Size(NamedTuple):
    """How much is done.

    Attributes:
        files: Most training episodes of a learner.
        recalls: Recall episodes of each learner in each arena.
        generations: Of a chain.
        attempts: At a training episode, before the experiment gives it up.
        patience: Attempts at a training episode, after which a simulated person gives up. An assumption, not measured.
        steps: Time limit of a recall; by default that of its arena.
        rounds: Time limit of an attempt at a training episode.
    """

    files: int = 10
    recalls: int = 4
    generations: int = 5
    attempts: int = 100
    patience: int = 5
    steps: int | None = None
    rounds: int = 600

    @property
    def amounts(self) -> tuple[int, ...]:
        """Numbers of training episodes after which a learner is tested: the thesis's numbers below `files`, and all."""
        return (*(n for n in (1, 3, 5, 10) if n < self.files), self.files)


class Trial(NamedTuple):
    """One condition in one replication: a unit of work.

    Attributes:
        work: Does it.
        seed: Of the whole run.
        replication: From 0.
        condition: One of the experiment's.
        size: Of the whole experiment.
    """

    work: Callable[["Trial"], list[Row]]
    seed: int
    replication: int
    condition: str
    size: Size

    @property
    def key(self) -> str:
        """Replication and condition."""
        return f"{self.replication} {self.condition}"

    def run(self) -> list[Row]:
        """Train, recall, and return the rows."""
        return self.work(self)


class Report(NamedTuple):
    """Results of an experiment.

    Attributes:
        claims: Each with its effect, interval, verdict and a sentence.
        tables: The values behind them.
        figure: The picture.
        summary: The main result in one sentence; empty where the claims are enough.
    """

    claims: Sequence[Claim]
    tables: Sequence[Table]
    figure: "Figure"
    summary: str = ""


@dataclass(frozen=True, slots=True)
class Experiment:
    """One item of the thesis's further work.

    Attributes:
        name: For `--only` and file names.
        title: Heading of its page.
        section: Of the thesis, where the question stands.
        question: Under test.
        method: How it is tested.
        conditions: One trial each in every replication.
        run: Does one trial.
        report: Turns all rows into a report.
    """

    name: str
    title: str
    section: str
    question: str
    method: str
    conditions: tuple[str, ...]
    run: Callable[[Trial], list[Row]]
    report: Callable[[Analysis], Report]

    def trials(self, seed: int, replications: int, size: Size) -> list[Trial]:
        """All work, replication by replication."""
        return [
            Trial(self.run, seed, number, condition, size)
            for number in range(replications)
            for condition in self.conditions
        ]

    def page(self, report: Report) -> Page:
        """Question, method, claims, picture and tables."""
        count = Counter(claim.verdict for claim in report.claims)
        verdicts = ", ".join(f"{count[verdict]} {verdict}" for verdict in Verdict)
        claims = "\n".join(
            f"- **{c.name}: {c.verdict}.** {c.sentence} Effect: {c.effect}." for c in report.claims
        )
        return Page(
            self.title,
            [
                f"**{self.question}** (section {self.section} of the thesis)",
                self.method,
                f"## Results\n\n{len(report.claims)} claims: {verdicts}.\n\n{claims}",
                *([f"**In short:** {report.summary}"] if report.summary else []),
                Picture(self.name, self.title, report.figure),
                _claim_table(report.claims),
                *report.tables,
            ],
        )


def _claim_table(claims: Sequence[Claim]) -> Table:
    return Table(
        "claims",
        "Claims",
        "The rule of each claim was fixed before there were data. A claim is undecided if its interval reaches across "
        "the threshold, or if there are too few replications for an interval.",
        (
            Column("claim"),
            Column("effect"),
            Column("value", page=False),
            Column("low", page=False),
            Column("high", page=False),
            Column("rule"),
            Column("verdict"),
        ),
        [(c.name, c.effect, c.value, c.low, c.high, c.rule, str(c.verdict)) for c in claims],
    )
