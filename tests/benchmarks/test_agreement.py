"""`benchmarks/agreement.py`: both backends are compared, and an artificial difference is detected."""

import math
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from backend_agreement import before_after, experiments, paired_tables, samples, two_sample_tests
from backend_agreement.arenas import (
    KINDS,
    MOST_FOODS,
    MOST_OBSTACLES,
    PASSAGE,
    RandomArena,
    is_convex,
    random_arena,
)
from backend_agreement.paired import COMPILED, ODDS, POLICIES, PYMUNK

from khepera_forage.estimates import Estimate, holm
from khepera_forage.geometry.walls import clearance, walls_of
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.sim.arena import Point
from khepera_forage.sim.layout_checks import check_layout, check_seen
from khepera_forage.task.states import FoodType
from khepera_forage.thesis.design import THESIS
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read
from tests.benchmarks.test_scripts import SCRIPTS

pytestmark = pytest.mark.skipif(
    find_spec("numba") is None, reason="the compiled backend needs numba, the extra `fast`"
)

CONDITIONS = {(policy, arena) for policy in ("teacher", "imitator") for arena in ("corridor", "rectangle")}
EPISODES = 6
ARENAS = 8


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("agreement", *SCRIPTS["agreement"].run)


def test_every_condition_and_measure_has_a_line(out: Path) -> None:
    for name in ("table_agreement.csv", "table_slow_wheels.csv"):
        rows = read(out / name)
        measures = {(r["policy"], r["arena"], r["measure"]) for r in rows}
        assert measures == {(*c, m) for c in CONDITIONS for m in ("score", "steps", "delivered")}
        assert len(rows) == len(measures)
        for row in rows:
            difference = float(row["compiled"]) - float(row["pymunk"])
            assert float(row["difference"]) == pytest.approx(difference, abs=2e-3)
            assert float(row["difference: low"]) <= float(row["difference"]) <= float(row["difference: high"])
            for p in ("p of means", "p of distributions"):
                assert 0 <= float(row[p]) <= 1
                if name == "table_agreement.csv":
                    corrected = float(row[p.replace("p of", "corrected:")])
                    assert float(row[p]) - 1e-6 <= corrected <= 1
    assert {(r["policy"], r["arena"]) for r in read(out / "table_power.csv")} == CONDITIONS


def test_the_table_is_that_of_pymunks_rows(out: Path) -> None:
    rows = read(out / "pymunk_recalls.csv")
    for policy, arena in CONDITIONS:
        own = [r for r in rows if (r["policy"], r["arena"]) == (policy, arena)]
        assert len(own) == EPISODES
        assert {r["imitator"] for r in own} == (
            {"-1"} if policy == "teacher" else set(map(str, range(samples.QUICK_IMITATORS)))
        )
        (line,) = (
            r
            for r in read(out / "table_agreement.csv")
            if (r["policy"], r["arena"], r["measure"]) == (policy, arena, "steps")
        )
        assert float(line["pymunk"]) == pytest.approx(np.mean([int(r["steps"]) for r in own]), rel=1e-4)


def test_slow_wheels_are_detected_and_equal_ones_are_not() -> None:
    teacher = samples.Condition("teacher", "corridor")
    same = samples.compiled(1, teacher, 12_000, ())
    slow = samples.compiled(1, teacher, 12_000, (), samples.SLOW)
    found = two_sample_tests.power(teacher, same, slow, 6000, 20, np.random.default_rng(0))
    assert found.by_mean.value >= 80
    assert found.by_distribution.value >= 80
    assert found.false_by_mean.value <= 30
    assert found.false_by_distribution.value <= 30


def test_samples_without_variance_can_be_compared() -> None:
    always, never = np.full(20, 1.0), np.zeros(30)
    assert two_sample_tests.welch(always, always) == ((0, 0, 0), 1.0)
    assert two_sample_tests.welch(never, always) == ((1, 1, 1), 0.0)


def test_holm_correction_by_hand() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.6, 0.9]) == [1.0, 1.0]


