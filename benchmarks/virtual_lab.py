"""The virtual laboratory: the effects of real bytes and frames, the time of a round, and disturbed lines.

    python benchmarks/virtual_lab.py --help

Training and recall with real drivers on pseudo-terminals and the real tracker on rendered frames, compared with pymunk
alone; the time of a round, part by part; and every fault of a line at several rates. For each fault, the stored
experience is compared with what the learner was shown, and that with the truth.
"""

import logging
import os
import sys
import time
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple
from unittest.mock import patch

import numpy as np
from laboratory.observed_training import Attempt, ObservedTraining, moving

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TEACHER as TEACHER_ROBOT
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import (
    Column,
    Estimate,
    Measure,
    Table,
    Value,
    difference,
    mean,
    pick,
    quantiles,
)
from khepera_forage.experience import Experience, ExperienceWarning
from khepera_forage.figures import GREY, OURS, SMALL, THESIS, WIDTH, grid, legend, levels, new_figure
from khepera_forage.lab.clock import SimulatedClock, WallClock
from khepera_forage.lab.operator import OperatorGaveUp
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.robots.fleet import Fleet
from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.virtual.faults import FAULTS, Faults
from khepera_forage.rollouts.recall import RecallInterruptedError, recall, recall_env
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError, arrays, train
from khepera_forage.sim.world import World
from khepera_forage.study import Count, Page, Picture, Unit, collect, finish, in_processes, parse
from khepera_forage.vision.rendering.frames import RenderedFrameSource
from khepera_forage.vision.tracker import Tracker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNTS = (
    Count("replications", 16, 1, "trainings and recalls, in each world", adds_units=True),
    Count("rounds", 1000, 25, "rounds with each fault at each rate"),
)
WORLDS = PYMUNK, VIRTUAL = ("pymunk", "virtual")
ARENAS = ("corridor", "rectangle")
RATES, QUICK_RATES = (0.001, 0.01, 0.05), (0.05,)
LATENESS = (0.02, 0.2)
"""Seconds by which a delayed reply is late: about half are below the driver's timeout, half above."""
NO_FAULT = "none"
"""The condition without faults, which checks the measurement itself."""
_REPEATS = 3
"""How often a recall is repeated at most."""


@dataclass(frozen=True, slots=True)
class LabRecall(RecallRow):
    """A recall in one of `WORLDS`."""

    world: str = ""


@dataclass(frozen=True, slots=True)
class LabTraining(TrainingRow):
    """An attempt at a training episode in one of `WORLDS`."""

    world: str = ""


class Size(NamedTuple):
    """How much is done in a replication.

    Attributes:
        files: Training files, a complete episode each.
        recalls: In each arena, of the teacher and of the imitator, from the same places.
        rounds: Time limit of an attempt at a training episode.
        steps: Time limit of a recall; by default that of its arena.
    """

    files: int = 5
    recalls: int = 4
    rounds: int = 600
    steps: int | None = None


QUICK = Size(files=1, recalls=1, rounds=250, steps=200)


class Replication(NamedTuple):
    """Training files in one world, then recalls of the teacher and of the imitator of all these files there.

    A replication has the same seeds in both worlds: the same marks in training, the same random places in recall. The
    noise of the operator's hand, the wheels and the camera differs.
    """

    world: str
    number: int
    size: Size
    seed: int

    @property
    def key(self) -> str:
        """World and number."""
        return f"{self.world} {self.number}"

    def run(self) -> list[LabRecall | LabTraining]:
        """Train and recall, in the laboratory's noise."""
        seeds = np.random.SeedSequence(self.seed, spawn_key=(self.number,))
        training, *recalling = seeds.spawn(1 + len(ARENAS))
        files, rows = self._train(training)
        for arena, seed in zip(ARENAS, recalling, strict=True):
            rows += self._recalls(arena, files, seed.generate_state(self.size.recalls).tolist())
        return rows

    def _train(self, seeds: np.random.SeedSequence) -> tuple[list[Experience], list[LabRecall | LabTraining]]:
        world = self._world("corridor", 2)
        # In the virtual laboratory, the operator's hand makes the errors of placement.
        noise = None if world is None else Noise.none()
        files: list[Experience] = []
        rows: list[LabRecall | LabTraining] = []
        with closing(TrainingEnv(noise=noise, max_cycles=self.size.rounds, world=world)) as env:
            for file, seed in enumerate(seeds.spawn(self.size.files), start=1):
                experience, attempts = train(env, seed, replication=self.number, file=file)
                files.append(experience)
                rows += [LabTraining(**asdict(row), world=self.world) for row in attempts]
        return files, rows

    def _recalls(self, arena: str, files: list[Experience], seeds: list[int]) -> Iterator[LabRecall]:
        """All recalls in an arena, but for those whose robot the camera never found where it was placed."""
        vectors, behaviours = arrays(files)
        with closing(recall_env(arena, limit=self.size.steps, world=self._world(arena, 1))) as env:
            imitator = NearestNeighbourImitator(diagonal=env.diagonal).fit(vectors, behaviours)
            policies: dict[str, Policy] = {TEACHER: Teacher.of(env), IMITATOR: imitator}
            for learner, policy in policies.items():
                taught = learner == IMITATOR
                once = partial(
                    recall,
                    env,
                    policy,
                    learner=learner,
                    replication=self.number,
                    episodes=self.size.files if taught else 0,
                    file_id=f"g1-{self.size.files}" if taught else "-",
                    experience_size=len(behaviours) if taught else 0,
                )
                for number, seed in enumerate(seeds):
                    with suppress(OperatorGaveUp):
                        row = _repeated(partial(once, seed, number=number))
                        yield LabRecall(**asdict(row), world=self.world)

    def _world(self, arena: str, robots: int) -> World | None:
        return virtual_laboratory(arena, robots) if self.world == VIRTUAL else None


