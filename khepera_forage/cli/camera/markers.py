"""`khepera-forage camera markers`: a page with the markers of figure 3.9, to print."""

import argparse

from khepera_forage.cli.arguments import add_out_argument
from khepera_forage.vision.rendering.marker_sheets import save_marker_sheet


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_out_argument(parser, "markers.svg", "file, whose name ends in .svg, .png or .pdf")


def run(arguments: argparse.Namespace) -> int:
    """Write the page.

    Raises:
        ValueError: The file name has another ending.
        OSError: The file cannot be written.
    """
    path = save_marker_sheet(arguments.out)
    print(f"{path}: two markers on a page of A4; print it at 100 %")
    return 0
