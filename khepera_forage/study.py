"""Studies: their arguments, work in processes that a killed run continues, and their page.

How to write a study:

```python
@dataclass(frozen=True, slots=True)
class Forage:                                     # a table of rows is a frozen dataclass
    seed: int
    steps: int

def forages(seed: int) -> list[Forage]: ...       # rows; tables of several types may be mixed

if __name__ == "__main__":
    given = parse("forages", __doc__, Count("starts", 500, 5, "random starts", adds_units=True))
    seeds = np.random.SeedSequence(given.seed).generate_state(given.starts).tolist()
    jobs = [Job(f"start {seed}", forages, (seed,)) for seed in seeds]      # done in any process, in any order
    rows = collect(given, jobs, {Forage: "forages"}).of(Forage)
    table = Table("forages", "Steps of a forage", "Median and ...", columns, [quantiles(...)])
    finish(given, Page("Forages", ["What a reader learns.", table, Picture("forages", "steps", figure)]))
```

`estimates` has means, differences and quantiles with intervals, and tables; `figures` has panels and bars.
"""

import argparse
import gzip
import io
import json
import os
import platform
import shlex
import signal
import sys
import threading
import warnings
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import fields
from importlib.metadata import version
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, Protocol

from joblib import Parallel, delayed

from khepera_forage import __version__
from khepera_forage.estimates import Table
from khepera_forage.figures import save
from khepera_forage.files import naming_file, replacing, write_all
from khepera_forage.option_values import OneLineParser, given_path, processes, progress, whole_number
from khepera_forage.rollouts.row_files import RowT, write_rows
from khepera_forage.task.decision_versions import CURRENT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMOKE_TEST = "A run with --quick is a smoke test: it supports no claim."
UNITS = "units.jsonl.gz"
"""File of a study's folder with its settings and the rows of every finished unit, one line each."""
DIED = (
    "a process of the work was killed, or died of a crash or of too little memory; finished units are kept, and the "
    "same command goes on"
)
_LIBRARIES = ("pymunk", "gymnasium", "pettingzoo", "numpy", "scikit-learn")


class Count(NamedTuple):
    """An argument that says how much work is done, with its values without and with `--quick`.

    Attributes:
        name: Of the argument, without dashes.
        what: What is counted, for `--help`.
        adds_units: Whether a larger count adds units of work and leaves the others as they were. The rows of other
            counts cannot be continued with a different value.
        least: The smallest count allowed.
    """

    name: str
    default: int
    quick: int
    what: str
    adds_units: bool = False
    least: int = 1


class Arguments(argparse.Namespace):
    """Arguments as given, with the counts' defaults filled in; `settings` are what the rows of a unit depend on."""

    name: str
    program: str
    seed: int
    out: Path
    quick: bool
    jobs: int
    fresh: bool
    counts: dict[str, int]
    settings: dict[str, str]
    parts: list[str]

    def refuse(self, reason: str) -> NoReturn:
        """End the program with one line, and status 2."""
        print(f"{self.program}: {reason}", file=sys.stderr)
        sys.exit(2)


def parse(
    script: str,
    description: str | None,
    *counts: Count,
    parts: Iterable[str] = (),
    jobs: int | None = -1,
    add: Callable[[argparse.ArgumentParser], None] = lambda _: None,
    given: Sequence[str] | None = None,
) -> Arguments:
    """Read the command line of a script of `benchmarks/`, by default that of this process.

    Args:
        script: Its name; results go to `results/<script>` by default.
        description: Its docstring.
        *counts: How much work is done.
        parts: Of the work, for `--only`: those that are chosen are the `parts` of the result, by default all.
        jobs: Processes by default, -1 for one a core. None for a benchmark that measures time: it runs in one process,
            has no `--jobs`, and never continues an earlier run.
        add: Adds the arguments of this script alone.
        given: The arguments.
    """
    formatter = argparse.RawDescriptionHelpFormatter
    parser = OneLineParser(prog=f"{script}.py", description=description, formatter_class=formatter)
    add_study_arguments(parser, script, *counts, jobs=jobs)
    every = list(parts)
    if every:
        text = "one part; may be given several times (all)"
        parser.add_argument("--only", action="append", choices=every, help=text)
    add(parser)
    parser.set_defaults(program=f"{script}.py")
    arguments = completed(parser.parse_args(given), *counts)
    arguments.parts = [part for part in every if part in (arguments.only or every)]
    return arguments


