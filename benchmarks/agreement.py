"""Whether recalls on the two backends agree: two-sample tests, and their power to detect a difference.

    python benchmarks/agreement.py --help

Teacher and imitator in corridor and rectangle: scores, steps and food delivered of thousands of recalls on each
backend, and the same with wheels 2 % slow on the compiled one, which the tests must detect. Needs numba (the extra
`fast`).
"""

import sys

import numpy as np
from backend_agreement import page, samples, two_sample_tests
from backend_agreement.samples import PymunkRecall
from harness.arguments import Count, parse
from harness.page import Page, Picture, finish
from harness.processes import collect
from harness.tables import pick

from khepera_forage.thesis.tables import Table

EPISODES = Count("episodes", 3_000, 50, "recalls of each condition with pymunk", adds_units=True)
REPEATS, QUICK_REPEATS = 200, 20
"""Repeated samples for the power of the tests."""


def main() -> int:
    """Run the benchmark."""
    given = parse("agreement", __doc__, EPISODES)
    seed, episodes = given.seed, given.episodes
    many, repeats = samples.COMPILED_FACTOR * episodes, QUICK_REPEATS if given.quick else REPEATS
    imitators = samples.experience(seed, given.jobs)
    work = samples.blocks(seed, episodes, imitators)
    rows = collect(given, work, {PymunkRecall: "pymunk_recalls"}).of(PymunkRecall)
    found: dict[tuple[samples.Condition, str], samples.Sample] = {}
    agreement, slow_wheels, power = [], [], []
    rng = np.random.default_rng((seed, 3))
    for condition in samples.CONDITIONS:
        single = samples.sample_of(pick(rows, **condition._asdict()))
        equal, slow = (
            samples.compiled(seed, condition, many, imitators, speed) for speed in (1.0, samples.SLOW)
        )
        found |= {(condition, "pymunk"): single, (condition, "compiled"): equal, (condition, "slow"): slow}
        agreement += two_sample_tests.compare(condition, single, equal)
        slow_wheels += two_sample_tests.compare(condition, single, slow)
        power.append(two_sample_tests.power(condition, equal, slow, episodes, repeats, rng))
    parts: list[Table | Picture] = [
        page.agreement_table(agreement, episodes, many),
        page.slow_wheels_table(slow_wheels),
        page.power_table(power, repeats),
        Picture("agreement", "distributions of steps and scores", page.picture(found)),
    ]
    return finish(given, Page("Do the two backends agree?", parts))


if __name__ == "__main__":
    sys.exit(main())
