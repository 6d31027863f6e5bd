"""How reliably and how fast the teacher forages, and whether the task is trivial.

    python benchmarks/teacher.py --help

The teacher forages alone in the corridor and in the rectangle, for each type of food, from many random starts. A
second policy does SEARCH FOR FOOD where the teacher does ORIENT WITH FOOD. It must deliver nothing: otherwise ORIENT
would not matter.
"""

import sys

from teacher_alone.forages import Forage, blocks
from teacher_alone.page import page

from khepera_forage.study import Count, collect, finish, parse


def main() -> int:
    """Run the benchmark."""
    forages = Count("forages", 500, 15, "random starts of each line", adds_units=True)
    given = parse("teacher", __doc__, forages)
    rows = collect(given, blocks(given.seed, given.forages), {Forage: "forages"})
    return finish(given, page(rows.of(Forage)))


if __name__ == "__main__":
    sys.exit(main())
