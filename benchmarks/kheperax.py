"""Speed of compiled worlds beside Kheperax, in one session.

    python benchmarks/kheperax.py --help

Kheperax 0.2.0 and JAX get a virtual environment of their own (some 1.2 GB, made by this script, once). Kheperax steps
robots of a Khepera's size with random commands among four obstacles, with noise and without; our line is the whole
task: the teacher forages in compiled worlds. Needs the extra `fast`, and an otherwise idle machine.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import venv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from khepera_forage.estimates import UNKNOWN, Column, Table, Value, extremes, pick
from khepera_forage.figures import OURS, SMALL, THESIS, grid, new_figure
from khepera_forage.option_values import whole_number
from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.study import Count, Page, Picture, collect, finish, parse

WANTED = ("kheperax==0.2.0", "jax")
STEPS = Path(__file__).with_name("kheperax_steps.py")
WORLDS, QUICK_WORLDS = (64, 256, 1024, 4096, 16384), (64, 256)
SECONDS, QUICK_SECONDS = 0.25, 0.05
"""Of each line in each repeat, at least."""
SETTINGS = {
    "noise": "Kheperax, with its noise",
    "none": "Kheperax, no noise",
    "default": "Kheperax by default: its standard maze, three lasers, no noise",
}
TASKS = {
    "corridor": ("`run_teacher`, corridor, one food object", 1, 500),
    "rectangle": ("`run_teacher`, rectangle, four food objects", 4, 700),
}
"""Name of the line, food objects and limit, by arena."""


@dataclass(frozen=True, slots=True)
class Timed:
    """One line with one number of worlds in one repeat: steps of all robots, and their seconds."""

    line: str
    worlds: int
    repeat: int
    steps: int
    seconds: float
    first_call: float


class KheperaxError(RuntimeError):
    """Kheperax cannot be installed or run; the message says why."""


class Kheperax:
    """Kheperax in a process of its own Python; the environment is made if nothing is there.

    Args:
        folder: Of the virtual environment.

    Raises:
        KheperaxError: The folder is something else, installing failed, or the process ended.
    """

    def __init__(self, folder: Path) -> None:
        python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        if not python.exists():
            if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
                raise KheperaxError(
                    f"--venv is {str(folder)!r}, which is no virtual environment ({python} is missing); "
                    "allowed: one, or a folder that does not exist yet"
                )
            print(
                f"Kheperax: installing {' and '.join(WANTED)} into {folder}: 1.2 GB, some minutes, once",
                flush=True,
            )
            try:
                venv.create(folder, with_pip=True)
                subprocess.run([str(python), "-m", "pip", "install", "--quiet", *WANTED], check=True)
            except BaseException as error:
                shutil.rmtree(folder, ignore_errors=True)
                if isinstance(error, OSError | subprocess.CalledProcessError):
                    raise KheperaxError(f"{folder} cannot be made: {error}") from error
                raise
        # -I keeps this package and everything in PYTHONPATH out of its environment.
        self._process = subprocess.Popen(
            [str(python), "-I", str(STEPS), str(os.cpu_count())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def timed(self, setting: str, worlds: int, at_least: float) -> dict[str, Any]:
        """Whole episodes until `at_least` seconds have passed."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        request = {"setting": setting, "worlds": worlds, "at_least": at_least}
        try:
            print(json.dumps(request), file=self._process.stdin, flush=True)
            answer: dict[str, Any] = json.loads(self._process.stdout.readline())
        except (BrokenPipeError, ValueError):
            raise KheperaxError(
                f"Kheperax ended with status {self._process.wait()}. If its environment is incomplete, delete it; the "
                "next run makes a new one."
            ) from None
        return answer

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()