def add_study_arguments(parser: argparse.ArgumentParser, name: str, *counts: Count, jobs: int | None = -1) -> None:
    """Add `--seed`, `--out`, `--quick`, `--jobs`, `--fresh` and the counts, with a study's name as in `parse`."""
    out = f"results/{name}"
    add = parser.add_argument
    add("--seed", type=whole_number(0), default=0, help="the same seed gives the same work (0)")
    add("--out", type=given_path, default=Path(out), help=f"folder for the results ({out})")
    add("--quick", action="store_true", help="the same work in small, in under a minute")
    parser.set_defaults(name=name, jobs=1, fresh=True)
    if jobs is not None:
        add("--jobs", type=processes, default=jobs, help=f"processes; -1 is one a core ({jobs})")
        add("--fresh", action="store_true", default=False, help="delete rows of earlier runs in the folder")
    for count in counts:
        text = f"{count.what} ({count.default}; with --quick {count.quick})"
        add(f"--{count.name}", type=whole_number(count.least), metavar="N", help=text)


def completed(parsed: argparse.Namespace, *counts: Count) -> Arguments:
    """The arguments of a parser with `add_study_arguments` and `program`, with the counts' defaults filled in."""
    arguments = Arguments(**vars(parsed))
    arguments.counts = {}
    arguments.settings = {"seed": str(arguments.seed), "quick": "yes" if arguments.quick else "no"}
    for count in counts:
        value = getattr(arguments, count.name)
        if value is None:
            value = count.quick if arguments.quick else count.default
        setattr(arguments, count.name, value)
        arguments.counts[count.name] = value
        if not count.adds_units:
            arguments.settings[count.name] = str(value)
    return arguments


def command_line() -> str:
    """The command that started this process, for pages."""
    program, *arguments = sys.argv
    script = Path(program).resolve()
    benchmark = ["python", f"benchmarks/{script.name}"]
    return shlex.join([*(benchmark if script.parent.name == "benchmarks" else ["khepera-forage"]), *arguments])


class WorkUnit(Protocol):
    """Work that can be done in any process and in any order; no other unit of the folder has the same key."""

    @property
    def key(self) -> str: ...  # noqa: D102

    def run(self) -> Sequence[Any]: ...  # noqa: D102


class Job(NamedTuple):
    """A unit that calls a function, which any process can import, for rows of one or several types."""

    key: str
    function: Callable[..., Sequence[Any]]
    arguments: tuple[Any, ...]

    def run(self) -> Sequence[Any]:
        """The rows that the function returns."""
        return self.function(*self.arguments)


Done = tuple[str, Sequence[Any]]
"""Key and rows of a unit."""
Execute = Callable[[Sequence[WorkUnit]], Iterator[Done]]
"""Does units and yields each when it is done, in any order."""
Tables = Mapping[type[Any], str]
"""Types of rows, and the names of their CSV files without `.csv`."""


class Rows:
    """Rows of any types, in order."""

    def __init__(self, rows: Iterable[Any]) -> None:
        self._by_type: dict[type[Any], list[Any]] = {}
        for row in rows:
            self._by_type.setdefault(type(row), []).append(row)

    def of(self, row_type: type[RowT]) -> list[RowT]:
        """All rows of a type."""
        return self._by_type.get(row_type, [])


