"""Readers of option values, a parser whose errors are one line, and a progress bar for terminals."""

import argparse
import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NoReturn


class OneLineParser(argparse.ArgumentParser):
    """A parser that answers a mistake in one line, without the usage."""

    def error(self, message: str) -> NoReturn:
        """End the program with status 2."""
        self.exit(2, f"{self.prog}: {message.removeprefix('argument ')}\n")


def whole_number(least: int, most: int | None = None) -> Callable[[str], int]:
    """A reader of whole numbers from `least` to `most`, for argparse."""
    allowed = f"of at least {least}" if most is None else f"from {least} to {most:,}"

    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least or (most is not None and value > most):
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: a whole number {allowed}")
        return value

    return read


def real_number(above: float, most: float, unit: str) -> Callable[[str], float]:
    """A reader of numbers that are larger than `above` and at most `most`, for argparse."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not above < value <= most:
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: more than {above:g}, at most {most:g} {unit}")
        return value

    return read


def processes(text: str) -> int:
    """A number of processes: at least 1, or -1 for one a core."""
    if text == "-1":
        return -1
    try:
        return whole_number(1)(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, or -1") from None


def given_path(text: str) -> Path:
    """A path; an empty text is none, although Python takes it for the present folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: the name of a file or folder")
    return Path(text)


def progress(items: Iterable[Any] | None = None, hidden: bool = False, **about: Any) -> Any:
    """A progress bar of tqdm, where the error output is a terminal and unless it is `hidden`."""
    from tqdm import tqdm

    return tqdm(items, disable=hidden or sys.stderr is None or not sys.stderr.isatty(), **about)
