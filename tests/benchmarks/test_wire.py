"""`benchmarks/wire.py`: times on the wire are those of the bytes, slow lines are handled, all ends stop robots."""

from pathlib import Path

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

ROUNDS = 25
BAUDS = (9600, 19200, 38400, 57600, 115200)


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("wire")


def test_wire_time_is_that_of_the_bytes(out: Path) -> None:
    rows = read(out / "rounds.csv")
    assert len(rows) == ROUNDS * (len(BAUDS) + 3)
    for row in rows:
        count = int(row["sent"]) + int(row["received"])
        assert float(row["wire"]) == pytest.approx(1000 * 11 * count / int(row["baud"]), rel=1e-3)
        # Both directions at once: requests are sent while the first replies arrive.
        longer = max(int(row["sent"]), int(row["received"])) / count * float(row["wire"])
        assert float(row["taken"]) > 0.8 * longer


def test_a_round_asks_for_what_a_step_needs_and_fits_at_38400_baud(out: Path) -> None:
    rows = read(out / "rounds.csv")
    most = len("D,-12,-12\nN\nT,1,G\nH\n") + len("E\nN\n")
    # On a busy machine, late replies and doubtful readings are requested again.
    long = [row for row in rows if row["gripper"] == "0" and int(row["sent"]) > most]
    assert len(long) <= len(rows) / 20
    for row in rows:
        needed = len("D,0,0\nN\nT,1,G\nH\n")
        assert int(row["sent"]) >= needed
        if int(row["baud"]) >= 38400:
            assert float(row["wire"]) < 60, "well within 100 ms"


def test_every_baud_rate_and_number_of_robots_has_its_line(out: Path) -> None:
    wire = read(out / "table_wire.csv")
    assert {int(row["baud"]) for row in wire} == set(BAUDS)
    for baud in BAUDS:
        assert sum(int(row["rounds"]) for row in wire if int(row["baud"]) == baud) == ROUNDS
    fleet = read(out / "table_fleet.csv")
    assert [int(row["robots"]) for row in fleet] == [1, 2, 4, 8]
    assert float(fleet[0]["times one robot's"]) == 1.0
    assert all(float(row["times one robot's"]) < 4 for row in fleet), (
        "eight in turn would take eight times as long"
    )


def test_every_latency_is_pipelined_or_rejected(out: Path) -> None:
    lines = {int(row["latency (ms)"]): row for row in read(out / "table_latency.csv")}
    assert [lines[latency]["requests"] for latency in (0, 16, 80, 100, 1000)] == [
        "pipelined",
        "pipelined",
        "pipelined",
        "rejected",
        "rejected",
    ]
    assert all(float(row["opening (ms)"]) < 2000 for row in lines.values())
    assert float(lines[80]["between rounds (ms)"]) < 180, "one by one, four requests would take 320 ms"
    for latency in (0, 16, 80):
        assert float(lines[latency]["bound: period + latency (ms)"]) == pytest.approx(100 + latency)
        assert float(lines[latency]["from the beginning of the period (ms)"]) < 100 + latency


def test_counters_are_right_on_disturbed_lines(out: Path) -> None:
    rows = read(out / "table_disturbances.csv")
    assert len(rows) == 4
    for row in rows:
        assert int(row["counter error at the end (pulses)"]) == 0
        assert int(row["counters wrong (rounds)"]) <= int(row["undetectable"])
        assert int(row["lost"]) <= (1 if "late" in row["replies"] else 0)


def test_every_end_of_a_process_stops_the_robot(out: Path) -> None:
    endings = read(out / "table_endings.csv")
    assert {"Ctrl-C", "Ctrl-Z", "kill -9", "SIGSTOP", "os._exit"} <= {
        row["end of the process"] for row in endings
    }
    assert all(float(row["wheels turn on (ms): high"]) < 1000 for row in endings)
