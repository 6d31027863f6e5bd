"""Runs `khepera-forage` in the process of the tests."""

import shlex

import pytest

from khepera_forage.cli.main import main


class Run:
    """Commands are written as in a shell; `more` words are taken as they are."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def __call__(self, command: str, *more: str, status: int = 0) -> str:
        """What a command prints, which ends with this status."""
        return self._printed(command, *more, status=status)[0]

    def refused(self, command: str, *more: str, status: int = 2) -> str:
        """The line in which a command says what is wrong."""
        _, error = self._printed(command, *more, status=status)
        assert error.startswith("khepera-forage")
        assert error.count("\n") == 1
        return error

    def _printed(self, command: str, *more: str, status: int) -> tuple[str, str]:
        self._capsys.readouterr()  # of what came before
        assert main([*shlex.split(command), *more]) == status
        return self._capsys.readouterr()
