"""`benchmarks/operations.py`: the counts are those of the kernels. No test depends on speed."""

from pathlib import Path

import numpy as np
import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import quick_here, read

pytest.importorskip("numba")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("operations")


def test_every_part_has_operations_and_the_last_line_is_their_sum(out: Path) -> None:
    *parts, together = read(out / "table_counts.csv")
    assert [row["part"] for row in parts][-1] == "new episodes, accounting"
    assert len(parts) == 9
    for kind in ("arithmetic", "comparisons", "roots, divisions", "loads", "stores"):
        values = [float(row[kind]) for row in parts]
        assert sum(values) == pytest.approx(float(together[kind]), rel=1e-4)
        assert float(together[kind]) > 0
    # Both kernels hash: 10 operations for each of 4 words of the infra-reds, and of 8 or more of the camera.
    arithmetic = {row["part"]: float(row["arithmetic"]) for row in parts}
    assert arithmetic["infra-reds and their noise"] > 40
    assert arithmetic["camera"] > 80


def test_counts_are_those_of_the_seed(out: Path, tmp_path: Path) -> None:
    quick_here("operations", tmp_path / "again")
    name = "table_counts.csv"
    assert (tmp_path / "again" / name).read_bytes() == (out / name).read_bytes()


def test_the_limit_follows_from_counts_and_peaks(out: Path) -> None:
    together = read(out / "table_counts.csv")[-1]
    peaks = {row["operation"]: float(row["a nanosecond"]) for row in read(out / "table_peaks.csv")}
    times = {row["operations"]: float(row["ns a step"]) for row in read(out / "table_limit.csv")}
    assert times["arithmetic"] == pytest.approx(
        float(together["arithmetic"]) / peaks["additions and multiplications"], rel=1e-3
    )
    computed = times["arithmetic"] + times["comparisons"] + times["roots, divisions"]
    memory = times["loads and stores, in parallel"]
    assert times["shortest time"] == pytest.approx(max(computed, memory), rel=1e-3)


def test_numbers_and_records_count_what_is_done_with_them() -> None:
    from operation_counts.counters import ACCOUNT, CountingMath, Records

    ACCOUNT.counts.clear()
    block = np.zeros(1, [("x", "f8", (2,)), ("n", "i8")])
    record = Records(block[0])
    record.x[1] = CountingMath.sqrt(record.x[0] + 4.0) / 2
    record.n = 3
    assert (block["x"][0, 1], block["n"][0]) == (1.0, 3)
    assert not record.n < 2
    assert float(record.x[1] * 2) == 2.0
    assert Records(block, counts=False)[0].n + 1 == 4
    counts = {kind: number for (_, kind), number in ACCOUNT.counts.items()}
    assert counts == {"loads": 3, "stores": 2, "arithmetic": 2, "roots, divisions": 2, "comparisons": 1}
