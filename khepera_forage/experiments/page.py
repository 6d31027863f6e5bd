"""The page of an experiment: prose, tables and pictures, with the command and the machine that made them."""

import os
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from khepera_forage.experiments.arguments import Arguments
from khepera_forage.experiments.figures import save
from khepera_forage.experiments.tables import Table
from khepera_forage.task.decision_versions import PRESENT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LIBRARIES = ("khepera-forage", "pymunk", "gymnasium", "pettingzoo", "numpy", "scikit-learn")


class Picture(NamedTuple):
    """A picture on a page.

    Attributes:
        name: Of its file, without `.png`.
        caption: What it shows.
        image: A figure.
    """

    name: str
    caption: str
    image: "Figure"


class Page(NamedTuple):
    """What an experiment found.

    Attributes:
        title: Heading.
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


def write(folder: Path, name: str, page: Page, command: str) -> None:
    """Write a page, its tables and its pictures.

    Args:
        folder: Where to.
        name: Of the page's file, without `.md`.
        page: What was found.
        command: The command that repeats it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = [f"# {page.title}", *(_markdown(part) for part in page.parts)]
    text += ["## Command", f"    {command}", machine()]
    (folder / f"{name}.md").write_text("\n\n".join(text) + "\n", encoding="utf-8")
    for table in (*page.tables, *page.attachments):
        (folder / f"table_{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    for part in page.parts:
        if isinstance(part, Picture):
            save(part.image, folder / f"{part.name}.png")


def finish(given: Arguments, page: Page, *options: str) -> int:
    """Write the page, print its tables, and say where everything is.

    Args:
        given: Folder, and the name of the experiment, which the page has too.
        page: What was found.
        *options: Of this experiment alone, for the command on the page.

    Returns:
        The status of the process.
    """
    write(given.out, given.name, page, given.command_line(*options))
    print("\n".join(table.markdown() for table in page.tables))
    print(f"Page, pictures, tables and rows are in {given.out}")
    return 0


def machine() -> str:
    """The machine, and the versions of packages and of the default decisions that figures were measured with."""
    versions = ", ".join(f"{name} {version(name)}" for name in _LIBRARIES)
    load = f", load average {os.getloadavg()[0]:.1f} at the end" if hasattr(os, "getloadavg") else ""
    computer = f"{_processor()}, {os.cpu_count()} cores{load}"
    return f"{computer}; Python {platform.python_version()}, {versions}; decisions {PRESENT}."


def _markdown(part: str | Table | Picture) -> str:
    if isinstance(part, Table):
        return part.markdown().rstrip("\n")
    return f"![{part.caption}]({part.name}.png)" if isinstance(part, Picture) else part


def _processor() -> str:
    """The processor's model, if this system tells it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