class RowStore:
    """The rows of finished units in a folder, by their keys. A process that is killed loses at most one unit.

    Args:
        folder: Made if it does not exist.
        tables: All types of rows.
        settings: What the rows depend on, beside the version of the package. A folder may hold rows with further
            settings, but none with other values.
        fresh: Delete the rows that are there.
        file: Name of the file.

    Raises:
        ValueError: The rows in the folder were made with other settings, or the file is damaged.
    """

    def __init__(
        self, folder: Path, tables: Tables, settings: Mapping[str, str], fresh: bool = False, file: str = UNITS
    ) -> None:
        self._tables = tables
        self.finished: dict[str, list[Any]] = {}
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / file
        settings, known = {"version": __version__, **settings}, dict[str, str]()
        if self._path.exists() and not fresh:
            known = self._read()
            for name, value in settings.items():
                if known.get(name, value) != value:
                    raise ValueError(
                        f"{self._path}: the rows there were made with {name} {known[name]!r}, and this run has "
                        f"{value!r}; allowed: the same, another folder (--out), or --fresh, which deletes them"
                    )
        with replacing(self._path) as partial:
            partial.write_bytes(_line(known | settings) + b"".join(map(self._line, self.finished)))

    def add(self, key: str, rows: Sequence[Any]) -> None:
        """Keep the rows of a unit."""
        self.finished[key] = list(rows)
        with open(self._path, "ab", buffering=0) as file:
            write_all(file, self._line(key), self._path)

    def _line(self, key: str) -> bytes:
        rows = self.finished[key]
        values = {
            name: [[getattr(row, field.name) for field in fields(kind)] for row in rows if type(row) is kind]
            for kind, name in self._tables.items()
        }
        return _line({"unit": key, "rows": values})

    def _read(self) -> dict[str, str]:
        """Read all whole lines; the settings of the first one."""
        lines: list[Any] = []
        try:
            # Without the line that a killed process was writing; a single byte of it would be no compressed part.
            content = io.BytesIO(self._path.read_bytes().removesuffix(b"\x1f"))
            with suppress(EOFError), gzip.open(content, "rt", encoding="utf-8") as file:
                lines.extend(map(json.loads, file))
            for line in lines[1:]:
                self.finished[line["unit"]] = [
                    kind(*(tuple(value) if isinstance(value, list) else value for value in values))
                    for kind, name in self._tables.items()
                    for values in line["rows"][name]
                ]
        except (OSError, ValueError, KeyError, TypeError, zlib.error) as error:
            raise ValueError(
                f"{self._path}: {error}; allowed: as this version wrote it, another folder (--out), or --fresh, which "
                "deletes it"
            ) from None
        settings: dict[str, str] = lines[0] if lines else {}
        return settings


def _line(content: object) -> bytes:
    """One line of the store, as a compressed part of its own; NumPy's numbers are stored like Python's."""
    text = json.dumps(content, default=lambda number: number.item(), ensure_ascii=False)
    return gzip.compress(f"{text}\n".encode(), compresslevel=1, mtime=0)


def done(unit: WorkUnit) -> Done:
    """Do a unit."""
    return unit.key, unit.run()


def in_processes(jobs: int) -> Execute:
    """Processes of this machine, 1 for this process alone.

    Raises:
        ChildProcessError: One of them died.
    """

    def execute(units: Sequence[WorkUnit]) -> Iterator[Done]:
        with _ended_by_sigterm(), warnings.catch_warnings():
            # joblib replaces a process whose memory has grown, as torch's does, and warns of it.
            warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
            running = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
            try:
                yield from running(delayed(done)(unit) for unit in units)
            except BrokenProcessPool:
                raise ChildProcessError(DIED) from None

    return execute


