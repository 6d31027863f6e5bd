"""`benchmarks/wire.py`: times on the wire are those of the bytes, slow lines are handled, all ends stop robots."""

from statistics import median

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("serial")
ROUNDS = 12


@pytest.fixture(scope="module")
def rows(quick_run: QuickRun) -> list[dict[str, str]]:
    return read(quick_run("wire") / "measurements.csv")


def values(rows: list[dict[str, str]], part: str, measure: str, case: str = "") -> list[float]:
    """The values of a measure in all cases of a part that begin so."""
    own = (row for row in rows if (row["part"], row["measure"]) == (part, measure))
    return [float(row["value"]) for row in own if row["case"].startswith(case)]


def test_tables_are_those_of_the_rows(rows: list[dict[str, str]], quick_run: QuickRun) -> None:
    lines = 0
    for part in ("rounds", "latency", "disturbances", "endings"):
        for line in read(quick_run("wire") / f"table_{part}.csv"):
            own = values([row for row in rows if row["case"] == line["case"]], part, line["measure"])
            assert int(line["values"]) == len(own) > 0
            assert float(line["longest"]) == pytest.approx(max(own), rel=1e-4)
            assert float(line["median"]) == pytest.approx(median(own), rel=1e-4)
            assert float(line["median: low"]) <= float(line["median"]) <= float(line["median: high"])
            lines += 1
    assert lines == len({(row["part"], row["case"], row["measure"]) for row in rows})


@pytest.mark.parametrize("baud", [9600, 19200, 38400, 57600, 115200])
def test_every_round_takes_the_time_of_its_bytes(rows: list[dict[str, str]], baud: int) -> None:
    counts, wires, taken = (
        values(rows, "rounds", name, f"{baud} baud, 1 ") for name in ("bytes", "on the wire", "measured")
    )
    assert len(counts) == ROUNDS
    for count, wire, ms in zip(counts, wires, taken, strict=True):
        assert wire == pytest.approx(1000 * 11 * count / baud, rel=1e-3)
        # Both directions at once: requests are sent while the first replies arrive.
        assert ms > 0.4 * wire
        assert baud < 38400 or wire < 60, "well within 100 ms"


def test_robots_are_served_in_parallel(rows: list[dict[str, str]]) -> None:
    one, *others = (sorted(values(rows, "rounds", "measured", f"38400 baud, {n} ")) for n in (1, 2, 4, 8))
    for taken in others:
        assert taken[0] < 4 * one[ROUNDS // 2], "eight in turn would take eight times as long, whatever else runs"


def test_a_latency_is_pipelined_or_rejected(rows: list[dict[str, str]]) -> None:
    # One by one, four requests would take 320 ms at a latency of 80 ms: such a line would be rejected.
    for ms in (16, 80):
        assert len(values(rows, "latency", "end", f"{ms} ms")) == 10
    assert len(values(rows, "latency", "rejected after", "100 ms")) == 1


def test_counters_are_right_on_disturbed_lines(rows: list[dict[str, str]]) -> None:
    for case in ("none", "20 % garbled"):
        assert values(rows, "disturbances", "error at the end (pulses)", case) == [0]
        (wrong,) = values(rows, "disturbances", "rounds with a wrong counter", case)
        assert [wrong] <= values(rows, "disturbances", "undetectable", case)
    assert set(values(rows, "disturbances", "lost")) == {0}


def test_every_end_of_a_process_stops_the_robot(rows: list[dict[str, str]]) -> None:
    for ending in ("Ctrl-C", "Ctrl-Z", "kill -9", "SIGSTOP"):
        assert max(values(rows, "endings", "wheels turn on", ending)) < 5000
