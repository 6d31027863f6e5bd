"""Notes which pictures of a script of `benchmarks/` cannot be read at the size at which pages show them.

python -m tests.benchmarks.checked_pictures NOTES SCRIPT ARGUMENTS
"""

import runpy
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

from khepera_forage.figures import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@contextmanager
def checked_pictures(notes: Path) -> Iterator[None]:
    """Check each picture of a page that is saved.

    Args:
        notes: File that gets a line for each picture: its name, a tab, and what is wrong with it, if anything.
    """

    def checked(figure: "Figure", path: Path) -> None:
        from tests.figure_checks import check_readable, check_shading_is_explained

        save(figure, path)  # before the check, which needs the layout of the file
        fault = ""
        try:
            check_readable(figure)
            check_shading_is_explained(figure)
        except AssertionError as error:
            fault = str(error).splitlines()[0]
        with notes.open("a", encoding="utf-8") as file:
            file.write(f"{path.name}\t{fault}\n")

    with mock.patch("khepera_forage.study.save", checked):
        yield


def main(notes: Path, script: Path, arguments: list[str]) -> None:
    """Run the script as if it had been started itself."""
    sys.argv = [str(script), *arguments]
    sys.path[0] = str(script.parent)
    with checked_pictures(notes):
        runpy.run_path(str(script), run_name="__main__")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
