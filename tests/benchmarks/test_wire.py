"""`benchmarks/wire.py`: times on the wire are those of the bytes, slow lines are handled, all ends stop robots."""

from pathlib import Path

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("serial")
ROUNDS = 12
BAUDS = (9600, 19200, 38400, 57600, 115200)


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("wire")


def test_every_round_takes_the_time_of_its_bytes(out: Path) -> None:
    rows = read(out / "rounds.csv")
    assert len(rows) == ROUNDS * (len(BAUDS) + 3)
    assert {int(row["baud"]) for row in read(out / "table_wire.csv")} == set(BAUDS)
    for row in rows:
        wire = float(row["wire"])
        assert wire == pytest.approx(1000 * 11 * int(row["bytes"]) / int(row["baud"]), rel=1e-3)
        # Both directions at once: requests are sent while the first replies arrive.
        assert float(row["taken"]) > 0.4 * wire
        assert int(row["baud"]) < 38400 or wire < 60, "well within 100 ms"


def test_robots_are_served_in_parallel(out: Path) -> None:
    fleet = read(out / "table_fleet.csv")
    assert [int(row["robots"]) for row in fleet] == [1, 2, 4, 8]
    assert all(float(row["times one robot's"]) < 4 for row in fleet), (
        "eight in turn would take eight times as long"
    )


def test_a_latency_is_pipelined_or_rejected(out: Path) -> None:
    lines = {int(row["latency"]): row for row in read(out / "table_latency.csv")}
    # One by one, four requests would take 320 ms at a latency of 80 ms: such a line would be rejected.
    assert {ms: row["line"] for ms, row in lines.items()} == {16: "accepted", 80: "accepted", 100: "rejected"}
    for latency in (16, 80):
        assert float(lines[latency]["bound"]) == pytest.approx(100 + latency)


def test_counters_are_right_on_disturbed_lines(out: Path) -> None:
    for row in read(out / "table_disturbances.csv"):
        assert int(row["counter error at the end (pulses)"]) == 0
        assert int(row["counters wrong (rounds)"]) <= int(row["undetectable"])
        assert row["lost"] == "0"


def test_every_end_of_a_process_stops_the_robot(out: Path) -> None:
    endings = {row["end of the process"]: row for row in read(out / "table_endings.csv")}
    assert set(endings) == {"Ctrl-C", "Ctrl-Z", "kill -9", "SIGSTOP"}
    assert all(float(row["wheels turn on (ms): high"]) < 5000 for row in endings.values())
