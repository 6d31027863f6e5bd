"""The page of an experiment, in Markdown."""

from collections import Counter
from collections.abc import Sequence

from _further_work.experiment import Experiment, Report
from khepera_forage.thesis.claims.claim import Claim, Verdict
from khepera_forage.thesis.tables import Column, Table


def claim_table(claims: Sequence[Claim]) -> Table:
    """All claims with effect, rule and verdict."""
    return Table(
        "claims",
        "What was tested",
        "The rule of each claim was fixed before there were data; an interval that reaches across it leaves "
        "the claim "
        "undecided, and so does too few replications for an interval.",
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


def page(experiment: Experiment, report: Report, command: str) -> str:
    """Question, answer, method, picture, tables and command."""
    came_out = "\n".join(
        f"- **{c.name}: {c.verdict}.** {c.sentence} Effect: {c.effect}." for c in report.claims
    )
    count = Counter(claim.verdict for claim in report.claims)
    verdicts = ", ".join(f"{count[verdict]} {verdict}" for verdict in Verdict)
    tables = "\n".join(table.markdown() for table in (claim_table(report.claims), *report.tables))
    return (
        f"# {experiment.title}\n\n"
        f"**{experiment.question}** (section {experiment.section} of the thesis)\n\n"
        f"{experiment.method}\n\n"
        f"## What came out\n\nOf {len(report.claims)} claims: {verdicts}.\n\n{came_out}\n\n"
        f"![{experiment.title}]({experiment.name}.png)\n\n"
        f"{tables}\n"
        f"{f'## In short{chr(10) * 2}{report.summary}{chr(10) * 2}' if report.summary else ''}"
        f"## Command\n\n    {command}\n"
    )
