"""How far learned foraging carries: learners trained in one corridor, or in many arenas, forage in arenas new to them.

    python benchmarks/generalisation.py --help

Every learner that acts with behaviours: those from experience vectors, DAgger with a network and with a decision tree,
and reinforcement learners. Recalls in the arenas of the thesis, in the named family and in procedural test arenas of
rising difficulty; the teacher and random behaviours as bounds. Which attribute of the state vector the imitator's wrong
decisions are due to, and what distances along the path change. Needs numba (the extra `fast`). Without
stable-baselines3 (the extra `baselines`), reinforcement learners are left out.
"""

import sys

import numpy as np
from arena_generalisation import page
from arena_generalisation.analysis import Analysis
from arena_generalisation.learner_replication import LearnerReplication, single_learners
from arena_generalisation.replication import Replication
from arena_generalisation.rows import ArenaRecalls, WrongDecisions
from arena_generalisation.size import Size

from khepera_forage.comparison.units import missing_extra, settings_of
from khepera_forage.experiments.arguments import Arguments, Count, parse
from khepera_forage.experiments.page import finish
from khepera_forage.experiments.processes import Unit, collect
from khepera_forage.experiments.row_folder import UNITS, finished_units
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS

COUNTS = (
    Count("seeds", 10, 1, "replications, each with training and test arenas of its own", adds_units=True),
    Count("recalls", 2, 1, "recalls of each learner in each arena, in each replication"),
    Count("levels", 1, 1, "test arenas of each difficulty in each replication"),
    Count("steps", 1_000_000, 1_000, "environment steps of each training of a reinforcement learner"),
)
QUICK_NAMED, QUICK_DIFFICULTIES = ("corridor", "rectangle", "t_maze", "mixed_foods"), ("easy", "medium")
QUICK_LIMIT, QUICK_QUERIES = 500, 200
"""Steps of a recall: the teacher needs no more. Queries to the teacher in each training."""
TABLES = {ArenaRecalls: "recalls", WrongDecisions: "wrong_decisions"}


def main() -> int:
    """Run the benchmark."""
    given = parse("generalisation", __doc__, *COUNTS)
    seeds, recalls, levels, steps = given.counts.values()
    size = Size(
        recalls,
        levels,
        QUICK_NAMED if given.quick else ARENAS,
        QUICK_DIFFICULTIES if given.quick else tuple(DIFFICULTIES),
        steps,
        *((QUICK_LIMIT, QUICK_QUERIES) if given.quick else ()),
    )
    trained, left_out = single(given, size, range(seeds))
    for name, reason in left_out.items():
        print(f"{name} is left out: {reason}")
    units: list[Unit] = []
    for number in range(seeds):
        units.append(Replication(given.seed, number, size))
        units += [unit for unit in trained if unit.number == number]
    settings = {f"learner {unit.name}": settings_of(unit.learner) for unit in trained}
    rows = collect(given, units, TABLES, settings=settings)
    rng = np.random.default_rng((given.seed, 1))
    found = Analysis(rows.of(ArenaRecalls), rows.of(WrongDecisions), rng)
    return finish(given, page.page(found, steps, left_out))


def single(
    given: Arguments, size: Size, replications: range
) -> tuple[list[LearnerReplication], dict[str, str]]:
    """All work of the learners that have units of their own, and why some of them are left out.

    A learner that cannot be trained here takes part if an earlier run has left all of its rows in the folder.

    Args:
        given: Folder and seed.
        size: Of the run.
        replications: Of each learner.
    """
    try:
        finished = set() if given.fresh else set(finished_units(given.out))
    except ValueError as error:
        given.refuse(f"{given.out / UNITS}: {error}")
    units, left_out = [], {}
    for name, learner in single_learners().items():
        own = [LearnerReplication(given.seed, number, size, name, learner) for number in replications]
        reason = missing_extra(learner)
        if reason and not finished.issuperset(unit.key for unit in own):
            left_out[name] = reason
        else:
            units += own
    return units, left_out


if __name__ == "__main__":
    sys.exit(main())
