"""The tables of the page."""

from collections.abc import Sequence

from khepera_forage.estimates import Column, Table, Value, pick, quantiles
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from lab_comparison.comparison import Comparison
from lab_comparison.episodes import REPEATED, UNPLACED, Exclusion
from lab_comparison.fault_sums import FaultSums
from lab_comparison.faults import LATENESS
from lab_comparison.rounds import LOCK_STEP, PACED, PARTS, TimedRound

_WORLDS = (
    "Virtual laboratory: real driver, real bytes over pseudo-terminals, real tracker on rendered frames. Pymunk alone: "
    "the same bodies with the simulated camera. Both with the laboratory's noise."
)
_INTERVALS = (
    "Brackets: 95 % interval, by resampling replications. Difference: virtual laboratory minus pymunk, replications "
    "paired by their seeds."
)
_RECALL_NOTE = (
    f"{_WORLDS} The random places are the same in both. The imitator recalls in the world of its training, which was "
    f"in the corridor. {_INTERVALS}"
)
_TRAINING_NOTE = (
    f"{_WORLDS} One learner and the teacher in two corridors, until an episode is complete. {_INTERVALS}"
)
_ROUND_MS = 1000 * DEFAULT_DECISIONS.round_duration
_ROUND_NOTE = (
    "Two robots in training: median [5th, 95th percentile]. Lock-step: without pace, as fast as the machine allows. "
    f"Wall clock: bytes at 38400 baud and rounds of {_ROUND_MS:g} ms; a round that takes longer is late. Robots, "
    "camera and everything else share one computer here; a real laboratory has neither simulation nor rendering."
)
_FAULT_NOTE = (
    "Trainings of two robots in lock-step, one after the other, for a fixed number of rounds; the last training is "
    "interrupted. Rates are shares of all replies. Faults are counted in rounds; the lines are undisturbed while the "
    f"operator places things. Delayed replies are {1000 * LATENESS[0]:.0f} to {1000 * LATENESS[1]:.0f} ms late; the "
    "driver repeats its request after 100 ms. Recovered: no robot was lost in the round. Halted: rounds in which a "
    "body did not turn its wheels as commanded, because it was held while the other robot's line was disturbed, or had "
    "just restarted. Moving: robots whose simulated bodies moved or turned a wheel after a loss, or after the end."
)
_EXPERIENCE_NOTE = (
    "The same rounds; every fault begins with the same trainings. Shown: state vectors with a behaviour, as the "
    "learner perceived and heard them. On disk: vectors in the files of episodes that were complete or interrupted. "
    "Forgotten: vectors of incomplete attempts (5.2). Altered: missing on disk, additional, or "
    "different from what was shown. Wrong: shown vectors that differ from what the learner's body senses in that "
    "round, or whose behaviour differs from what the teacher would call on its own body's senses. The protocol has no "
    "checksum: unseen are garbled replies that read as other valid ones. The driver repeats its request where a "
    "reading is unexpected. Misread and miscounted are rounds in which it accepted a sense that was not the body's, or "
    "a wrong turn of the wheels. Pulses that the wheels turned before a restart are lost with the counters; no "
    "behaviour depends on them."
)
_COMPARED = (
    Column("measure"),
    Column("episodes"),
    Column("pymunk alone", estimate=True),
    Column("virtual laboratory", estimate=True),
    Column("difference", estimate=True),
)


def recall_table(results: Sequence[Comparison], exclusions: Sequence[Exclusion]) -> Table:
    """Recalls in both worlds."""
    repeated, unplaced = (len(pick(exclusions, reason=reason)) for reason in (REPEATED, UNPLACED))
    note = (
        f"{_RECALL_NOTE} Recalls that were repeated because a robot was lost on an undisturbed line: {repeated}. "
        f"Recalls that could not begin, because the camera never found the robot where it was placed: {unplaced}; "
        "their places are left out in both worlds."
    )
    columns = (Column("arena"), Column("policy"), *_COMPARED)
    return Table("recalls", "Recalls", note, columns, [(r.arena, r.policy, *_of(r)) for r in results])


def training_table(results: Sequence[Comparison]) -> Table:
    """Training in both worlds."""
    return Table("trainings", "Training episodes", _TRAINING_NOTE, _COMPARED, [_of(r) for r in results])


def _of(result: Comparison) -> tuple[Value, ...]:
    episodes = " / ".join(map(str, dict.fromkeys(result.episodes)))
    return result.measure, episodes, result.pymunk, result.virtual, result.difference


def round_table(rows: Sequence[TimedRound]) -> Table:
    """Times by part."""
    columns = (
        Column("part of a round"),
        Column("lock-step (ms)", digits=2, estimate=True),
        Column("wall clock, 38400 baud (ms)", digits=2, estimate=True),
    )
    own = {pace: pick(rows, pace=pace) for pace in (LOCK_STEP, PACED)}
    names = {**PARTS, "busy": "all without the wait"}
    lines: list[tuple[Value, ...]] = [
        (name, *(quantiles([getattr(row, part) for row in its]) for its in own.values()))
        for part, name in names.items()
    ]
    counts = ", ".join(
        f"{pace}: {len(its)} rounds, {sum(row.late for row in its)} late" for pace, its in own.items()
    )
    return Table("rounds", "The time of a round", f"{_ROUND_NOTE} {counts}.", columns, lines)


def fault_table(results: Sequence[FaultSums]) -> Table:
    """Effects of faults on rounds."""
    names = ("rounds", "faults", "disturbed", "recovered")
    rows = [
        (
            r.fault,
            100 * r.rate,
            *(r.sum(name) for name in names),
            len(r.lost),
            r.sum("halted"),
            r.sum("moving"),
            r.ms_a_round,
            1000 * max(row.longest for row in r.attempts),
        )
        for r in results
    ]
    headings = (
        "fault",
        "rate (%)",
        "rounds",
        "faults",
        "rounds disturbed",
        "recovered",
        "robots lost",
        "halted",
    )
    columns = (
        *map(Column, (*headings, "moving", "a round (ms)")),
        Column("longest (ms)", digits=0),
    )
    return Table("faults", "Disturbed lines: rounds", _FAULT_NOTE, columns, rows)


def experience_table(results: Sequence[FaultSums]) -> Table:
    """Effects of faults on the experience."""
    rows = [
        (
            r.fault,
            100 * r.rate,
            r.sum("vectors"),
            r.sum("stored"),
            r.forgotten,
            r.sum("altered"),
            len(r.lost),
            sum(row.kept for row in r.lost),
            *(r.sum(name) for name in ("unseen", "misread", "miscounted", "wrong")),
        )
        for r in results
    ]
    headings = (
        *("fault", "rate (%)", "shown", "on disk", "forgotten", "altered", "episodes interrupted"),
        *("files kept of them", "unseen", "misread", "miscounted", "wrong"),
    )
    title = "Disturbed lines: experience"
    return Table("experience", title, _EXPERIENCE_NOTE, tuple(map(Column, headings)), rows)