@contextmanager
def _ended_by_sigterm() -> Iterator[None]:
    """Let SIGTERM end a block by an exception, as Ctrl-C does, so that joblib ends its processes as well."""
    usual = threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGTERM)
    if usual is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def collect(
    given: Arguments,
    units: Sequence[WorkUnit],
    tables: Tables,
    execute: Execute | None = None,
    settings: Mapping[str, str] | None = None,
    others: bool = False,
    file: str = UNITS,
) -> Rows:
    """Do all units that are not done yet in the results' folder, write the tables, and return the rows of all units.

    Args:
        given: Folder, processes and settings.
        units: All work, in the order in which rows shall stand.
        tables: All types of rows in the folder.
        execute: Does the work; by default processes of this machine.
        settings: What the rows depend on beside `given.settings`.
        others: Also write and return the rows of other finished units in the folder, before those of this run.
        file: Name of the file that keeps the rows of finished units.

    Raises:
        SystemExit: The folder holds rows of other settings, or damaged ones; or a process of the work died.
    """
    keys = [unit.key for unit in units]
    assert len(set(keys)) == len(keys), "two units have the same key"
    try:
        store = RowStore(given.out, tables, given.settings | dict(settings or {}), given.fresh, file)
    except ValueError as error:
        given.refuse(str(error))
    open_units = [unit for unit in units if unit.key not in store.finished]
    if len(open_units) < len(units):
        number = f"{len(units) - len(open_units)} of {len(units)}"
        print(f"{number} units are done already, in {given.out} (--fresh does them again)", flush=True)
    running = (execute or in_processes(given.jobs))(open_units) if open_units else iter(())
    try:
        for key, rows in progress(running, total=len(open_units), desc=given.name, unit="unit"):
            store.add(key, rows)
    except ChildProcessError as error:
        given.refuse(str(error))
    if others:
        keys = [*(key for key in store.finished if key not in set(keys)), *keys]
    collected = Rows(row for key in keys for row in store.finished[key])
    for kind, name in tables.items():
        write_rows(given.out / f"{name}.csv", kind, collected.of(kind))
    return collected


class Picture(NamedTuple):
    """A picture on a page; its file is `<name>.png`."""

    name: str
    caption: str
    image: "Figure"


class Page(NamedTuple):
    """What a study found.

    Attributes:
        parts: Paragraphs of Markdown, tables (each a section of its own) and pictures, in the order of the page.
        attachments: Tables that are written as CSV and do not stand on the page.
    """

    title: str
    parts: Sequence[str | Table | Picture]
    attachments: Sequence[Table] = ()

    @property
    def tables(self) -> list[Table]:
        """The tables on the page."""
        return [part for part in self.parts if isinstance(part, Table)]


def write(folder: Path, name: str, page: Page) -> None:
    """Write `<name>.md` with the command and the machine that made it, and its tables and pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    text = [f"# {page.title}"]
    for part in page.parts:
        if isinstance(part, Picture):
            save(part.image, folder / f"{part.name}.png")
            text.append(f"![{part.caption}]({part.name}.png)")
        else:
            text.append(part.markdown().rstrip("\n") if isinstance(part, Table) else part)
    for table in (*page.tables, *page.attachments):
        write_text(folder / f"table_{table.stem}.csv", table.csv())
    text += ["## Command", f"    {command_line()}", machine()]
    write_text(folder / f"{name}.md", "\n\n".join(text) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a file, with "?" for the characters of names that are not UTF-8; an error names it."""
    with naming_file(path):
        path.write_text(text, encoding="utf-8", errors="replace")


def finish(given: Arguments, page: Page, shown: int | None = None) -> int:
    """Write the page of a study, print its tables or the first ones `shown`, and return the process's status."""
    write(given.out, given.name, page)
    if given.quick:
        print(SMOKE_TEST)
    width = get_terminal_size().columns
    print("\n".join(table.text(width) for table in page.tables[:shown]))
    print(f"Page ({given.name}.md), pictures, tables and rows are in {given.out}")
    return 0


def machine() -> str:
    """The machine, and the versions of packages and of the default decisions that figures were measured with."""
    # Its own from the source: the installed one is out of date in an editable installation.
    versions = ", ".join((f"khepera-forage {__version__}", *(f"{name} {version(name)}" for name in _LIBRARIES)))
    load = f", load average {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    computer = f"{_processor()}, {os.cpu_count()} cores{load}"
    return f"{computer}; Python {platform.python_version()}, {versions}; decisions {CURRENT}."


def _processor() -> str:
    """The processor's model, if this system tells it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
