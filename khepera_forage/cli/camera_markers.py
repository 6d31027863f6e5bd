"""`khepera-forage camera markers`: the markers of figure 3.9, to print."""

import argparse
from pathlib import Path

from khepera_forage.vision.rendering.marker_sheets import save_marker_sheet


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The task's arguments."""
    parser.add_argument(
        "--out", type=Path, default=Path("markers.svg"), help="name ends in .svg, .png or .pdf (markers.svg)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Write the page.

    Raises:
        ValueError: Another kind of file.
        OSError: It cannot be written.
    """
    path = save_marker_sheet(arguments.out)
    print(f"{path}: two markers on a page of A4; print it at 100 %")
    return 0
