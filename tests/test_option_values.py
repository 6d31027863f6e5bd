"""Readers of option values: what they accept, and what they say otherwise."""

import argparse
from collections.abc import Callable

import pytest

from khepera_forage.option_values import OneLineParser, given_path, processes, real_number, whole_number


@pytest.mark.parametrize(
    ("read", "text", "message"),
    [
        (whole_number(1, 1000), "1001", "'1001'; allowed: a whole number from 1 to 1,000"),
        (processes, "0", "'0'; allowed: a whole number of at least 1, or -1"),
        (real_number(0.0, 60.0, "seconds"), "0", "'0'; allowed: more than 0, at most 60 seconds"),
        (real_number(0.0, 60.0, "seconds"), "nan", "'nan'; allowed: more than 0"),
        (real_number(0.0, 60.0, "seconds"), "inf", "'inf'; allowed: more than 0"),
        (given_path, " ", "' '; allowed: the name of a file or folder"),
    ],
)
def test_error_quotes_the_value_and_what_is_allowed(
    read: Callable[[str], object], text: str, message: str
) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=message):
        read(text)


def test_parser_answers_a_mistake_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    parser = OneLineParser(prog="forage")
    parser.add_argument("--jobs", type=processes)
    with pytest.raises(SystemExit) as stop:
        parser.parse_args(["--jobs", "0"])
    assert stop.value.code == 2
    assert capsys.readouterr().err == "forage: --jobs: '0'; allowed: a whole number of at least 1, or -1\n"
