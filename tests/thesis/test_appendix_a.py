"""The thesis's tables as printed, their averages and their errata."""

import csv
import zipfile
from dataclasses import replace

import pytest

from khepera_forage.rollouts.row_files import parse_rows
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.appendix_a import errata
from tests.thesis.conftest import PUBLISHED


def test_errata_are_the_reviewed_list() -> None:
    """It was reviewed by hand against the printed tables. None is about one of the 21 printed set averages."""
    assert len(appendix_a.SETS) == 21
    with zipfile.ZipFile(PUBLISHED) as archive:
        _, *reviewed = csv.reader(archive.read("errata.csv").decode().splitlines())
    assert [list(erratum) for erratum in errata()] == reviewed
    assert len(reviewed) == 29


def test_errata_follow_changes_of_the_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """A corrected line removes its erratum, and an altered line adds one."""
    rows = list(appendix_a.RECALLS)
    assert (rows[53].table, rows[53].line) == ("A.3", 14)
    rows[53] = replace(rows[53], score=58)
    rows[54] = replace(rows[54], penalty="-20", score=5)
    monkeypatch.setattr(appendix_a, "RECALLS", tuple(rows))
    changed = {(s.place, s.kind) for s in errata() if s.table == "A.3"}
    assert ("line 14, g246810", "score") not in changed
    assert {("g246810", "average"), ("total average", "average"), ("food collected", "food")} <= changed


def test_unknown_cell_and_penalty_are_errors() -> None:
    with pytest.raises(KeyError, match=r"no table for 'rectangle' after 3 episodes; allowed: .*'corridor', 1"):
        appendix_a.table_of("rectangle", 3)
    text = "table,line,arena,episodes,file_id,correct,total,percent,penalty,score\nA.1,1,corridor,1,g1,1,2,50,-7,43\n"
    with pytest.raises(ValueError, match=r"x.csv:2: penalty is '-7'; allowed: -, -5 or -20"):
        parse_rows(text, "x.csv", appendix_a.PrintedRecall)
