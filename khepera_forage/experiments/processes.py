"""Units of work, done in processes and kept on disk."""

import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.experiments.arguments import Arguments
from khepera_forage.experiments.row_folder import RowFolder, Rows, Tables


class Unit(Protocol):
    """A piece of work that can be done in any process, and in any order."""

    @property
    def key(self) -> str:
        """Its name; no other unit of the folder has it."""
        ...

    def run(self) -> Sequence[Any]:
        """Do the work.

        Returns:
            Its rows, of one or several types.
        """
        ...


Done = tuple[str, Sequence[Any]]
"""Key and rows of a unit."""
Execute = Callable[[Sequence[Unit]], Iterator[Done]]
"""Does units and yields each when it is done, in any order."""


def done(unit: Unit) -> Done:
    """Do a unit."""
    return unit.key, unit.run()


def in_processes(jobs: int) -> Execute:
    """Processes of this machine; one job is this process."""
    running = Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)
    return lambda units: running(delayed(done)(unit) for unit in units)


def collect(
    given: Arguments,
    units: Sequence[Unit],
    tables: Tables,
    execute: Execute | None = None,
    settings: dict[str, str] | None = None,
) -> Rows:
    """Do all units that are not done yet in the results' folder.

    Args:
        given: Folder, processes and settings.
        units: All work, in the order in which rows shall stand.
        tables: All types of rows in the folder, and the names of their files.
        execute: Does the work; by default processes of this machine.
        settings: What the rows depend on beside `given.settings`.

    Returns:
        The rows of these units, from this run and earlier ones, in their order.

    Raises:
        SystemExit: The folder holds rows of other settings, or damaged ones.
    """
    keys = [unit.key for unit in units]
    assert len(set(keys)) == len(keys), "two units have the same key"
    try:
        folder = RowFolder(given.out, tables, given.settings | (settings or {}), given.fresh)
    except ValueError as error:
        given.refuse(str(error))
    finished = set(folder.finished)
    open_units = [unit for unit in units if unit.key not in finished]
    if len(open_units) < len(units):
        number = f"{len(units) - len(open_units)} of {len(units)}"
        print(f"{number} units are done already, in {given.out} (--fresh does them again)", flush=True)
    try:
        running = (execute or in_processes(given.jobs))(open_units) if open_units else iter(())
        silent = not sys.stderr.isatty()
        for key, rows in tqdm(running, total=len(open_units), desc=given.name, unit="unit", disable=silent):
            folder.add(key, rows)
    finally:
        folder.close(keys)
    return folder.rows(keys)