class Repeat(NamedTuple):
    """Every line once, one right after the other, so that a slow machine slows both sides of a ratio."""

    number: int
    worlds: tuple[int, ...]
    at_least: float
    seed: int
    kheperax: Kheperax

    @property
    def key(self) -> str:
        """The number."""
        return str(self.number)

    def run(self) -> list[Timed]:
        """Time all lines; the first repeat, -1, warms up and leaves no rows."""
        rows = []
        for worlds in self.worlds:
            for setting, line in SETTINGS.items():
                answer = self.kheperax.timed(setting, worlds, self.at_least)
                rows.append(Timed(line, worlds, self.number, **answer))
            for arena, (line, foods, limit) in TASKS.items():
                rows.append(Timed(line, worlds, self.number, *self._task(arena, worlds, foods, limit)))
        return rows if self.number >= 0 else []

    def _task(self, arena: str, worlds: int, foods: int, limit: int) -> tuple[int, float, float]:
        began = perf_counter()
        run_teacher(arena, 1, self.seed, foods=foods, limit=1)
        first, seconds, steps = perf_counter() - began, 0.0, 0
        while seconds < self.at_least:
            began = perf_counter()
            # Several episodes for each world, so that all threads end at about the same time.
            steps += int(run_teacher(arena, 4 * worlds, self.seed, foods=foods, limit=limit).steps.sum())
            seconds += perf_counter() - began
        return steps, seconds, first


def page(rows: Sequence[Timed]) -> Page:
    """Robot-steps a second by line and number of worlds, and how many times as fast ours are."""
    names = [*SETTINGS.values(), *(name for name, *_ in TASKS.values())]
    worlds = sorted({row.worlds for row in rows})
    noisy = {(row.worlds, row.repeat): row for row in pick(rows, line=SETTINGS["noise"])}
    lines: list[tuple[Value, ...]] = []
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    for name in names:
        rates = []
        for count in worlds:
            own = pick(rows, line=name, worlds=count)
            rates.append(extremes([row.steps / row.seconds / 1e6 for row in own]))
            others = [noisy[row.worlds, row.repeat] for row in own]
            ratios = [
                row.steps / row.seconds / (other.steps / other.seconds)
                for row, other in zip(own, others, strict=True)
            ]
            first = own[0].first_call
            lines.append((name, count, rates[-1], UNKNOWN if "Kheperax" in name else extremes(ratios), first))
        ends = [[r.value - r.low for r in rates], [r.high - r.value for r in rates]]
        axes.errorbar(
            worlds,
            [rate.value for rate in rates],
            ends,
            label=name.replace("`", ""),
            color=THESIS if "Kheperax" in name else OURS,
            ls=("-", "--", ":")[names.index(name) % len(SETTINGS)],
            capsize=3,
        )
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xticks(worlds, [f"{count:,}" for count in worlds])
    axes.set_xlabel("worlds together; bars: lowest and highest repeat")
    axes.set_ylabel("million robot-steps a second")
    axes.legend(fontsize=SMALL, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    grid(axes, "both")
    note = (
        "Median [lowest, highest] of the repeats. The ratio to Kheperax with its noise is taken in each repeat. The "
        "first call traces and compiles, and does not count. Processor only."
    )
    columns = (
        *(Column("line"), Column("worlds"), Column("million robot-steps/s", 2, estimate=True)),
        *(Column("times Kheperax", 1, estimate=True), Column("first call (s)")),
    )
    table = Table("robot_steps", "Robot-steps a second", note, columns, lines)
    return Page("Comparison with Kheperax", [Picture("kheperax", "robot-steps a second", figure), table])


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    numbers, quick = (" ".join(map(str, worlds)) for worlds in (WORLDS, QUICK_WORLDS))
    text = f"numbers of worlds to step together ({numbers}; with --quick {quick})"
    parser.add_argument("--worlds", type=whole_number(1), nargs="+", metavar="N", help=text)
    text = "Kheperax' virtual environment, made if it does not exist (venv in the results' folder)"
    parser.add_argument("--venv", type=Path, help=text)


def main() -> int:
    """Run the benchmark."""
    repeats = Count("repeats", 7, 2, "repeats, of which the median counts")
    given = parse("kheperax", __doc__, repeats, jobs=None, add=_add_arguments)
    worlds = tuple(sorted(set(given.worlds or (QUICK_WORLDS if given.quick else WORLDS))))
    seconds = QUICK_SECONDS if given.quick else SECONDS
    try:
        kheperax = Kheperax(given.venv or given.out / "venv")
        try:
            units = [Repeat(k, worlds, seconds, given.seed, kheperax) for k in range(-1, given.repeats)]
            rows = collect(given, units, {Timed: "rows"}).of(Timed)
        finally:
            kheperax.close()
    except KheperaxError as error:
        given.refuse(str(error))
    return finish(given, page(rows))


if __name__ == "__main__":
    sys.exit(main())
