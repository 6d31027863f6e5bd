"""A full disk names the file that it has cut short."""

import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from khepera_forage.envs.laboratories import load_settings
from khepera_forage.experience import Experience, ExperienceWriter
from khepera_forage.files import replacing
from khepera_forage.lab.settings_file import sample
from khepera_forage.rollouts.row_files import RowWriter, read_rows, write_rows
from khepera_forage.sim.arena_file import read_arena, write_arena
from khepera_forage.sim.arenas.procedural import procedural_arena
from khepera_forage.task.states import StateVector
from khepera_forage.vision.calibration import Calibration
from tests.limited_disk import largest_file

VECTOR = StateVector(0, 60, 0, 215, 40)


@dataclass(frozen=True)
class Row:
    number: int


class Vectors(ExperienceWriter):
    """Experience vectors, written as rows are."""

    def write(self, row: Row) -> None:
        self.append(VECTOR._replace(robot_food_distance=row.number), 0)


@pytest.mark.parametrize("opened", [partial(RowWriter, row_type=Row), partial(Vectors, arena="corridor")])
def test_row_that_does_not_fit_is_an_error_and_leaves_complete_lines(opened: Any, tmp_path: Path) -> None:
    """An almost full disk takes a part of a row, which the operating system does not report as an error."""
    path = tmp_path / "rows.csv"
    with opened(path) as writer:
        writer.write(Row(12))
        whole = path.read_bytes()
        for more in (0, 1, 5):
            with largest_file(len(whole) + more), pytest.raises(OSError, match=r"'.*rows.csv'"):
                writer.write(Row(123456))
            assert path.read_bytes() == whole
        writer.write(Row(13))
    assert path.read_bytes().startswith(whole)
    assert b"13" in path.read_bytes()[len(whole) :]


@pytest.mark.parametrize(
    ("write", "one", "other", "read"),
    [
        (write_arena, procedural_arena(0), procedural_arena(1), read_arena),
        (Experience.save, Experience([VECTOR], [0]), Experience([VECTOR], [1]), Experience.load),
        (Calibration.save, Calibration.identity(), Calibration.identity(size=(848, 480)), Calibration.load),
    ],
)
def test_file_that_exists_stays_whole_when_the_disk_is_full(
    write: Any, one: Any, other: Any, read: Any, tmp_path: Path
) -> None:
    path = tmp_path / "file"
    write(one, path)
    with largest_file(50), pytest.raises(OSError, match=r"file"):
        write(other, path)
    assert read(path) == one
    assert list(tmp_path.iterdir()) == [path]


def test_file_whose_header_does_not_fit_does_not_prevent_the_next_recording(tmp_path: Path) -> None:
    path = tmp_path / "g1.csv"
    with largest_file(10), pytest.raises(OSError, match=r"'.*g1.csv'"):
        ExperienceWriter(path, "corridor")
    assert not path.exists()
    ExperienceWriter(path, "corridor").close()
    with largest_file(3), pytest.raises(OSError, match=r"'.*rows.csv'"):
        RowWriter(tmp_path / "rows.csv", Row)


def test_rows_can_be_written_to_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with RowWriter(pipe, Row) as writer:
        writer.write(Row(12))
    assert os.read(reader, 100) == b"number\n12\n"
    os.close(reader)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
@pytest.mark.parametrize(
    ("write", "read"),
    [
        (partial(write_arena, procedural_arena(0)), read_arena),
        (Experience([VECTOR], [0]).save, Experience.load),
        (Calibration.identity().save, Calibration.load),
        (lambda path: write_rows(path, Row, [Row(1), Row(2)]), partial(read_rows, row_type=Row)),
        (lambda path: path.write_text(sample(), "utf-8"), load_settings),
    ],
)
def test_files_of_other_tools_are_read(write: Any, read: Any, encoding: str, tmp_path: Path) -> None:
    """As Windows' editors and `>` write them: with a byte order mark, and two characters at the end of a line."""
    path = tmp_path / "file.toml"
    write(path)
    before = read(path)
    text = path.read_text("utf-8")
    with open(path, "w", encoding=encoding, newline="\r\n") as file:
        file.write(text)
    assert read(path) == before


@pytest.mark.parametrize("target", ["film.gif", "new.gif"])
def test_file_is_written_through_a_link_and_keeps_its_mode(target: str, tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    film, link = tmp_path / "films" / target, tmp_path / "link.gif"
    link.symlink_to(film)
    if target == "film.gif":
        film.touch(0o600)
    with replacing(link) as partial:
        partial.write_bytes(b"GIF")
    assert link.is_symlink()
    assert film.read_bytes() == b"GIF"
    assert target == "new.gif" or film.stat().st_mode & 0o777 == 0o600
    assert [path.name for path in (tmp_path / "films").iterdir()] == [target]
