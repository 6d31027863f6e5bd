"""`benchmarks/kheperax.py` without Kheperax itself, which needs JAX, an environment of its own and the network."""

import json
import math
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from khepera_forage.robots.khepera import FOOD_RADIUS, MAX_SPEED, RADIUS, WHEEL_BASE
from tests.benchmarks.running import is_picture, read, refused

pytest.importorskip("numba")

from kheperax_comparison import measures
from kheperax_comparison.environment import NoKheperax
from kheperax_comparison.measures import TimedLine
from kheperax_comparison.ours import OurBodies, whole_task
from kheperax_comparison.page import page
from kheperax_comparison.theirs import About, Timed, answer_of
from kheperax_comparison.work import ARENA, FOODS, HELD, ROUNDS, TRAVEL, Work

from khepera_forage.study import write

ABOUT = About("0.2.0", "0.10.2", "3.11.7", 2, "float32", 20, 10, 16.0, 4.5, 0.0)
RATES = {
    measures.NOISE.theirs: 0.5e6,
    measures.NOISE.ours: 6e6,
    measures.CLEAN.theirs: 0.5e6,
    measures.CLEAN.ours: 7e6,
}


def test_numbers_of_worlds_are_checked() -> None:
    assert "'0'; allowed: a whole number of at least 1" in refused("kheperax", "--worlds", "64", "0")


def test_a_folder_that_is_no_environment_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    told = refused("kheperax", "--out", str(tmp_path / "out"), "--venv", str(tmp_path))
    assert f"--venv is {str(tmp_path)!r}, which is no virtual environment" in told
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_an_environment_without_kheperax_is_reported_with_its_last_output(tmp_path: Path) -> None:
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python").symlink_to(Path(sys.base_prefix) / "bin" / "python3")
    told = refused("kheperax", "--out", str(tmp_path / "out"), "--venv", str(tmp_path))
    assert "ended with status 1" in told
    assert "ModuleNotFoundError" in told
    assert "delete it" in told


def test_answers_are_read_strictly() -> None:
    timed = {"worlds": 64, "steps": 4096, "seconds": 0.5, "first_call": 2.0}
    assert answer_of(json.dumps(timed), Timed) == Timed(64, 4096, 0.5, 2.0)
    assert answer_of(json.dumps(asdict(ABOUT)), About) == ABOUT
    for wrong, why in (
        ("Platform 'x' is experimental", "a JSON object"),
        ("[64, 4096, 0.5, 2.0]", "an object with worlds, steps, seconds, first_call"),
        (json.dumps({**timed, "more": 1}), "an object with worlds"),
        (json.dumps({**timed, "steps": 4096.0}), "answered steps 4096.0; allowed: int"),
        (json.dumps({**timed, "worlds": True}), "answered worlds True; allowed: int"),
    ):
        with pytest.raises(NoKheperax, match="answered") as raised:
            answer_of(wrong, Timed)
        assert why in str(raised.value)


def test_work_is_that_of_its_seed_and_on_the_free_floor() -> None:
    work, again, other = Work.of(500, 3), Work.of(500, 3), Work.of(500, 4)
    assert np.array_equal(work.starts, again.starts)
    assert np.array_equal(work.wheels, again.wheels)
    assert not np.array_equal(work.starts, other.starts)
    assert work.starts.shape == (500, 3)
    units = work.wheels * MAX_SPEED
    assert np.allclose(units, np.round(units))
    assert units.min() == -MAX_SPEED
    assert units.max() == MAX_SPEED
    x1, y1, x2, y2 = ARENA.bounds
    for x, y, _ in work.starts:
        assert min(x - x1, x2 - x, y - y1, y2 - y) > RADIUS
        assert min(math.dist((x, y), food) for food in FOODS) > RADIUS + FOOD_RADIUS


def test_what_kheperax_gets_needs_no_pickle(tmp_path: Path) -> None:
    work = Work.of(5, 0)
    np.savez(tmp_path / "work.npz", **work.for_kheperax(2))
    with np.load(tmp_path / "work.npz", allow_pickle=False) as file:
        assert np.array_equal(file["wheels"], work.wheels)
        assert float(file["travel"]) == 16.0
        assert np.degrees(file["directions"]) == pytest.approx([90, 45, 10, -10, -45, -90, 180, 180])


def test_our_robots_drive_as_commanded() -> None:
    count = 2000
    work = Work.of(count, 1)
    bodies = OurBodies(work, 1)
    timed = bodies.timed(False, count, 1e-6, False)
    assert (timed.worlds, timed.steps) == (count, count * ROUNDS)
    assert timed.seconds > 0
    x, y, heading = work.starts.T
    clear = np.ones(count, bool)
    for left, right in np.repeat(work.wheels, HELD, axis=0).swapaxes(1, 2) * TRAVEL:
        forward, turn = (left + right) / 2, (right - left) / WHEEL_BASE
        x, y = x + forward * np.cos(heading + turn / 2), y + forward * np.sin(heading + turn / 2)
        heading = heading + turn
        walls = np.min((x, 650 - x, y, 600 - y), axis=0)
        food = np.min([np.hypot(x - food_x, y - food_y) for food_x, food_y in FOODS], axis=0)
        clear &= (walls > 120) & (food > 80)
    assert clear.sum() > 20
    off = np.hypot(*(bodies.poses(count)[clear, :2] - np.stack((x, y), axis=1)[clear]).T)
    assert np.median(off) < 1e-6, "near food, which a few of them are, speeds change a little late"


