"""`benchmarks/operations.py`: what is counted is what the kernels do; how fast anything is, no test asks."""

from pathlib import Path

import pytest

from tests.benchmarks.running import help_of, quick, read

pytest.importorskip("numba")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("operations") / "out"
    printed = quick("operations.py", folder)
    assert (folder / "operations.md").read_text(encoding="utf-8") in printed
    return folder


def test_every_part_counts_and_the_last_line_is_their_sum(out: Path) -> None:
    *parts, together = read(out / "operations_counts.csv")
    assert [row["part"] for row in parts][-1] == "new episodes, account"
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
    quick("operations.py", tmp_path / "again")
    name = "operations_counts.csv"
    assert (tmp_path / "again" / name).read_bytes() == (out / name).read_bytes()


def test_the_limit_follows_from_counts_and_peaks(out: Path) -> None:
    together = read(out / "operations_counts.csv")[-1]
    peaks = {row["operation"]: float(row["a nanosecond"]) for row in read(out / "operations_peaks.csv")}
    times = {row["what"]: float(row["ns a step"]) for row in read(out / "operations_limit.csv")}
    assert times["arithmetic"] == pytest.approx(
        float(together["arithmetic"]) / peaks["additions and multiplications"], rel=1e-3
    )
    computed = times["arithmetic"] + times["comparisons"] + times["roots, divisions"]
    memory = times["loads and stores, beside these"]
    assert times["least time"] == pytest.approx(max(computed, memory), rel=1e-3)


def test_help_names_every_argument() -> None:
    told = help_of("operations.py")
    for argument in ("--seed", "--out", "--quick", "--steps", "results/operations"):
        assert argument in told