def _repeated(recall_once: Callable[[], RecallRow]) -> RecallRow:
    """A recall, repeated if a robot is lost on its undisturbed line, as may happen on a busy computer."""
    for _ in range(_REPEATS):
        with suppress(RecallInterruptedError, RobotLost):
            return recall_once()
    return recall_once()


LOCK_STEP, PACED = "lock-step", "wall clock"
"""As fast as the machine allows; bytes at 38400 baud and rounds in real time."""
TIMED_ROUNDS = {LOCK_STEP: (1000, 40), PACED: (300, 20)}
"""Rounds whose time is measured, and their number with --quick."""
_METHODS: tuple[tuple[str, type, str], ...] = (
    ("transmit", Fleet, "transmit"),
    ("wait", WallClock, "wait"),
    ("simulate", SimulatedClock, "wait"),
    ("receive", Fleet, "receive"),
    ("render", RenderedFrameSource, "newest"),
    ("track", Tracker, "update"),
)
"""A part's name, and the method whose time it is, without the parts that the method calls."""
PARTS = {
    "transmit": ("transmit", "#0072B2"),
    "wait": ("wait for the clock", "0.92"),
    "simulate": ("simulate the bodies", "#009E73"),
    "receive": ("receive", "#56B4E9"),
    "render": ("render", "#E69F00"),
    "track": ("track", "#D55E00"),
    "decide": ("perceive, decide and the rest", "#CC79A7"),
}
"""Names of the parts for people, and their colours, in the order of a round."""


@dataclass(frozen=True, slots=True)
class TimedRound:
    """One round of a training of two robots; times of its parts in ms.

    Attributes:
        pace: `lock-step` or `wall clock`.
        transmit: Commands to both robots.
        wait: For the clock.
        simulate: The simulated bodies.
        receive: Senses of both robots.
        render: The frame.
        track: The tracker on it.
        decide: The rest: perception of both robots, teacher, learner, following, records.
        busy: All without the wait.
        late: Whether the round took longer than it should.
    """

    pace: str
    transmit: float
    wait: float
    simulate: float
    receive: float
    render: float
    track: float
    decide: float
    busy: float
    late: bool


class _Enough(Exception):  # noqa: N818 (it ends a training, and nothing failed)
    """There have been as many rounds as wanted."""


