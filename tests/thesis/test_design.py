"""The design of the experiments equals that of the thesis's tables."""

from collections import Counter
from dataclasses import replace

import pytest

from khepera_forage.noise import SOURCES, Noise
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.design import FILES, LABORATORY, NO_LOSSES, NO_NOISE, THESIS, Cell, noise_conditions


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