def test_welch_agrees_with_scipy() -> None:
    from scipy import stats

    rng = np.random.default_rng(0)
    a, b = rng.normal(0, 1, 40), rng.normal(0.3, 3, 90)
    theirs = stats.ttest_ind(b, a, equal_var=False)
    difference, p = two_sample_tests.welch(a, b)
    assert p == pytest.approx(theirs.pvalue)
    assert difference[1:] == pytest.approx(tuple(theirs.confidence_interval(0.95)))


@pytest.fixture(scope="module")
def family() -> list[RandomArena]:
    return [random_arena(3, number, 2) for number in range(40)]


def test_random_arenas_vary_and_repeat(family: list[RandomArena]) -> None:
    assert [arena.kind for arena in family] == list(KINDS) * 10
    assert {arena.foods for arena in family} == set(range(1, MOST_FOODS + 1))
    counts = {len(arena.arena.obstacles) for arena in family}
    assert counts == set(range(MOST_OBSTACLES + 1))
    assert len({arena.arena.walls for arena in family}) == len(family)
    assert len({seed for arena in family for seed in arena.seeds}) == 2 * len(family)
    assert [random_arena(3, number, 2) for number in range(5)] == family[:5]
    assert random_arena(4, 0, 2) != family[0]


def test_random_arenas_are_of_their_kind_and_have_room(family: list[RandomArena]) -> None:
    for kind, arena, foods, seeds in family:
        check_seen([arena])
        assert is_convex(arena.walls) == kind.convex
        assert bool(arena.obstacles) == kind.obstacles
        for number, obstacle in enumerate(arena.obstacles):
            others = arena.obstacles[:number] + arena.obstacles[number + 1 :]
            room = min(clearance(*corner, walls_of((arena.walls, *others))) for corner in obstacle)
            assert room >= PASSAGE - 1e-6
        layout = RandomArena(kind, arena, foods, seeds).first_layout
        check_layout([arena], layout)
        assert len(layout.foods) == foods


def test_convexity_by_hand() -> None:
    square = [Point(0, 0), Point(1, 0), Point(1, 1), Point(0, 1)]
    assert is_convex(square)
    assert is_convex(square[::-1])
    assert not is_convex([*square, Point(0.5, 0.5)])


def test_every_policy_recalls_with_the_same_seeds_on_both_backends(out: Path) -> None:
    rows = read(out / "paired_recalls.csv")
    same = ("policy", "kind", "arena", "foods", "seed", "not_poisonous")
    sides = [[r for r in rows if r["backend"] == backend] for backend in (PYMUNK, COMPILED)]
    first, second = ([tuple(r[name] for name in same) for r in side] for side in sides)
    assert first == second
    assert {(r["policy"], r["arena"]) for r in rows} == {(p, str(a)) for p in POLICIES for a in range(ARENAS)}
    assert len({r["seed"] for r in rows}) == ARENAS
    assert len(rows) == 2 * len(POLICIES) * ARENAS
    assert any(int(r["not_poisonous"]) < int(r["foods"]) for r in rows)
    assert all(0 <= int(r["delivered"]) <= int(r["not_poisonous"]) for r in rows)
    assert set(ODDS) == set(FoodType) - {FoodType.UNKNOWN}


def test_paired_tables_are_those_of_the_rows(out: Path) -> None:
    rows = read(out / "paired_recalls.csv")
    differences = read(out / "table_paired_differences.csv")
    completions = read(out / "table_paired_completions.csv")
    kinds = ("all", *(kind.name for kind in KINDS))
    assert [(r["policy"], r["arenas"]) for r in completions] == [(p, k) for p in POLICIES for k in kinds]
    assert len(differences) == 4 * len(completions)
    for policy in POLICIES:
        a, b = (
            [r for r in rows if (r["policy"], r["backend"]) == (policy, side)] for side in (PYMUNK, COMPILED)
        )
        (steps,) = (
            r for r in differences if (r["policy"], r["arenas"], r["measure"]) == (policy, "all", "steps")
        )
        expected = np.mean([int(r["steps"]) for r in b]) - np.mean([int(r["steps"]) for r in a])
        assert float(steps["difference"]) == pytest.approx(expected, rel=1e-4, abs=1e-3)
        assert (
            float(steps["difference: low"]) <= float(steps["difference"]) <= float(steps["difference: high"])
        )
        (line,) = (r for r in completions if (r["policy"], r["arenas"]) == (policy, "all"))
        ends = [(u["complete"], v["complete"]) for u, v in zip(a, b, strict=True)]
        for name, pair in (("both", "11"), ("pymunk only", "10"), ("compiled only", "01"), ("neither", "00")):
            assert int(line[name]) == ends.count((pair[0], pair[1]))


