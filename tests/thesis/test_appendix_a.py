"""The thesis's tables as printed, their averages and their errata."""

import csv
import zipfile
from collections import Counter
from decimal import Decimal
from itertools import groupby
from pathlib import Path

import pytest

from khepera_forage.rollouts.row_files import parse_rows
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.appendix_a import errata

PUBLISHED = Path(__file__).parents[2] / "docs" / "published" / "thesis.zip"
"""Its errata were reviewed by hand against the printed tables."""


def test_recalls_are_the_lines_of_the_tables() -> None:
    lines = Counter(row.table for row in appendix_a.RECALLS)
    assert lines == {"A.1": 20, "A.2": 20, "A.3": 20, "A.4": 10, "A.5": 12, "A.6": 12, "A.7": 12}
    first, last = appendix_a.RECALLS[0], appendix_a.RECALLS[-1]
    assert (first.file_id, first.correct, first.total, first.percent, first.penalty, first.score) == (
        ("g1", 195, 249, 78, "-", 78)
    )
    assert (last.file_id, last.correct, last.total, last.percent, last.penalty, last.score) == (
        ("g12345678910", 580, 700, 82, "-5", 77)
    )


def test_set_averages_are_the_means_of_their_lines() -> None:
    """All 21 printed set averages are correct to the last decimal."""
    assert len(appendix_a.SETS) == 21
    for (table, file_id), group in groupby(appendix_a.RECALLS, key=lambda row: (row.table, row.file_id)):
        printed = [s.average for s in appendix_a.SETS if (s.table, s.file_id) == (table, file_id)]
        scores = [Decimal(row.score) for row in group]
        assert printed in ([], [sum(scores) / len(scores)])
        assert bool(printed) != (table in ("A.4", "A.7")), "only A.4 and A.7 print no set averages"


def test_errata_are_the_reviewed_list() -> None:
    with zipfile.ZipFile(PUBLISHED) as archive:
        _, *reviewed = csv.reader(archive.read("errata.csv").decode().splitlines())
    assert [list(erratum) for erratum in errata()] == reviewed
    assert len(reviewed) == 29


def test_errata_follow_changes_of_the_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """A corrected line removes its erratum, and an altered line adds one."""
    rows = list(appendix_a.RECALLS)
    assert rows[53].table == "A.3"
    assert rows[53].line == 14
    header = "table,line,arena,episodes,file_id,correct,total,percent,penalty,score\n"
    rows[53:54] = parse_rows(
        header + "A.3,14,corridor,5,g246810,392,500,78,-20,58\n", "corrected", appendix_a.PrintedRecall
    )
    rows[54:55] = parse_rows(
        header + "A.3,15,corridor,5,g246810,125,500,25,-20,5\n", "altered", appendix_a.PrintedRecall
    )
    monkeypatch.setattr(appendix_a, "RECALLS", tuple(rows))
    changed = {(s.place, s.kind) for s in errata() if s.table == "A.3"}
    assert ("line 14, g246810", "score") not in changed
    assert {("g246810", "average"), ("total average", "average"), ("food collected", "food")} <= changed


def test_table_of_an_unknown_cell_is_an_error() -> None:
    with pytest.raises(KeyError, match=r"no table for 'rectangle' after 3 episodes; allowed: .*'corridor', 1"):
        appendix_a.table_of("rectangle", 3)


def test_unknown_penalty_is_an_error() -> None:
    text = "table,line,arena,episodes,file_id,correct,total,percent,penalty,score\nA.1,1,corridor,1,g1,1,2,50,-7,43\n"
    with pytest.raises(ValueError, match=r"x.csv:2: penalty is '-7'; allowed: -, -5 or -20"):
        parse_rows(text, "x.csv", appendix_a.PrintedRecall)
