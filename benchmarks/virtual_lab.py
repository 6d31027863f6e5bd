"""The virtual laboratory beside simulated bodies alone: the effects of real bytes and frames.

    python benchmarks/virtual_lab.py --help

Training and recall with real drivers on pseudo-terminals and the real tracker on rendered frames, compared with pymunk
alone.
"""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Column, Estimate, Measure, Table, difference, mean, pick
from khepera_forage.experience import Experience
from khepera_forage.figures import OURS, THESIS, WIDTH, legend, levels, new_figure
from khepera_forage.lab.operator import OperatorGaveUp
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.robots.khepera import RobotLost
from khepera_forage.rollouts.recall import RecallInterruptedError, recall, recall_env
from khepera_forage.rollouts.rows import IMITATOR, TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.training import arrays, train
from khepera_forage.sim.world import World
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COUNT = Count("replications", 16, 1, "trainings and recalls, in each world", adds_units=True)
WORLDS = PYMUNK, VIRTUAL = ("pymunk", "virtual")
ARENAS = ("corridor", "rectangle")
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


class Amounts(NamedTuple):
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


QUICK = Amounts(files=1, recalls=1, rounds=250, steps=200)


def replication(world: str, number: int, size: Amounts, seed: int) -> list[LabRecall | LabTraining]:
    """Training files in one world, then recalls of the teacher and of the imitator of all these files there.

    A replication has the same seeds in both worlds: the same marks in training, the same random places in recall. The
    noise of the operator's hand, the wheels and the camera differs.
    """
    training, *recalling = np.random.SeedSequence(seed, spawn_key=(number,)).spawn(1 + len(ARENAS))
    files: list[Experience] = []
    rows: list[LabRecall | LabTraining] = []
    body = _world(world, "corridor", 2)
    # In the virtual laboratory, the operator's hand makes the errors of placement.
    noise = None if body is None else Noise.none()
    with closing(TrainingEnv(noise=noise, max_cycles=size.rounds, world=body)) as env:
        for file, file_seed in enumerate(training.spawn(size.files), start=1):
            experience, attempts = train(env, file_seed, replication=number, file=file)
            files.append(experience)
            rows += [LabTraining(**asdict(row), world=world) for row in attempts]
    for arena, arena_seed in zip(ARENAS, recalling, strict=True):
        with closing(recall_env(arena, limit=size.steps, world=_world(world, arena, 1))) as env:
            seeds = arena_seed.generate_state(size.recalls).tolist()
            rows += [LabRecall(**asdict(row), world=world) for row in _recalls(env, files, seeds, number)]
    return rows


def _recalls(env: BehavioursEnv, files: list[Experience], seeds: list[int], replication: int) -> Iterator[RecallRow]:
    """All recalls in an arena, but for those whose robot the camera never found where it was placed."""
    vectors, behaviours = arrays(files)
    imitator = NearestNeighbourImitator(diagonal=env.diagonal).fit(vectors, behaviours)
    taught = {"episodes": len(files), "file_id": f"g1-{len(files)}", "experience_size": len(behaviours)}
    policies: dict[str, tuple[Policy, dict[str, Any]]] = {TEACHER: (Teacher.of(env), {}), IMITATOR: (imitator, taught)}
    for learner, (policy, learned) in policies.items():
        once = partial(recall, env, policy, learner=learner, replication=replication, **learned)
        for number, seed in enumerate(seeds):
            with suppress(OperatorGaveUp):
                yield _repeated(partial(once, seed, number=number))


def _world(world: str, arena: str, robots: int) -> World | None:
    return virtual_laboratory(arena, robots) if world == VIRTUAL else None


def _repeated(recall_once: Callable[[], RecallRow]) -> RecallRow:
    """A recall, repeated if a robot is lost on its undisturbed line, as may happen on a busy computer."""
    for _ in range(_REPEATS):
        with suppress(RecallInterruptedError, RobotLost):
            return recall_once()
    return recall_once()


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


def main() -> int:
    """Run the benchmark."""
    # Drivers wait most of the time: one process more than there are cores.
    given = parse("virtual_lab", __doc__, COUNT, jobs=1 + (os.cpu_count() or 1))
    size = QUICK if given.quick else Amounts()
    numbers = range(given.replications)
    units = [Job(f"{world} {i}", replication, (world, i, size, given.seed)) for i in numbers for world in WORLDS]
    rows = collect(given, units, {LabRecall: "recalls", LabTraining: "trainings"})
    recalls = rows.of(LabRecall)
    parts: list[Table | Picture] = [
        training_table(rows.of(LabTraining)),
        recall_table(recalls),
        Picture("recalls", "recalls in both worlds", recall_picture(recalls)),
    ]
    return finish(given, Page("The virtual laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
