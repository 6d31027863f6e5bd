"""Whether the teacher finds its way in every arena of the family and in procedural arenas, on both backends.

    python benchmarks/arenas.py --help

Recalls under the teacher with the laboratory's noise and the same seeds on pymunk and compiled, for each type of food.
Needs numba (the extra `fast`).
"""

import sys

import numpy as np
from arena_deliveries.page import page
from arena_deliveries.recalls import Delivery, units

from khepera_forage.study import Count, collect, finish, parse


def main() -> int:
    """Run the benchmark."""
    levels = Count("levels", 250, 2, "test levels of each difficulty", adds_units=True)
    recalls = Count("recalls", 100, 3, "recalls in each named arena", adds_units=True)
    given = parse("arenas", __doc__, levels, recalls)
    rows = collect(given, units(given.seed, given.levels, given.recalls), {Delivery: "deliveries"})
    found = page(rows.of(Delivery), given.levels, given.recalls, np.random.default_rng(given.seed))
    return finish(given, found)


if __name__ == "__main__":
    sys.exit(main())
