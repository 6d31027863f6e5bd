"""Speed of our compiled bodies compared with Kheperax, on the most similar work, in one session.

    python benchmarks/kheperax.py --help

Kheperax 0.2.0 and JAX get a virtual environment of their own (some 1.2 GB, made by this script, once). Both sides have
the same arena, starts and wheel commands, in alternation; the page lists what is equal and what is not. Needs the
extras `fast` and `plots`, and an otherwise idle machine.
"""

import argparse
import sys
from pathlib import Path

import numba
from kheperax_comparison.environment import NoKheperax, environment, megabytes
from kheperax_comparison.measures import Plan, Repeat, TimedLine
from kheperax_comparison.ours import OurBodies
from kheperax_comparison.page import page
from kheperax_comparison.theirs import Kheperax
from kheperax_comparison.work import Work

from khepera_forage.option_values import whole_number
from khepera_forage.study import Count, collect, finish, parse

REPEATS = Count("repeats", 7, 2, "repeats, of which the median counts")
WORLDS, QUICK_WORLDS = (64, 256, 1024, 4096, 16384), (64, 256)
REFERENCE, QUICK_REFERENCE = 4096, 256
"""Worlds of the lines without a counterpart."""
SECONDS, QUICK_SECONDS = 0.25, 0.05
"""Of each line in each repeat, at least."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of this script alone."""
    numbers, quick = (" ".join(map(str, worlds)) for worlds in (WORLDS, QUICK_WORLDS))
    text = f"numbers of worlds to step together ({numbers}; with --quick {quick})"
    parser.add_argument("--worlds", type=whole_number(1), nargs="+", metavar="N", help=text)
    text = "Kheperax' virtual environment, made if it does not exist (venv in the results' folder)"
    parser.add_argument("--venv", type=Path, help=text)


def main() -> int:
    """Run the benchmark."""
    given = parse("kheperax", __doc__, REPEATS, jobs=None, add=add_arguments)
    quick = given.quick
    worlds = tuple(sorted(set(given.worlds or (QUICK_WORLDS if quick else WORLDS))))
    reference, seconds = (QUICK_REFERENCE, QUICK_SECONDS) if quick else (REFERENCE, SECONDS)
    plan = Plan(worlds, reference, seconds, given.seed)
    work = Work.of(max(*worlds, reference), given.seed)
    folder = given.venv or given.out / "venv"
    try:
        with Kheperax(environment(folder), work, numba.get_num_threads()) as kheperax:
            bodies = OurBodies(work, given.seed)
            units = [Repeat(number, plan, kheperax, bodies) for number in range(-1, given.repeats)]
            rows = collect(given, units, {TimedLine: "rows"}).of(TimedLine)
            about = kheperax.about
    except NoKheperax as error:
        given.refuse(str(error))
    options = [f"--worlds {' '.join(map(str, given.worlds))}"] if given.worlds else []
    return finish(given, page(rows, about, megabytes(folder)), *options)


if __name__ == "__main__":
    sys.exit(main())
