"""Learners of `benchmarks/generalisation.py` that query the teacher, and which learners take part."""

from dataclasses import replace
from importlib.util import find_spec

import pytest
from arena_generalisation.learner_replication import LearnerReplication, single_learners
from arena_generalisation.learning import imitating_learners, queried, querying_learners
from arena_generalisation.reinforcement import wheels_learners
from arena_generalisation.replication import QUERYING
from arena_generalisation.rows import ArenaRecalls
from arena_generalisation.size import Size, seeds_of
from arena_generalisation.trainings import CORRIDOR, VARIED

from khepera_forage.comparison.learning import REFERENCES
from khepera_forage.comparison.units import all_learners
from khepera_forage.policies.learners import LEARNERS

pytestmark = pytest.mark.skipif(
    find_spec("numba") is None, reason="the compiled backend needs numba, the extra `fast`"
)

DIFFICULTIES = ("easy", "medium")
SIZE = Size(2, 1, ("corridor", "mixed_foods"), DIFFICULTIES, 1_000, 120, queries=200)


def rows_of(name: str, number: int = 0) -> list[ArenaRecalls]:
    return LearnerReplication(0, number, SIZE, name, single_learners()[name]).run()


def test_every_learner_takes_part_once_unless_it_commands_motors() -> None:
    names = [*imitating_learners(), QUERYING, *single_learners(), *wheels_learners(), *REFERENCES]
    assert sorted(names) == sorted(all_learners())


def test_another_learner_that_queries_takes_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(LEARNERS, "another", replace(querying_learners()[QUERYING], title="another"))
    assert "another" in single_learners()
    assert rows_of("another")[0].learner == "another"


def test_network_forages_in_every_arena_after_both_trainings() -> None:
    rows = rows_of("dagger")
    assert {row.learner for row in rows} == {"dagger"}
    for training in (CORRIDOR, VARIED):
        own = [row for row in rows if row.training == training]
        assert [row.group for row in own] == ["thesis", "named", *DIFFICULTIES]
        assert [(row.vectors, row.recalls) for row in own] == [(SIZE.queries, 2)] * 4
        assert all(0 < row.steps <= 240 and row.delivered <= row.foods for row in own)
    assert rows_of("dagger") == rows, "the same seed, the same rows"
    others = rows_of("dagger", number=1)
    assert [row.arena for row in others if row.group in DIFFICULTIES] != [
        row.arena for row in rows if row.group in DIFFICULTIES
    ]


def test_tree_and_network_are_queried_alike() -> None:
    seed = seeds_of(0, 0, SIZE).learning
    for name, learner in querying_learners().items():
        corridor, varied = queried(name, learner, 0, seed, SIZE)
        assert (corridor.training, varied.training) == (CORRIDOR, VARIED)
        assert corridor.vectors == varied.vectors == SIZE.queries
        assert corridor.sample == learner.learner.sample
