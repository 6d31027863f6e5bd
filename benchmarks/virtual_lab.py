"""The virtual laboratory beside simulated bodies alone: the effects of real bytes and frames.

    python benchmarks/virtual_lab.py --help

Training and recall with real drivers on pseudo-terminals and the real tracker on rendered frames, compared with pymunk
alone.
"""

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Measure, Table, Value, difference, mean, pick, table_of
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
ALONE, LAB = "pymunk alone", "virtual laboratory"
"""Their columns."""
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
    vectors, behaviours = arrays(files)
    for arena, arena_seed in zip(ARENAS, recalling, strict=True):
        with closing(recall_env(arena, limit=size.steps, world=_world(world, arena, 1))) as env:
            imitator = NearestNeighbourImitator(diagonal=env.diagonal).fit(vectors, behaviours)
            taught = {"episodes": len(files), "file_id": f"g1-{len(files)}", "experience_size": len(behaviours)}
            policies: dict[str, tuple[Policy, dict[str, Any]]] = {
                TEACHER: (Teacher.of(env), {}),
                IMITATOR: (imitator, taught),
            }
            for learner, (policy, learned) in policies.items():
                about: dict[str, Any] = {"learner": learner, "replication": number, **learned}
                for recalled, recall_seed in enumerate(arena_seed.generate_state(size.recalls).tolist()):
                    once = partial(recall, env, policy, recall_seed, number=recalled, **about)
                    rows += [LabRecall(**asdict(row), world=world) for row in _repeated(once)]
    return rows


def _world(world: str, arena: str, robots: int) -> World | None:
    return virtual_laboratory(arena, robots) if world == VIRTUAL else None


def _repeated(recall_once: Callable[[], RecallRow]) -> list[RecallRow]:
    """A recall, repeated if a robot is lost on its undisturbed line, as may happen on a busy computer.

    There is none if the camera never found the robot where it was placed.
    """
    for _ in range(_REPEATS):
        try:
            return [recall_once()]
        except OperatorGaveUp:
            return []
        except (RecallInterruptedError, RobotLost):
            continue
    return [recall_once()]


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


def compared(recalls: Sequence[LabRecall], trainings: Sequence[LabTraining]) -> list[dict[str, Value]]:
    """All measures in both worlds; the same rows give the same intervals."""
    groups: list[tuple[str, Sequence[Any], Sequence[Measure[Any]]]] = [("training", trainings, TRAINING_MEASURES)]
    for arena in ARENAS:
        for policy in (TEACHER, IMITATOR):
            groups.append((f"{policy}, {arena}", pick(recalls, arena=arena, learner=policy), RECALL_MEASURES))
    lines: list[dict[str, Value]] = []
    for what, rows, measures in groups:
        pymunk, virtual = (pick(rows, world=world) for world in WORLDS)
        for measure in measures:
            rngs = [np.random.default_rng(20010) for _ in range(3)]
            lines.append(
                {
                    "what": what,
                    "measure": measure.name,
                    "episodes": " / ".join(map(str, dict.fromkeys((len(pymunk), len(virtual))))),
                    ALONE: mean(pymunk, measure, rngs[0]),
                    LAB: mean(virtual, measure, rngs[1]),
                    "difference": difference(virtual, pymunk, measure, rngs[2]),
                }
            )
    return lines


def picture(lines: Sequence[dict[str, Any]]) -> "Figure":
    """Score, food and steps of recalls in both worlds."""
    figure = new_figure(WIDTH, 3.2)
    panels = figure.subplots(1, len(RECALL_MEASURES), sharey=True)
    for axes, measure in zip(panels, RECALL_MEASURES, strict=True):
        shown = {line["what"]: (line[ALONE], line[LAB]) for line in lines if line["measure"] == measure.name}
        levels(axes, shown, measure.name, (ALONE, LAB), (THESIS, OURS))
        values = [value for pair in shown.values() for estimate in pair for value in estimate if np.isfinite(value)]
        lowest, highest = min([0.0, *values]), max([1.0, *values])
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
    lines = compared(rows.of(LabRecall), rows.of(LabTraining))
    note = (
        "Virtual laboratory: real driver, real bytes over pseudo-terminals, real tracker on rendered frames. Pymunk "
        "alone: the same bodies with the simulated camera. Both with the laboratory's noise. Brackets: 95 % interval, "
        "by resampling replications. Difference: virtual laboratory minus pymunk, replications paired by their seeds. "
        "Training: one learner and the teacher in two corridors. Recalls: from the same random places in both; the "
        "imitator in the world of its training, which was in the corridor; without those whose robot the camera never "
        "found where it was placed."
    )
    parts: list[Table | Picture] = [
        table_of("worlds", "Training and recall", note, lines),
        Picture("recalls", "recalls in both worlds", picture(lines)),
    ]
    return finish(given, Page("The virtual laboratory", parts))


if __name__ == "__main__":
    sys.exit(main())
