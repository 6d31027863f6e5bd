"""A full disk names the file that it has cut short."""

import errno
import os
from dataclasses import dataclass
from pathlib import Path

import pytest

from khepera_forage.cli.main import main
from khepera_forage.experience import Experience, ExperienceWriter
from khepera_forage.files import NamingFile
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.task.states import StateVector
from tests.limited_disk import largest_file

FULL = Path("/dev/full")
VECTOR = StateVector(0, 60, 0, 215, 40)
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


def test_row_that_does_not_fit_is_an_error_and_leaves_complete_lines(tmp_path: Path) -> None:
    """An almost full disk takes a part of a row, which the operating system does not report as an error."""
    path = tmp_path / "rows.csv"
    with RowWriter(path, Row) as writer:
        writer.write(Row(12))
        whole = path.read_bytes()
        for more in (0, 1, 5):
            with largest_file(len(whole) + more), pytest.raises(OSError, match=r"'.*rows.csv'"):
                writer.write(Row(123456))
            assert path.read_bytes() == whole
        writer.write(Row(13))
    assert path.read_bytes() == whole + b"13\n"


def test_vector_that_does_not_fit_is_an_error_and_leaves_complete_lines(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    with ExperienceWriter(path, "corridor") as writer:
        writer.append(VECTOR, 0)
        whole = path.read_bytes()
        for more in (0, 1, 5):
            with largest_file(len(whole) + more), pytest.raises(OSError, match=r"'.*g1.csv'"):
                writer.append(VECTOR, 0)
            assert path.read_bytes() == whole
        assert writer.count == 1
        writer.append(VECTOR, 1)
    assert len(Experience.load(path)) == 2


def test_file_whose_header_does_not_fit_does_not_prevent_the_next_recording(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    with largest_file(10), pytest.raises(OSError, match=r"'.*g1.csv'"):
        ExperienceWriter(path, "corridor")
    assert not path.exists()
    ExperienceWriter(path, "corridor").close()


def test_rows_can_be_written_to_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with RowWriter(pipe, Row) as writer:
        writer.write(Row(12))
    assert os.read(reader, 100) == b"number\n12\n"
    os.close(reader)
