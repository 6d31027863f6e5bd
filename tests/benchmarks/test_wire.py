"""`benchmarks/wire.py`: time on the wire is that of the bytes, and robots in parallel cost what one costs."""

from pathlib import Path

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

ROUNDS = 40
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
        # The first robot's bytes cannot pass faster than its line carries them; its thread may see them a little late.
        assert float(row["taken"]) > 0.8 * float(row["wire"])


def test_a_round_asks_for_what_a_step_needs_and_fits_at_38400_baud(out: Path) -> None:
    for row in read(out / "rounds.csv"):
        needed = len("D,0,0\nN\nT,1,G\nH\n")
        assert int(row["sent"]) >= needed
        if row["gripper"] == "0":
            assert int(row["sent"]) <= len("D,-12,-12\nN\nT,1,G\nH\n") + len("E\nN\n")
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
