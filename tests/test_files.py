"""A full disk names the file that it has cut short."""

import errno
from dataclasses import dataclass
from pathlib import Path

import pytest

from khepera_forage.cli.main import main
from khepera_forage.experience import ExperienceWriter
from khepera_forage.files import NamingFile
from khepera_forage.rollouts.row_files import RowWriter

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full, a disk that is always full")


@dataclass(frozen=True)
class Row:
    number: int


def test_errors_without_a_file_get_one_and_others_stay() -> None:
    with pytest.raises(OSError, match=r"No space left on device: 'g1.csv'") as caught, NamingFile("g1.csv"):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert caught.value.errno == errno.ENOSPC
    with pytest.raises(FileNotFoundError, match="other"), NamingFile("g1.csv"):
        Path("/nowhere/other").read_text()
    with pytest.raises(ValueError, match="bad"), NamingFile("g1.csv"):
        raise ValueError("bad")


@needs_full
def test_rows_and_experience_name_the_file() -> None:
    with pytest.raises(OSError, match="/dev/full"):
        RowWriter(FULL, Row)
    with pytest.raises(OSError, match="/dev/full"):
        ExperienceWriter(FULL, "corridor", overwrite=True)


@needs_full
def test_command_names_the_file_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["recall", "--episodes", "1", "--out", str(FULL)]) == 2
    error = capsys.readouterr().err
    assert error == "khepera-forage recall: [Errno 28] No space left on device: '/dev/full'\n"


def test_a_row_that_is_cut_short_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An almost full disk takes part of a row, and the operating system calls that no error."""
    with RowWriter(tmp_path / "rows.csv", Row) as writer:
        file = writer._file

        class Short:
            def write(self, data: bytes) -> int:
                return file.write(data[:1])

            def close(self) -> None:
                file.close()

        monkeypatch.setattr(writer, "_file", Short())
        with pytest.raises(OSError, match=r"No space left on device: '.*rows.csv'"):
            writer.write(Row(12))