def test_mcnemar_by_hand() -> None:
    assert paired_tables.mcnemar(0, 0) == 1.0
    assert paired_tables.mcnemar(5, 5) == 1.0
    assert paired_tables.mcnemar(1, 9) == pytest.approx(2 * (1 + 10) / 2**10)


def test_p_of_a_difference_by_hand() -> None:
    assert paired_tables.p_of(Estimate(1.0, 0.0, 2.0)) == pytest.approx(0.05)
    assert paired_tables.p_of(Estimate(0.0, -1.0, 1.0)) == 1.0
    assert paired_tables.p_of(Estimate(0.0, 0.0, 0.0)) == 1.0
    assert paired_tables.p_of(Estimate(1.0, 1.0, 1.0)) == 0.0
    assert math.isnan(paired_tables.p_of(Estimate(1.0, math.nan, math.nan)))


def test_the_experiments_table_has_the_means_of_the_rows(out: Path) -> None:
    rows = read_rows(out / "experiments.csv", RecallRow)
    table = {
        (row["arena"], row["episodes"], row["measure"]): row for row in read(out / "table_experiments.csv")
    }
    assert len(table) == 7 * len(experiments.MEASURES)
    assert [(c.arena, c.episodes) for c in experiments.QUICK_DESIGN] == [
        (c.arena, c.episodes) for c in THESIS
    ]
    for cell in experiments.QUICK_DESIGN:
        own = [row for row in rows if (row.arena, row.episodes) == (cell.arena, cell.episodes)]
        assert len(own) == 2 * cell.size
        for measure, value in experiments.MEASURES.items():
            line = table[cell.arena, str(cell.episodes), measure]
            assert float(line["pymunk"]) == pytest.approx(np.mean([value(row) for row in own]), rel=1e-4)


def test_a_difference_between_experiments_is_named(out: Path) -> None:
    rows = read_rows(out / "experiments.csv", RecallRow)
    many = [replace(row, replication=row.replication + 2 * copy) for copy in range(5) for row in rows]
    assert "No test detects a difference." in experiments.experiments_table(many, many).note
    larger = [
        replace(row, experience_size=2 * row.experience_size) if row.arena == "rectangle" else row
        for row in many
    ]
    note = experiments.experiments_table(many, larger).note
    assert "vectors in the rectangle after 10 episodes" in note
    assert "corridor" not in note
    assert "score" not in note


def test_results_of_version_0_1_stand_beside_those_of_this_run(out: Path) -> None:
    before = before_after.cells_of(before_after.BEFORE)
    now = before_after.cells_of(out / "thesis" / "table_cells.csv")
    rows = read(out / "table_before_after.csv")
    assert len(rows) == len(before) == 14
    for row, old, new in zip(rows, before, now, strict=True):
        assert (row["arena"], int(row["episodes"]), row["measure"]) == old[:3] == new[:3]
        assert float(row["version 0.1"]) == pytest.approx(old.value.value, rel=1e-4)
        assert float(row["now"]) == pytest.approx(new.value.value, rel=1e-4)


def test_a_change_beyond_the_intervals_is_reported() -> None:
    before = before_after.cells_of(before_after.BEFORE)
    same = before_after.before_after_table(before, before, 1000)
    assert {row[-2:] for row in same.rows} == {("yes", "yes")}
    assert "0 of 14" in same.note
    shifted = [
        cell._replace(value=Estimate(*(1.3 * value for value in cell.value)))
        if cell.measure == "food"
        else cell
        for cell in before
    ]
    other = before_after.before_after_table(before, shifted, 1000)
    assert "7 of 14" in other.note
    assert [row[-1] for row in other.rows] == ["yes", "no"] * 7
