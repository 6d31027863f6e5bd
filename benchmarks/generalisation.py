"""How far learned foraging carries: learners trained in one corridor, or in many arenas, forage in arenas new to them.

    python benchmarks/generalisation.py --help

Every learner from experience vectors, and a decision tree by DAgger. Recalls in the arenas of the thesis, in the named
family and in procedural test arenas of rising difficulty; the teacher and random behaviours as bounds. Which attribute
of the state vector the imitator's wrong decisions are due to, and what distances along the path change. Needs numba
(the extra `fast`).
"""

import sys

import numpy as np
from arena_generalisation import page
from arena_generalisation.analysis import Analysis
from arena_generalisation.replication import Replication, Size
from arena_generalisation.rows import ArenaRecalls, WrongDecisions

from khepera_forage.experiments.arguments import Count, parse
from khepera_forage.experiments.page import finish
from khepera_forage.experiments.processes import collect
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS

COUNTS = (
    Count("seeds", 10, 1, "replications, each with training and test arenas of its own", adds_units=True),
    Count("recalls", 2, 1, "recalls of each learner in each arena, in each replication"),
    Count("levels", 1, 1, "test arenas of each difficulty in each replication"),
)
QUICK_NAMED, QUICK_DIFFICULTIES = ("corridor", "rectangle", "t_maze", "mixed_foods"), ("easy", "medium")
QUICK_LIMIT = 500
"""Steps of a recall: the teacher needs no more."""
TABLES = {ArenaRecalls: "recalls", WrongDecisions: "wrong_decisions"}


def main() -> int:
    """Run the benchmark."""
    given = parse("generalisation", __doc__, *COUNTS)
    seeds, recalls, levels = given.counts.values()
    size = Size(
        recalls,
        levels,
        QUICK_NAMED if given.quick else ARENAS,
        QUICK_DIFFICULTIES if given.quick else tuple(DIFFICULTIES),
        QUICK_LIMIT if given.quick else None,
    )
    rows = collect(given, [Replication(given.seed, number, size) for number in range(seeds)], TABLES)
    rng = np.random.default_rng((given.seed, 1))
    found = Analysis(rows.of(ArenaRecalls), rows.of(WrongDecisions), rng)
    return finish(given, page.page(found))


if __name__ == "__main__":
    sys.exit(main())
