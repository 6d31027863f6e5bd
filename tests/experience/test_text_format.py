"""Invalid and incomplete experience files, and their error messages."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage import __version__
from khepera_forage.experience import Experience, ExperienceError, ExperienceWarning
from khepera_forage.task.decisions import Decisions

HEADER = """\
# khepera_forage experience, version 1
# package: 0.1.0
# arena: corridor
# seed: 7
# episodes: 1
# units: distances in pixels of 5 mm; arms_height 255 (down) to 215 (raised)
object_presence,robot_home_distance,food_type,arms_height,robot_food_distance,behaviour
"""
ROW = "0,52,UNKNOWN,215,28,SEARCH_FOR_FOOD\n"
GRASPED = "1,48,PICKABLE,215,14,GO_HOME\n"
WHOLE = HEADER + ROW + GRASPED + "# complete: 2 vectors\n"
EXPERIENCE = Experience([(0, 52, 0, 215, 28), (1, 48, 1, 215, 14)], [0, 7], seed=7, decisions=Decisions.v0_1())


def write(folder: Path, content: str | bytes) -> Path:
    path = folder / "g1.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def decided(text: str) -> str:
    return WHOLE.replace("# units", f"# decisions: {text}\n# units")


def test_complete_file_is_written_and_read(tmp_path: Path) -> None:
    """A file without decisions, or with some that name no version, is one of version 0.1."""
    EXPERIENCE.save(tmp_path / "saved.csv")
    assert (tmp_path / "saved.csv").read_text() == decided("v0.1").replace("0.1.0", __version__)
    assert Experience.load(write(tmp_path, WHOLE)) == EXPERIENCE
    assert Experience.load(write(tmp_path, WHOLE), recover=True) == EXPERIENCE
    assert Decisions.v0_1() != Decisions()
    for text, decisions in (
        ("next_to_food=17;separation=20", replace(Decisions.v0_1(), next_to_food=17, separation=20)),
        ("v1;patience=7", Decisions(patience=7)),
        ("mixed", None),
    ):
        assert Experience.load(write(tmp_path, decided(text))).decisions == decisions


def row(text: str) -> str:
    return HEADER + ROW + text + "\n# complete: 2 vectors\n"


FOOD_TYPES = "UNKNOWN, PICKABLE, PUSHABLE, POISONOUS"
BEHAVIOURS = "SEARCH_FOR_FOOD, MOVE_SLOWLY, "
BAD: list[tuple[str | bytes, int, str]] = [
    ("", 1, "not an experience file, it is empty"),
    (b"\x89PNG\r\n\x1a\n\0", 1, "not an experience file, its first line is '\ufffdPNG'; allowed: '# khe"),
    (WHOLE.replace("version 1", "version 2"), 1, "version is '2', written by a later version of this package"),
    (WHOLE.replace("seed: 7", "seed: 7.5"), 4, "seed is '7.5'; allowed: an integer"),
    (WHOLE.replace("corridor", " corridor"), 3, "arena is ' corridor'; allowed: a printable name"),
    (WHOLE.replace("seed: ", "sead: "), 4, "'# sead: 7'; allowed: '# seed: ' and a value"),
    (decided(""), 6, "decisions are ''; allowed: a version and what differs from it, or no such line"),
    (decided("v2;next_to_food=17"), 6, "version 'v2' of the decisions is unknown; allowed: 'v0.1', 'v1'"),
    (WHOLE.replace("5 mm", "4 mm"), 6, "units are 'distances in pixels of 4 mm"),
    (WHOLE.replace("arms_height,", "arms,"), 7, "columns are 'object_presence,robot_home_distance,foo"),
    (HEADER[:100], 6, "ends in the header; allowed: 7 lines before the rows"),
    (row("0,52,UNKNOWN,215,28"), 9, "'0,52,UNKNOWN,215,28' has 5 columns; allowed: 6, object_p"),
    (row("1,48,EDIBLE,215,14,GO_HOME"), 9, f"food_type is 'EDIBLE'; allowed: {FOOD_TYPES}"),
    (row("1,48,PICKABLE,215,14,GO_AWAY"), 9, f"behaviour is 'GO_AWAY'; allowed: {BEHAVIOURS}"),
    (row("0,48,PICKABLE,215,14,GO_HOME"), 9, "food_type is PICKABLE without an object; allowed: UNKNOWN"),
    (row("0," + "9" * 5000 + ",UNKNOWN,215,14,GO_HOME"), 9, "robot_home_distance is '999"),
    (row("0,48,UNKNOWN,215,14,GO_HOME").encode() + b"\xff\n", 11, "b'\\xff' is not text; allowed: UTF-8"),
    (WHOLE.replace("2 vectors", "3 vectors"), 10, "'# complete: 3 vectors' after 2 rows; allowed: the nu"),
    (row("# odd"), 9, "'# odd'; allowed: a row, or the closing line '# complete: 1 vectors'"),
    (WHOLE + ROW, 11, "'0,52,UNKNOWN,215,28,SEARCH_FOR_FOOD' follows the closing line"),
]


@pytest.mark.parametrize(("content", "line", "message"), BAD, ids=[message for *_, message in BAD])
def test_invalid_file_is_an_error_with_line_and_reason(
    content: str | bytes, line: int, message: str, tmp_path: Path
) -> None:
    path = write(tmp_path, content)
    for recover in (False, True):
        with pytest.raises(ExperienceError, match=re.escape(f"{path}, line {line}: ")) as caught:
            Experience.load(path, recover=recover)
        assert message in str(caught.value)
        assert len(str(caught.value)) < len(str(path)) + 400


INCOMPLETE = [
    (HEADER + ROW + GRASPED, 9, 2, "2 complete rows, no incomplete line"),
    (HEADER, 7, 0, "0 complete rows, no incomplete line"),
    (HEADER + ROW + "1,48,PICK", 9, 1, "1 complete rows, then the incomplete line '1,48,PICK'"),
    # It looks complete, but the last word may have lost letters: only a line end shows that it is complete.
    (HEADER + ROW + GRASPED[:-1], 9, 1, "then the incomplete line '1,48,PICKABLE,215,14,GO_HOME'"),
    (WHOLE[:-1], 10, 2, "2 complete rows, then the incomplete line '# complete: 2 vectors'"),
]


@pytest.mark.parametrize(("content", "line", "rows", "message"), INCOMPLETE)
def test_incomplete_file_can_be_recovered(content: str, line: int, rows: int, message: str, tmp_path: Path) -> None:
    path = write(tmp_path, content)
    complaint = f"{path}, line {line}: ends before its closing line: "
    with pytest.raises(ExperienceError, match=re.escape(complaint)) as caught:
        Experience.load(path)
    assert message in str(caught.value)
    assert str(caught.value).endswith("recover=True reads the complete rows")
    with pytest.warns(ExperienceWarning, match=re.escape(message)) as warned:
        kept = Experience.load(path, recover=True)
    assert warned[0].filename == __file__
    loss = "the incomplete line is lost" if "then" in message else "no line is known to be lost"
    assert str(warned[0].message).endswith(loss)
    assert list(kept) == list(EXPERIENCE)[:rows]


def recovered(folder: Path, content: bytes) -> Experience | None:
    """The experience recovered from a file; None for an `ExperienceError`. Any other exception fails the test."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ExperienceWarning)
        try:
            return Experience.load(write(folder, content), recover=True)
        except ExperienceError:
            return None


