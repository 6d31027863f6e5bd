"""The design of the experiments is that of the thesis' tables."""

from collections import Counter

import pytest

from khepera_forage.noise import SOURCES, Noise
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.design import (
    FILES,
    LABORATORY,
    NO_LOSSES,
    NO_NOISE,
    THESIS,
    Cell,
    Subset,
    noise_conditions,
)


@pytest.mark.parametrize(
    ("cell", "table"),
    list(zip(THESIS, appendix_a.tables(), strict=True)),
    ids=[t.table for t in appendix_a.tables()],
)
def test_a_cell_is_a_table(cell: Cell, table: appendix_a.PrintedTable) -> None:
    assert (cell.arena, cell.episodes) == (table.arena, table.episodes)
    assert (cell.foods, cell.limit, cell.available) == (table.foods, table.limit, table.available)
    recalls = Counter(row.file_id for row in appendix_a.rows_of(table))
    assert recalls == {subset.name: cell.recalls for subset in cell.subsets}
    assert list(recalls) == [subset.name for subset in cell.subsets]


@pytest.mark.parametrize("cell", THESIS, ids=lambda cell: f"{cell.arena}-{cell.episodes}")
def test_subsets_are_distinct_files_of_the_ten(cell: Cell) -> None:
    for subset in cell.subsets:
        assert len(subset.files) == len(set(subset.files)) == cell.episodes
        assert set(subset.files) <= set(range(1, FILES + 1))


def test_names_run_together_as_in_the_thesis() -> None:
    assert Subset((6, 7, 8, 9, 10)).name == "g678910"


def test_one_replication_is_106_recalls() -> None:
    assert sum(cell.size for cell in THESIS) == len(appendix_a.recalls()) == 106


def test_noise_conditions_switch_what_they_name() -> None:
    conditions = noise_conditions()
    assert conditions[NO_NOISE] == Noise.none()
    assert conditions[LABORATORY] == Noise.laboratory()
    assert conditions["only wheels"] == Noise.only("wheels")
    silent, loud = conditions[NO_LOSSES], Noise.laboratory()
    differing = {n for names in SOURCES.values() for n in names if getattr(silent, n) != getattr(loud, n)}
    assert differing == set(SOURCES["tracking losses"])
    assert all(getattr(silent, name) == 0 for name in differing)


def test_no_two_noise_conditions_are_the_same() -> None:
    """Cables alone would be: they multiply losses and do nothing else."""
    conditions = noise_conditions()
    assert len(set(conditions.values())) == len(conditions) == len(SOURCES) + 3
