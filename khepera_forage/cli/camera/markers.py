"""`khepera-forage camera markers` and `camera tags`: pages to print."""

import argparse
import re
from collections.abc import Sequence

from khepera_forage.cli.arguments import add_out_argument
from khepera_forage.vision.rendering.marker_sheets import marker_pages, save_pages, tag_pages
from khepera_forage.vision.tracker_settings import TrackerSettings


def ids(text: str) -> tuple[int, ...]:
    """Numbers and ranges: "1-4,7"; none for an empty text.

    Raises:
        ArgumentTypeError: Anything else.
    """
    numbers: list[int] = []
    for part in text.replace(" ", "").split(",") if text.strip() else ():
        found = re.fullmatch(r"(\d{1,2})(?:-(\d{1,2}))?", part)
        if not found:
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: numbers and ranges, such as 1-4,7")
        numbers += range(int(found[1]), int(found[2] or found[1]) + 1)
    return tuple(numbers)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `markers`."""
    parser.add_argument(
        "--grid",
        type=ids,
        default=(),
        metavar="NUMBERS",
        help="markers of the table of twelve instead, such as 1-12",
    )
    add_out_argument(parser, "markers.svg", "file, whose name ends in .svg, .png or .pdf")


def run(arguments: argparse.Namespace) -> int:
    """Write the markers.

    Raises:
        ValueError: The file name has another ending, or a marker does not exist.
        OSError: The file cannot be written.
    """
    grid: Sequence[int] = arguments.grid
    numbers = TrackerSettings(markers="grid", numbers=tuple(grid)).numbers if grid else (1, 2)
    path = save_pages(arguments.out, marker_pages(numbers, bool(grid)))
    print(f"{path}: {len(numbers)} markers on A4; print it at 100 %")
    return 0


def add_tag_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `tags`."""
    for kind, default in (("robots", "1-4"), ("food", ""), ("floor", "38-49")):
        parser.add_argument(
            f"--{kind}",
            type=ids,
            default=ids(default),
            metavar="IDS",
            help=f"ids of the tags for {kind} ({default or 'none'})",
        )
    parser.add_argument(
        "--size",
        type=float,
        default=TrackerSettings().tag_size,
        metavar="MM",
        help="side of a robot's tag (80)",
    )
    parser.add_argument(
        "--food-size",
        type=float,
        default=TrackerSettings().food_tag_size,
        metavar="MM",
        help="side of food's tags (24)",
    )
    add_out_argument(parser, "tags.pdf", "file, whose name ends in .pdf; for a single page also .svg or .png")


def run_tags(arguments: argparse.Namespace) -> int:
    """Write the tags.

    Raises:
        ValueError: The file name has another ending, or an id or size is not allowed.
        OSError: The file cannot be written.
    """
    pages = tag_pages(arguments.robots, arguments.food, arguments.floor, arguments.size, arguments.food_size)
    if not pages:
        raise ValueError("no tags to print; allowed: ids for --robots, --food or --floor")
    path = save_pages(arguments.out, pages)
    print(f"{path}: {len(pages)} pages of A4; print at 100 %, and measure the line of 100 mm")
    return 0