LONG = Experience([(n % 2, n * 7 % 200, 0, 215 + n, n * 3 % 150) for n in range(20)], [n % 10 for n in range(20)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for hundreds of files, one after the other: a folder for each would take most of the time."""
    return tmp_path_factory.mktemp("damaged")


@pytest.fixture(scope="module")
def long_file(folder: Path) -> bytes:
    LONG.save(folder / "whole.csv")
    return (folder / "whole.csv").read_bytes()


def test_file_cut_at_any_byte_is_an_error_or_a_prefix(long_file: bytes, folder: Path) -> None:
    header = long_file.index(b"behaviour\n") + len(b"behaviour\n")
    for end in range(len(long_file)):
        with pytest.raises(ExperienceError):
            Experience.load(write(folder, long_file[:end]))
        kept = recovered(folder, long_file[:end])
        if end < header:
            assert kept is None
        else:
            assert kept is not None
            assert list(kept) == list(LONG)[: long_file[header:end].count(b"\n")]


@settings(deadline=None)
@given(st.data())
def test_damaged_file_is_an_error_or_valid_experience(long_file: bytes, folder: Path, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(long_file)))
    stop = data.draw(st.integers(start, min(start + 40, len(long_file))))
    kept = recovered(folder, long_file[:start] + data.draw(st.binary(max_size=10)) + long_file[stop:])
    if kept is not None:
        for vector, behaviour in kept:
            assert 215 <= vector.arms_height <= 255
            assert 0 <= behaviour <= 9
