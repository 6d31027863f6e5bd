"""The thesis's tables as printed, their averages and errata, and the design of experiments that equals theirs."""

import csv
import zipfile
from collections import Counter
from dataclasses import replace

import pytest

from khepera_forage.noise import SOURCES, Noise
from khepera_forage.rollouts.row_files import parse_rows
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.appendix_a import errata
from khepera_forage.thesis.design import FILES, LABORATORY, NO_LOSSES, NO_NOISE, THESIS, Cell, noise_conditions
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


# ---------------------------------------------------------------- the design


@pytest.mark.parametrize(
    ("cell", "table"), list(zip(THESIS, appendix_a.TABLES, strict=True)), ids=[t.table for t in appendix_a.TABLES]
)
def test_cell_equals_its_table(cell: Cell, table: appendix_a.PrintedTable) -> None:
    assert (cell.arena, cell.episodes) == (table.arena, table.episodes)
    assert (cell.foods, cell.limit, cell.available) == (table.foods, table.limit, table.available)
    recalls = Counter(row.file_id for row in appendix_a.rows_of(table))
    assert recalls == {subset.name: cell.recalls for subset in cell.subsets}
    assert list(recalls) == [subset.name for subset in cell.subsets]
    for subset in cell.subsets:
        assert len(subset.files) == len(set(subset.files)) == cell.episodes
        assert set(subset.files) <= set(range(1, FILES + 1))


def test_noise_conditions_contain_the_sources_of_the_laboratory_in_their_names() -> None:
    other = replace(Noise.laboratory(), placement_error=20.0)
    conditions = noise_conditions(other)
    assert list(conditions) == list(noise_conditions()), "seeds depend on the position of a condition"
    assert (conditions[NO_NOISE], conditions[LABORATORY]) == (Noise.none(), other)
    assert conditions[NO_LOSSES] == replace(other, **dict.fromkeys(SOURCES["tracking losses"], 0.0))
    assert conditions["only placement"] == Noise.only("placement", laboratory=other)
    assert conditions["only wheels"] == Noise.only("wheels")
