"""The arguments that every benchmark script takes, and what `--help` says of them."""

import argparse
from pathlib import Path


def parser_for(description: str | None, out: str) -> argparse.ArgumentParser:
    """A parser with `--seed`, `--out` and `--quick`.

    Args:
        description: The script's docstring.
        out: Folder that results go to by default.
    """
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same work (0)")
    parser.add_argument(
        "--out", type=Path, default=Path(out), help=f"folder for table, picture and rows ({out})"
    )
    parser.add_argument("--quick", action="store_true", help="the same work in small, in under a minute")
    return parser


def add_count(parser: argparse.ArgumentParser, name: str, default: int, quick: int, of_what: str) -> None:
    """Add an argument that is a count, with a smaller default under `--quick`; see `count_of`."""
    text = f"{of_what} ({default}; with --quick {quick})"
    parser.add_argument(name, type=positive, default=None, metavar="N", help=text)


def count_of(given: int | None, default: int, quick: bool, small: int) -> int:
    """A count that was given, or else its default."""
    if given is not None:
        return given
    return small if quick else default


def positive(text: str) -> int:
    """A whole number of at least 1.

    Raises:
        argparse.ArgumentTypeError: Something else.
    """
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: a whole number of at least 1")
    return value
