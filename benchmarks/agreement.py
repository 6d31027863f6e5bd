"""Whether recalls on the two backends agree, and whether the thesis's experiments give the results of version 0.1.

    python benchmarks/agreement.py --help

Teacher and imitator in a family of random arenas: recalls with the same seeds on both backends. Teacher and imitator
in corridor and rectangle: scores, steps and food delivered of thousands of recalls on each backend, and the same with
wheels 2 % slow on the compiled one, which the tests must detect. The thesis's experiments, training included, on both
backends. The cells of `khepera-forage reproduce` beside those of version 0.1. Needs numba (the extra `fast`).
"""

import sys
from collections.abc import Sequence

import numpy as np
from backend_agreement import (
    before_after,
    experiments,
    page,
    paired,
    paired_pictures,
    paired_tables,
    samples,
    two_sample_tests,
)
from backend_agreement.arenas import RandomArena, random_arena
from backend_agreement.paired import PairedRecall
from backend_agreement.samples import PymunkRecall

from khepera_forage.estimates import Table, pick
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.study import Arguments, Count, Page, Picture, Rows, Unit, collect, finish, parse
from khepera_forage.thesis.design import THESIS

COUNTS = (
    Count("episodes", 3_000, 50, "recalls of each condition with pymunk", adds_units=True, least=2),
    Count("arenas", 120, 20, "random arenas", adds_units=True),
    Count("recalls", 12, 1, "recalls of each policy in each random arena", adds_units=True),
    Count("experiments", 48, 2, "replications of the thesis's design with pymunk", adds_units=True, least=2),
    Count(
        "replications",
        1_000,
        5,
        "compiled replications under the decisions of version 0.1",
        adds_units=True,
        least=2,
    ),
)
REPEATS, QUICK_REPEATS = 200, 20
"""Repeated samples for the power of the tests."""
TABLES = {PymunkRecall: "pymunk_recalls", PairedRecall: "paired_recalls", RecallRow: "experiments"}
Parts = list[str | Table | Picture]


def main() -> int:
    """Run the benchmark."""
    given = parse("agreement", __doc__, *COUNTS)
    seed = given.seed
    imitators = samples.experience(seed, given.jobs, given.quick)
    arenas = [random_arena(seed, number, given.counts["recalls"]) for number in range(given.counts["arenas"])]
    work: list[Unit] = [*samples.blocks(seed, given.counts["episodes"], imitators)]
    work += paired.units(arenas, paired.trained_imitator(seed))
    design = experiments.QUICK_DESIGN if given.quick else THESIS
    work += [experiments.Experiment(seed, number, design) for number in range(given.counts["experiments"])]
    rows = collect(given, work, TABLES)
    parts = [
        page.SUMMARY,
        *_in_random_arenas(given, rows, arenas),
        *_in_thesis_arenas(given, rows, imitators),
        _experiments(given, rows),
    ]
    replications = given.counts["replications"]
    now = before_after.reproduced(seed, replications, given.out / "thesis", given.quick)
    parts.append(
        before_after.before_after_table(before_after.cells_of(before_after.BEFORE), now, replications)
    )
    return finish(given, Page("Do the two backends agree?", parts))


def _in_random_arenas(given: Arguments, rows: Rows, arenas: Sequence[RandomArena]) -> Parts:
    """The same seeds on both backends."""
    pairs, rng = rows.of(PairedRecall), np.random.default_rng((given.seed, 6))
    return [
        page.random_arenas_text(len(arenas), given.counts["recalls"]),
        Picture("agreement_arenas", "some of the random arenas", paired_pictures.arenas_picture(arenas)),
        paired_tables.completion_table(pairs),
        paired_tables.differences_table(pairs, rng),
        Picture(
            "agreement_delivered", "food delivered in each arena", paired_pictures.delivered_picture(pairs)
        ),
        page.REASONS,
    ]


def _in_thesis_arenas(given: Arguments, rows: Rows, imitators: tuple[samples.Vectors, ...]) -> Parts:
    """Independent seeds in corridor and rectangle, and the power of the tests."""
    seed, episodes = given.seed, given.counts["episodes"]
    many, repeats = samples.COMPILED_FACTOR * episodes, QUICK_REPEATS if given.quick else REPEATS
    found: dict[tuple[samples.Condition, str], samples.Sample] = {}
    agreement, slow_wheels, power = [], [], []
    rng = np.random.default_rng((seed, 3))
    for condition in samples.CONDITIONS:
        single = samples.sample_of(pick(rows.of(PymunkRecall), **condition._asdict()))
        equal, slow = (
            samples.compiled(seed, condition, many, imitators, speed) for speed in (1.0, samples.SLOW)
        )
        found |= {(condition, "pymunk"): single, (condition, "compiled"): equal, (condition, "slow"): slow}
        agreement += two_sample_tests.compare(condition, single, equal)
        slow_wheels += two_sample_tests.compare(condition, single, slow)
        power.append(two_sample_tests.power(condition, equal, slow, episodes, repeats, rng))
    return [
        page.agreement_table(agreement, episodes, many, len(imitators)),
        page.slow_wheels_table(slow_wheels),
        page.power_table(power, repeats),
        Picture("agreement", "distributions of steps and scores", page.picture(found)),
    ]


def _experiments(given: Arguments, rows: Rows) -> Table:
    """Training and recalls on both backends."""
    count = experiments.COMPILED_FACTOR * given.counts["experiments"]
    return experiments.experiments_table(
        rows.of(RecallRow), experiments.compiled_experiments(given.seed, count)
    )


if __name__ == "__main__":
    sys.exit(main())