class Stopwatch:
    """One clock that always runs for exactly one part of a program, and the seconds of each part."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._part, self._since = "decide", time.perf_counter()

    def switch(self, part: str) -> str:
        """Run for another part from now on; returns the part so far."""
        now, before = time.perf_counter(), self._part
        self.seconds[before] += now - self._since
        self._part, self._since = part, now
        return before

    def timed(self, method: Callable[..., Any], part: str) -> Callable[..., Any]:
        """The same method, with the clock running for its part."""

        def run(*args: Any, **kwargs: Any) -> Any:
            caller = self.switch(part)
            try:
                return method(*args, **kwargs)
            finally:
                self.switch(caller)

        return run


class Timing(NamedTuple):
    """Rounds of one training after the other, without the first round of each attempt."""

    pace: str
    rounds: int
    seed: int

    @property
    def key(self) -> str:
        """The pace."""
        return f"time of rounds, {self.pace}"

    def run(self) -> list[TimedRound]:
        """Measure them."""
        rows: list[TimedRound] = []
        paced = self.pace == PACED
        watch = Stopwatch()
        with ExitStack() as stack:
            for part, owner, name in _METHODS:
                stack.enter_context(patch.object(owner, name, watch.timed(getattr(owner, name), part)))
            lab = stack.enter_context(virtual_laboratory("corridor", 2, paced=paced, real_time=paced))
            env = stack.enter_context(closing(TrainingEnv(noise=Noise.none(), world=lab)))
            late = 0

            def note() -> None:
                nonlocal late
                watch.switch("decide")
                if env.infos[TEACHER_ROBOT]["steps"] > 1:  # the first round includes the operator's work
                    times = {part: 1000 * watch.seconds[part] for part in PARTS}
                    busy = sum(times.values()) - times["wait"]
                    rows.append(TimedRound(self.pace, **times, busy=busy, late=lab.clock.overruns > late))
                late = lab.clock.overruns
                watch.seconds.clear()
                if len(rows) >= self.rounds:
                    raise _Enough

            with suppress(_Enough):
                for seed in np.random.SeedSequence(self.seed).spawn(self.rounds):
                    train(env, seed, callback=note)
        return rows


@contextmanager
def _silence() -> Iterator[None]:
    """Log nothing: losses are counted here, and need not be reported."""
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


@dataclass(frozen=True, slots=True)
class DisturbedAttempt:
    """One attempt at a training episode on disturbed lines; see also `Attempt`.

    Attributes:
        fault: Which, or `NO_FAULT`.
        rate: Share of replies with the fault.
        rounds: Begun rounds.
        lost: What was lost in the last round; empty if nothing was.
        kept: Whether the experience is on disk: of a complete attempt, of one interrupted by a loss, or of the last
            one. That of another incomplete attempt is forgotten (5.2).
        faults: In the rounds.
        unseen: Garbled replies among these that read as other valid ones.
        disturbed: Rounds with a fault.
        misread: Rounds after which a driver reported other senses than its body's, counters not considered.
        miscounted: Rounds in which a driver's counters changed differently from its body's.
        moving: Robots that still moved after the end.
        vectors: Shown to the learner with a behaviour.
        altered: Vectors on disk that differ from those shown, are missing, or are too many.
        wrong: Untrue vectors among those shown.
        seconds: Of all rounds.
    """

    fault: str
    rate: float
    rounds: int
    lost: str
    kept: bool
    faults: int
    unseen: int
    disturbed: int
    misread: int
    miscounted: int
    moving: int
    vectors: int
    altered: int
    wrong: int
    seconds: float


class DisturbedTrainings(NamedTuple):
    """Trainings of two robots, one after the other, for a fixed number of rounds."""

    fault: str
    rate: float
    rounds: int
    seed: int

    @property
    def key(self) -> str:
        """Fault and rate."""
        return f"fault {self.fault} {self.rate:g}"

    def run(self) -> list[DisturbedAttempt]:
        """One row an attempt; the last attempt is interrupted, as by Ctrl-C."""
        rates = {} if self.fault == NO_FAULT else {self.fault: self.rate}
        left = self.rounds
        rows: list[DisturbedAttempt] = []

        def count(_: ObservedTraining) -> None:
            nonlocal left
            left -= 1
            if left <= 0:
                raise _Enough

        with (
            _silence(),
            TemporaryDirectory() as folder,
            virtual_laboratory("corridor", 2, fault_seed=self.seed) as lab,
            closing(ObservedTraining(lab, count, Faults(lateness=LATENESS, **rates))) as env,
        ):
            number = 0
            while left > 0:
                path = Path(folder) / f"g{number}.csv"
                with suppress(_Enough, IncompleteTrainingError):
                    train(env, np.random.SeedSequence(self.seed, spawn_key=(number,)), path=path)
                for i, attempt in enumerate(env.attempts, start=1):
                    lost = path.with_name(f"{path.stem}.lost-{i}{path.suffix}")
                    last = path if i == len(env.attempts) and path.exists() else None
                    rows.append(self._row(attempt, lost if lost.exists() else last))
                env.attempts.clear()
                number += 1
            env.close()
            rows[-1] = replace(rows[-1], moving=rows[-1].moving + len(moving(lab)))
        return rows

    def _row(self, attempt: Attempt, file: Path | None) -> DisturbedAttempt:
        altered = 0
        if file is not None:
            with warnings.catch_warnings():
                # Only the file of a complete episode has a closing line.
                warnings.simplefilter("ignore", ExperienceWarning)
                stored = list(Experience.load(file, recover=True))
            altered = sum(a != b for a, b in zip_longest(stored, attempt.perceived))
        same = ("faults", "unseen", "disturbed", "misread", "miscounted", "moving")
        return DisturbedAttempt(
            *(self.fault, self.rate, attempt.rounds, attempt.lost, file is not None),
            **{name: getattr(attempt, name) for name in same},
            vectors=len(attempt.perceived),
            altered=altered,
            wrong=sum(attempt.wrong),
            seconds=attempt.seconds,
        )


_WORLDS = (
    "Virtual laboratory: real driver, real bytes over pseudo-terminals, real tracker on rendered frames. Pymunk alone: "
    "the same bodies with the simulated camera. Both with the laboratory's noise. Brackets: 95 % interval, by "
    "resampling replications. Difference: virtual laboratory minus pymunk, replications paired by their seeds."
)
RECALL_MEASURES = (
    Measure[LabRecall]("score (%)", lambda row: row.score),
    Measure[LabRecall]("food delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.foods),
    Measure[LabRecall]("steps", lambda row: row.steps),
)
TRAINING_MEASURES = (
    Measure[LabTraining]("attempts complete (%)", lambda row: 100.0 * row.complete),
    Measure[LabTraining](
        "rounds of a complete episode", lambda row: row.complete * row.rounds, lambda row: row.complete
    ),
)
_COMPARED = (
    *(Column("measure"), Column("episodes"), Column("pymunk alone", estimate=True)),
    *(Column("virtual laboratory", estimate=True), Column("difference", estimate=True)),
)


def _compared(
    measure: Measure[Any], rows: Sequence[LabRecall | LabTraining]
) -> tuple[str, str, Estimate, Estimate, Estimate]:
    """A measure in both worlds; the same rows give the same intervals."""
    pymunk, virtual = (pick(rows, world=world) for world in WORLDS)
    rng = [np.random.default_rng(20010) for _ in range(3)]
    episodes = " / ".join(map(str, dict.fromkeys((len(pymunk), len(virtual)))))
    change = difference(virtual, pymunk, measure, rng[2])
    return measure.name, episodes, mean(pymunk, measure, rng[0]), mean(virtual, measure, rng[1]), change


def training_table(rows: Sequence[LabTraining]) -> Table:
    """Training in both worlds."""
    note = f"{_WORLDS} One learner and the teacher in two corridors, until an episode is complete."
    lines = [_compared(measure, rows) for measure in TRAINING_MEASURES]
    return Table("trainings", "Training episodes", note, _COMPARED, lines)


def recall_table(rows: Sequence[LabRecall]) -> Table:
    """Recalls in both worlds."""
    note = (
        f"{_WORLDS} The random places are the same in both. The imitator recalls in the world of its training, which "
        "was in the corridor. A recall whose robot the camera never found where it was placed is left out."
    )
    lines = [
        (arena, policy, *_compared(measure, pick(rows, arena=arena, learner=policy)))
        for arena in ARENAS
        for policy in (TEACHER, IMITATOR)
        for measure in RECALL_MEASURES
    ]
    return Table("recalls", "Recalls", note, (Column("arena"), Column("policy"), *_COMPARED), lines)


def round_table(rows: Sequence[TimedRound]) -> Table:
    """Times by part."""
    columns = (
        Column("part of a round"),
        Column("lock-step (ms)", digits=2, estimate=True),
        Column("wall clock, 38400 baud (ms)", digits=2, estimate=True),
    )
    own = {pace: pick(rows, pace=pace) for pace in (LOCK_STEP, PACED)}
    counts = ", ".join(
        f"{pace}: {len(its)} rounds, {sum(row.late for row in its)} late" for pace, its in own.items()
    )
    note = (
        "Two robots in training: median [5th, 95th percentile]. Lock-step: without pace, as fast as the machine "
        "allows. Wall clock: bytes at 38400 baud and rounds in real time; a round that takes longer is late. Robots, "
        "camera and everything else share one computer here; a real laboratory has neither simulation nor rendering. "
        f"{counts}."
    )
    names = {**{part: name for part, (name, _) in PARTS.items()}, "busy": "all without the wait"}
    lines: list[tuple[Value, ...]] = [
        (name, *(quantiles([getattr(row, part) for row in its]) for its in own.values()))
        for part, name in names.items()
    ]
    return Table("rounds", "The time of a round", note, columns, lines)


def _by_fault(rows: Sequence[DisturbedAttempt]) -> dict[tuple[str, float], list[DisturbedAttempt]]:
    """The attempts with each fault at each rate, the undisturbed ones first."""
    conditions = [(NO_FAULT, 0.0), *((fault, rate) for fault in FAULTS for rate in RATES)]
    own = {(fault, rate): pick(rows, fault=fault, rate=rate) for fault, rate in conditions}
    return {condition: its for condition, its in own.items() if its}


def _ms_a_round(rows: Sequence[DisturbedAttempt]) -> float:
    return 1000 * sum(row.seconds for row in rows) / sum(row.rounds for row in rows)


def fault_table(rows: Sequence[DisturbedAttempt]) -> Table:
    """Effects of faults on rounds and on the experience."""
    note = (
        "Trainings of two robots in lock-step, one after the other, for a fixed number of rounds; the last training is "
        "interrupted. Rates are shares of all replies. The lines are undisturbed while the operator places things. "
        f"Delayed replies are {1000 * LATENESS[0]:.0f} to {1000 * LATENESS[1]:.0f} ms late; the driver repeats its "
        "request after 100 ms. Moving: robots whose simulated bodies moved or turned a wheel after a loss, or after "
        "the end. Kept: files of episodes that a loss has ended. Shown: state vectors with a behaviour, as the learner "
        "perceived and heard them. Altered: missing on disk, additional, or different from what was shown. The "
        "protocol has no checksum: unseen are garbled replies that read as other valid ones. Misread and miscounted "
        "are rounds in which the driver accepted a sense that was not the body's, or a wrong turn of the wheels; "
        "pulses before a restart are lost with the counters. Wrong: shown vectors that differ from what the learner's "
        "body senses in that round, or whose behaviour differs from what the teacher would call on its own body's "
        "senses."
    )
    names = {
        "rounds": "rounds",
        "faults": "faults",
        "disturbed": "rounds disturbed",
        "moving": "moving",
        "vectors": "shown",
        "altered": "altered",
        "unseen": "unseen",
        "misread": "misread",
        "miscounted": "miscounted",
        "wrong": "wrong",
    }
    lines: list[tuple[Value, ...]] = []
    for (fault, rate), own in _by_fault(rows).items():
        lost = [row for row in own if row.lost]
        sums = [sum(getattr(row, name) for row in own) for name in names]
        kept = sum(row.kept for row in lost)
        lines.append((fault, 100 * rate, *sums, len(lost), kept, _ms_a_round(own)))
    headings = ("fault", "rate (%)", *names.values(), "robots lost", "kept", "a round (ms)")
    return Table("faults", "Disturbed lines", note, tuple(map(Column, headings)), lines)


def recall_picture(rows: Sequence[LabRecall]) -> "Figure":
    """Score, food and steps in both worlds."""
    figure = new_figure(WIDTH, 3.2)
    panels = figure.subplots(1, len(RECALL_MEASURES), sharey=True)
    for axes, measure in zip(panels, RECALL_MEASURES, strict=True):
        shown = {}
        for arena in ARENAS:
            for policy in (TEACHER, IMITATOR):
                *_, pymunk, virtual, _ = _compared(measure, pick(rows, arena=arena, learner=policy))
                shown[f"{policy}, {arena}"] = pymunk, virtual
        levels(axes, shown, measure.name, ("pymunk alone", "virtual laboratory"), (THESIS, OURS))
        values = [v for pair in shown.values() for estimate in pair for v in estimate if np.isfinite(v)]
        lowest, highest = min(0.0, *values), max(values)
        axes.set_xlim(lowest - 0.04 * (highest - lowest), highest + 0.06 * (highest - lowest))
        axes.tick_params(axis="y", length=0)
    legend(figure, panels[0], "bars: 95 % interval")
    return figure


def round_picture(rows: Sequence[TimedRound]) -> "Figure":
    """Mean times of the parts of a round, one after the other."""
    figure = new_figure(WIDTH, 3.0)
    panels = figure.subplots(2, 1)
    names = {LOCK_STEP: "lock-step", PACED: "wall clock,\n38400 baud"}
    for axes, (pace, name) in zip(panels, names.items(), strict=True):
        begin = 0.0
        for part, (label, colour) in PARTS.items():
            width = float(np.mean([getattr(row, part) for row in pick(rows, pace=pace)]))
            axes.barh(0, width, 0.5, begin, color=colour, ec="0.4", lw=0.4, label=label)
            begin += width
        axes.set_yticks([0], [name])
        axes.tick_params(axis="y", length=0)
        axes.set_xlim(0, begin * 1.01)
    panels[1].set_xlabel("time of the parts of a round of two robots (ms, mean)")
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "columnspacing": 1.2}
    panels[0].legend(ncols=4, fontsize=SMALL, frameon=False, **place)
    return figure


def fault_picture(rows: Sequence[DisturbedAttempt]) -> "Figure":
    """Shares of disturbed and lost rounds, and their time, by fault and rate."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    results = _by_fault(rows)
    rates = sorted({rate for _, rate in results} - {0.0})
    shades = dict(zip(rates, ("#9ecae1", "#4292c6", "#08519c")[-len(rates) :], strict=True))
    figure = new_figure(WIDTH, 3.4)
    left, right = figure.subplots(1, 2)
    for number, (rate, shade) in enumerate(shades.items()):
        own = [results[fault, rate] for fault in FAULTS]
        places = np.arange(len(own)) + (number - (len(rates) - 1) / 2) * 0.27
        rounds = np.array([sum(row.rounds for row in its) for its in own])
        disturbed = 100 * np.array([sum(row.disturbed for row in its) for its in own]) / rounds
        lost = 100 * np.array([sum(bool(row.lost) for row in its) for its in own]) / rounds
        left.bar(places, disturbed, 0.25, color=shade)
        left.bar(places, lost, 0.25, color="none", edgecolor=THESIS, lw=1.5, hatch="////")
        right.bar(places, [_ms_a_round(its) for its in own], 0.25, color=shade)
    right.axhline(_ms_a_round(results[NO_FAULT, 0.0]), color=GREY, lw=1, ls="--")
    left.set_ylabel("rounds disturbed (%)", fontsize=9)
    right.set_ylabel("time of a round without pace (ms)", fontsize=9)
    for axes in (left, right):
        axes.set_xticks(range(len(FAULTS)), FAULTS)
        axes.tick_params(labelsize=SMALL)
        grid(axes)
    handles: list[Patch | Line2D] = [
        Patch(color=shade, label=f"faults in {100 * rate:g} % of replies") for rate, shade in shades.items()
    ]
    handles.append(Patch(fc="none", ec=THESIS, lw=1.5, hatch="////", label="rounds with a robot lost"))
    handles.append(Line2D([], [], color=GREY, lw=1, ls="--", label="without faults"))
    figure.legend(handles=handles, loc="outside upper center", ncols=3, frameon=False, fontsize=SMALL)
    return figure


