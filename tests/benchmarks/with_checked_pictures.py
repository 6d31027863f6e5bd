"""Runs a script of `benchmarks/` and notes which of its pictures cannot be read at the size at which pages show them.

    python -m tests.benchmarks.with_checked_pictures NOTES SCRIPT ARGUMENTS

NOTES gets a line for each picture: its name, a tab, and what is wrong with it, if anything.
"""

import runpy
import sys
from pathlib import Path
from unittest import mock

from matplotlib.figure import Figure

from khepera_forage.experiments.figures import save
from tests.figure_checks import check_readable, check_shading_is_explained


def main(notes: Path, script: Path, arguments: list[str]) -> None:
    """Run the script as if it had been started itself."""

    def checked(figure: Figure, path: Path) -> None:
        save(figure, path)  # before the check, which needs the layout of the file
        fault = ""
        try:
            check_readable(figure)
            check_shading_is_explained(figure)
        except AssertionError as error:
            fault = str(error).splitlines()[0]
        with notes.open("a", encoding="utf-8") as file:
            file.write(f"{path.name}\t{fault}\n")

    sys.argv = [str(script), *arguments]
    sys.path[0] = str(script.parent)
    with mock.patch("khepera_forage.experiments.page.save", checked):
        runpy.run_path(str(script), run_name="__main__")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
