"""The tables and the picture of the page."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from khepera_forage.estimates import Column, Table, Value, extremes, pick
from khepera_forage.figures import GREY, OURS, THESIS, WIDTH, legend, new_figure
from laboratory_faults.campaign import EPISODES
from laboratory_faults.injector import UNEXPECTED
from laboratory_faults.kinds import KINDS
from laboratory_faults.rows import ATTEMPT_LOST, RECOVERED, STOPPED, FaultRow, TrainingResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROBOT_NOTE = (
    "Faults in random rounds of trainings of three robots. Recovered: the attempt went on. Attempt lost: the operator "
    "was asked to repair, and another attempt followed. Stopped: the command ended with an error, and was continued "
    "with --continue. Until noticed: seconds from the fault to the end of the attempt or, for a fault that passed, to "
    "the eighth round after it; median [lowest, highest]. Wheels unattended: the longest time for which a wheel within "
    "reach of its line was commanded to turn since the last round had ended. Moving: robots that moved after the "
    "attempt had ended. Out of reach: robots that moved although the driver tried to stop them, because their line "
    "was interrupted and their power supply was not; no program can stop these."
)
_EXPERIENCE_NOTE = (
    "Experience vectors of the same faults. Earlier: on disk before the fault; all experience files were compared byte "
    "by byte. Perceived: from the fault until it was over. Missing: perceived, and not on disk; the vector at which a "
    "disk failed. Altered: stored other than perceived. Wrong: stored other than the learner's body senses, or with "
    "another behaviour than the teacher's. Outdated: stored while the camera's poses were more than 15 mm from the "
    "true ones. One message: faults after which the user read exactly one warning or error, which names the device or "
    "file and the cause; a fault that passes by itself needs none. Requests: to the operator, who now and then presses "
    "Enter too early. Continued: a round of training followed."
)
_TRAINING_NOTE = (
    f"Whole trainings of {EPISODES} complete episodes each, with the functions of `khepera-forage train --lab "
    "lab.toml`. Complete: files with closing line whose attempt is in attempts.csv. Foreign: complete files that hold "
    "other vectors than their attempt's. Stuck: refusals of --continue. Unexpected: losses without a fault."
)
_NOTICE_NOTE = (
    "What the user reads: the first message after one fault of each kind, without the number of vectors."
)


def robot_table(rows: Sequence[FaultRow]) -> Table:
    """Outcomes and motion by kind of fault."""
    columns = (
        Column("part"),
        Column("fault"),
        Column("faults"),
        Column("recovered"),
        Column("attempt lost"),
        Column("stopped"),
        Column("until noticed (s)", digits=2, estimate=True),
        Column("wheels unattended (s)", digits=2, estimate=True),
        Column("moving"),
        Column("out of reach"),
    )
    lines: list[tuple[Value, ...]] = []
    for part, kind, own in _by_kind(rows):
        outcomes = (len(pick(own, outcome=outcome)) for outcome in (RECOVERED, ATTEMPT_LOST, STOPPED))
        lines.append(
            (
                part,
                kind,
                len(own),
                *outcomes,
                extremes([row.seconds for row in own]),
                extremes([row.unattended for row in own]),
                sum(row.moving for row in own),
                sum(row.out_of_reach for row in own),
            )
        )
    return Table("robots", "Robots", _ROBOT_NOTE, columns, lines)


def experience_table(rows: Sequence[FaultRow]) -> Table:
    """Experience and messages by kind of fault."""
    names = ("perceived", "missing", "altered", "wrong", "outdated")
    columns = (
        Column("part"),
        Column("fault"),
        Column("faults"),
        Column("earlier"),
        Column("files damaged"),
        *map(Column, names),
        Column("no message"),
        Column("one message"),
        Column("others"),
        Column("requests"),
        Column("continued"),
    )
    lines: list[tuple[Value, ...]] = []
    for part, kind, own in _by_kind(rows):
        none = sum(row.notices == 0 for row in own)
        one = sum(row.notices == row.named == 1 for row in own)
        lines.append(
            (
                part,
                kind,
                len(own),
                sum(row.before for row in own),
                sum(not row.intact for row in own),
                *(sum(getattr(row, name) for row in own) for name in names),
                none,
                one,
                len(own) - none - one,
                sum(row.requests for row in own),
                sum(row.continued for row in own),
            )
        )
    return Table("experience", "Experience and messages", _EXPERIENCE_NOTE, columns, lines)


def training_table(rows: Sequence[TrainingResult]) -> Table:
    """Sums over all trainings."""
    names = ("faults", "attempts", "rounds", "planned", "complete", "foreign", "stuck")
    columns = (Column("trainings"), *map(Column, names), Column("hours", digits=2))
    line = (len(rows), *(sum(getattr(row, name) for row in rows) for name in names))
    return Table(
        "trainings",
        "Trainings",
        _TRAINING_NOTE,
        columns,
        [(*line, sum(row.seconds for row in rows) / 3600)],
    )


def notice_table(rows: Sequence[FaultRow]) -> Table:
    """One message of each kind."""
    lines: list[tuple[Value, ...]] = []
    for _, kind, own in _by_kind(rows):
        told = [row.text for row in own if row.text]
        lines += [(kind, told[0].partition("; its ")[0])] if told else []
    return Table("notices", "Messages", _NOTICE_NOTE, (Column("fault"), Column("message")), lines)


def picture(rows: Sequence[FaultRow]) -> "Figure":
    """Seconds until a fault was noticed, and of wheels without control, by kind."""
    kinds = _by_kind(rows)[::-1]
    figure = new_figure(WIDTH, 0.8 + 0.22 * len(kinds))
    axes = figure.subplots()
    for shift, name, label, colour in (
        (0.2, "seconds", "from the fault until it is noticed, or over", OURS),
        (-0.2, "unattended", "wheels turning since the last round", THESIS),
    ):
        found = [extremes([getattr(row, name) for row in own]) for *_, own in kinds]
        values = [each.value for each in found]
        spread = [[each.value - each.low for each in found], [each.high - each.value for each in found]]
        places = [place + shift for place in range(len(kinds))]
        axes.barh(places, values, 0.38, color=colour, xerr=spread, ecolor=GREY, capsize=2, label=label)
    axes.set_yticks(range(len(kinds)), [kind for _, kind, _ in kinds])
    axes.set(xlabel="seconds: median, lowest and highest")
    axes.set_xlim(left=0)
    legend(figure, axes, columns=2)
    return figure


def _by_kind(rows: Sequence[FaultRow]) -> list[tuple[str, str, list[FaultRow]]]:
    """Part, kind and rows of every kind that happened, in the order of the kinds."""
    kinds = [(kind.part, kind.name, pick(rows, kind=kind.name)) for kind in (*KINDS, UNEXPECTED)]
    return [(part, kind, list(own)) for part, kind, own in kinds if own]
