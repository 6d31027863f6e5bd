"""The outcome as tables."""

from collections.abc import Sequence

import numpy as np

from _virtual_lab.compared import Compared
from _virtual_lab.disturbances import Disturbance
from _virtual_lab.faults import LATENESS
from _virtual_lab.rounds import LOCK_STEP, PACED, PARTS, TimedRound
from khepera_forage.thesis.statistics import Estimate
from khepera_forage.thesis.tables import Column, Table

_WORLDS = (
    "Virtual laboratory: real driver, real bytes over pseudo-terminals, real tracker on rendered frames. Pymunk: the "
    "same bodies alone, under the simulated camera. The laboratory's noise in both."
)
_INTERVALS = (
    "Brackets: 95 % interval, by resampling replications. Difference: virtual laboratory minus pymunk, replications "
    "paired by their seeds."
)
_RECALL_NOTE = (
    f"{_WORLDS} From the same random places in both; the imitator recalls in the world in which it was trained, in the "
    f"corridor. {_INTERVALS}"
)
_TRAINING_NOTE = (
    f"{_WORLDS} A learner and its teacher in two corridors, until an episode is complete. {_INTERVALS}"
)
_ROUND_NOTE = (
    "Two robots in training: median [5th, 95th percentile]. Lock-step: no pace at all, as fast as the machine goes. "
    "Wall clock: bytes at 38400 baud and a beat of 100 ms; late is a round that misses it. Robots, camera and "
    "everything else share one computer here: a real laboratory needs no physics and no rendering."
)
_FAULT_NOTE = (
    "Trainings of two robots in lock-step, one after the other until there have been so many rounds; the last is cut "
    "off in its midst. Rates are shares of all replies. Faults are those in rounds: while the operator places things "
    f"the lines are left in peace. Delayed replies are {1000 * LATENESS[0]:.0f} to {1000 * LATENESS[1]:.0f} ms late; "
    "the driver asks again after 100 ms. Recovered: nobody was lost in the round. Halted: rounds in which a body did "
    "not turn its wheels as commanded: it was held while the other's line was disturbed, or had just restarted. "
    "Moving: robots whose simulated bodies moved or turned a wheel after a loss, or after the end."
)
_EXPERIENCE_NOTE = (
    "The same rounds; every fault begins with the same trainings. "
    "Shown: state vectors with a behaviour, as the learner got to see and hear them. On disk: vectors "
    "in the files of episodes that were complete or cut short; forgotten: those of separated attempts (5.2). Altered: "
    "missing on disk, too many, or otherwise than shown. Wrong: shown vectors that are not what the learner's body "
    "senses in that round, or whose word is not what the teacher would call by its body's senses. The protocol has no "
    "checksum: unseen are garbled replies that read as other valid ones. The driver asks again where a reading "
    "surprises; misread and miscounted are rounds in which it believed another sense than the body's, or another turn "
    "of its wheels. What the wheels turned before a restart is lost with the counters, on which no behaviour depends."
)


def recall_table(results: Sequence[Compared], repeated: int, unplaced: int) -> Table:
    """Recalls in both worlds.

    Args:
        results: Compared.
        repeated: Recalls in the virtual laboratory that were done again; see `Outcome`.
        unplaced: Places at which none could begin there.
    """
    note = (
        f"{_RECALL_NOTE} Recalls done again, as a robot was lost on an undisturbed line: {repeated}. Places left out "
        f"in both worlds, as the camera never saw the robot where it was put: {unplaced}."
    )
    columns = (Column("arena"), Column("who"), *_COMPARED)
    rows = [(r.arena, r.who, *_of(r)) for r in results]
    return Table("recalls", "Recalls", note, columns, rows)


def training_table(results: Sequence[Compared]) -> Table:
    """Training in both worlds."""
    return Table("trainings", "Training episodes", _TRAINING_NOTE, _COMPARED, [_of(r) for r in results])


_COMPARED = (
    Column("measure"),
    Column("episodes"),
    Column("pymunk alone", estimate=True),
    Column("virtual laboratory", estimate=True),
    Column("difference", estimate=True),
)


def _of(result: Compared) -> tuple[str | Estimate, ...]:
    episodes = " / ".join(map(str, dict.fromkeys(result.episodes)))
    return result.measure, episodes, result.pymunk, result.virtual, result.difference


def round_table(rows: Sequence[TimedRound]) -> Table:
    """Times by part."""
    columns = (
        Column("part of a round"),
        Column("lock-step (ms)", digits=2, estimate=True),
        Column("wall clock, 38400 baud (ms)", digits=2, estimate=True),
    )
    own = {pace: [row for row in rows if row.pace == pace] for pace in (LOCK_STEP, PACED)}
    names = {**PARTS, "busy": "all but the wait"}
    lines: list[tuple[str | float | Estimate, ...]] = [
        (name, *(_percentiles([getattr(row, part) for row in its]) for its in own.values()))
        for part, name in names.items()
    ]
    counts = ", ".join(
        f"{pace}: {len(its)} rounds, {sum(row.late for row in its)} late" for pace, its in own.items()
    )
    return Table("rounds", "The time of a round", f"{_ROUND_NOTE} {counts}.", columns, lines)


def fault_table(results: Sequence[Disturbance]) -> Table:
    """What faults did to rounds."""
    columns = (
        Column("fault"),
        Column("rate (%)"),
        Column("rounds"),
        Column("faults"),
        Column("rounds disturbed"),
        Column("recovered"),
        Column("robots lost"),
        Column("halted"),
        Column("moving"),
        Column("a round (ms)"),
        Column("longest (ms)", digits=0),
    )
    rows = [
        (
            r.fault,
            100 * r.rate,
            r.rounds,
            r.faults,
            r.disturbed,
            r.recovered,
            r.losses,
            r.halted,
            r.moving,
            1000 * r.seconds / r.rounds,
            1000 * r.longest,
        )
        for r in results
    ]
    return Table("faults", "Disturbed lines: rounds", _FAULT_NOTE, columns, rows)


def experience_table(results: Sequence[Disturbance]) -> Table:
    """What faults did to what was learned."""
    names = (
        "fault",
        "rate (%)",
        "shown",
        "on disk",
        "forgotten",
        "altered",
        "episodes cut short",
        "files kept of them",
        "unseen",
        "misread",
        "miscounted",
        "wrong",
    )
    rows = [
        (
            r.fault,
            100 * r.rate,
            r.vectors,
            r.stored,
            r.forgotten,
            r.altered,
            r.losses,
            r.losses_kept,
            r.unseen,
            r.misread,
            r.miscounted,
            r.wrong,
        )
        for r in results
    ]
    columns = tuple(Column(name) for name in names)
    return Table("experience", "Disturbed lines: experience", _EXPERIENCE_NOTE, columns, rows)


def _percentiles(values: Sequence[float]) -> Estimate:
    low, median, high = np.percentile(values, (5, 50, 95)).tolist()
    return Estimate(median, low, high)