def test_reading_the_sensors_changes_nothing() -> None:
    bodies = OurBodies(Work.of(9, 0), 0)
    bodies.timed(False, 9, 1e-6, False)
    alone = bodies.poses(9)
    assert bodies.timed(False, 9, 1e-6, True).steps == 9 * ROUNDS
    assert np.array_equal(bodies.poses(9), alone)


@pytest.mark.parametrize("arena", sorted(measures.TASKS))
def test_the_whole_task_runs_until_the_time_is_over(arena: str) -> None:
    timed = whole_task(arena, 16, 0, 1e-6)
    assert timed.worlds == 16
    assert timed.steps > 4 * 16 * 20, "a forage takes some tens of steps"


@pytest.fixture(scope="module")
def rows() -> list[TimedLine]:
    """Three repeats: the second is twice as fast, for both sides; 1024 worlds suit ours, 256 Kheperax."""
    made = []
    pairs = [line for pair in measures.PAIRS for line in (pair.theirs, pair.ours)]
    for repeat, speed in enumerate((1.0, 2.0, 1.1)):
        for line in pairs:
            for worlds in (256, 1024):
                suits = worlds == (1024 if line.startswith("compiled bodies") else 256)
                rate = RATES.get(line, 1e6) * speed * (1.0 if suits else 0.5)
                made.append(TimedLine(line, worlds, repeat, round(rate), 1.0, 2.5))
        for line in (measures.DEFAULT, *measures.TASKS.values()):
            made.append(TimedLine(line, 1024, repeat, round(3e6 * speed), 1.0, 0.1))
    return made


def test_ratios_are_taken_within_repeats_and_each_side_has_its_best_worlds(rows: list[TimedLine]) -> None:
    assert measures.best(rows, measures.NOISE.ours) == (measures.NOISE.ours, 1024)
    assert measures.best(rows, measures.NOISE.theirs) == (measures.NOISE.theirs, 256)
    both = measures.ratio(rows, (measures.NOISE.ours, 1024), (measures.NOISE.theirs, 256))
    assert both == pytest.approx((12, 12, 12)), "a faster repeat is faster for both"
    assert measures.rate(rows, (measures.NOISE.ours, 1024)) == pytest.approx((6.6e6, 6e6, 12e6))
    same = measures.ratio(rows, (measures.NOISE.ours, 256), (measures.NOISE.theirs, 256))
    assert same == pytest.approx((6, 6, 6))


def test_page_picture_and_tables_are_written(rows: list[TimedLine], tmp_path: Path) -> None:
    write(tmp_path, "kheperax", page(rows, ABOUT, 1134.0), "the command")
    text = (tmp_path / "kheperax.md").read_text(encoding="utf-8")
    assert (
        "**Our compiled bodies make 12.0 [12.0, 12.0] times as many robot-steps a second as Kheperax**"
        in text
    )
    assert f"| {measures.CLEAN.ours} | 1024 | 7.70 [7.00, 14.00] | 14.0 [14.0, 14.0] |" in text
    assert "with 75.0 % confidence" in text
    for said in ("Kheperax 0.2.0", "JAX 0.10.2", "1,134 MB", "20 segments", "float32", "## What is equal"):
        assert said in text
    assert "drives into the wall (here 4.5 mm)" in text
    assert "ten steps backwards: 0.0 mm" in text
    assert is_picture(tmp_path / "kheperax.png")
    assert len(read(tmp_path / "table_by_worlds.csv")) == 2 * len(measures.PAIRS)
    assert len(read(tmp_path / "table_robot_steps.csv")) == 2 * len(measures.PAIRS) + 1 + len(measures.TASKS)


def test_a_warm_up_leaves_no_rows() -> None:
    class Theirs:
        def timed(self, setting: str, worlds: int, at_least: float, calls: bool) -> Timed:
            return Timed(worlds, 64 * worlds, 0.5, 2.0)

    plan = measures.Plan((3,), 5, 1e-6, 0)
    bodies = OurBodies(Work.of(5, 0), 0)
    assert not measures.Repeat(-1, plan, Theirs(), bodies).run()  # type: ignore[arg-type]
    rows = measures.Repeat(0, plan, Theirs(), bodies).run()  # type: ignore[arg-type]
    assert [row.line for row in rows[:2]] == [measures.NOISE.theirs, measures.NOISE.ours]
    assert len(rows) == 2 * len(measures.PAIRS) + 1 + len(measures.TASKS)
    assert all(row.rate > 0 for row in rows)