def main() -> int:
    """Run the benchmark."""
    # Drivers wait most of the time: one process more than there are cores.
    given = parse("virtual_lab", __doc__, *COUNTS, jobs=1 + (os.cpu_count() or 1))
    seed, quick = given.seed, given.quick
    tables = {
        LabRecall: "recalls",
        LabTraining: "trainings",
        TimedRound: "rounds",
        DisturbedAttempt: "attempts",
    }
    timings = [Timing(pace, counts[quick], seed) for pace, counts in TIMED_ROUNDS.items()]
    timed = collect(given, timings, tables, in_processes(1)).of(TimedRound)
    size = QUICK if quick else Size()
    rates = QUICK_RATES if quick else RATES
    units: list[Unit] = [
        *(DisturbedTrainings(fault, rate, given.rounds, seed) for rate in rates[::-1] for fault in FAULTS),
        DisturbedTrainings(NO_FAULT, 0.0, given.rounds, seed),
        *(Replication(world, i, size, seed) for i in range(given.replications) for world in WORLDS),
    ]
    given.fresh = False
    rows = collect(given, units, tables)
    recalls, faults = rows.of(LabRecall), rows.of(DisturbedAttempt)
    parts: list[Table | Picture] = [
        training_table(rows.of(LabTraining)),
        recall_table(recalls),
        Picture("recalls", "recalls in both worlds", recall_picture(recalls)),
        round_table(timed),
        Picture("rounds", "the parts of a round", round_picture(timed)),
        fault_table(faults),
        Picture("faults", "effects of faults", fault_picture(faults)),
    ]
    return finish(given, Page("The virtual laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
