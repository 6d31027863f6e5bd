"""`benchmarks/wire.py`: its table is that of its rows.

What it measures are times, which depend on what else runs. The promises about them are tested on lines with a clock of
their own (`tests/robots/test_serial_timing.py`), and by what robots do (`tests/robots`).
"""

from statistics import median

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("serial")


def test_table_is_that_of_the_rows(quick_run: QuickRun) -> None:
    out = quick_run("wire")
    rows, openings = read(out / "rounds.csv"), {row["line"]: row for row in read(out / "openings.csv")}
    lines = read(out / "table_lines.csv")
    assert [line["line"] for line in lines] == list(openings)
    for line in lines:
        opening, own = openings[line["line"]], [row for row in rows if row["line"] == line["line"]]
        assert line["accepted"] == ("yes" if opening["accepted"] == "1" else "no")
        assert bool(own) == (opening["accepted"] == "1")
        assert int(line["rounds"]) == len(own)
        for moves, name in (("0", "gripper rests"), ("1", "gripper moves, or its position is read")):
            times = [float(row["ms"]) for row in own if row["moves"] == moves]
            assert bool(times) == bool(own)
            if times:
                assert float(line[name]) == pytest.approx(median(times), rel=1e-4)
                assert float(line[f"{name}: low"]) <= float(line[name]) <= float(line[f"{name}: high"])
                assert float(line["longest"]) >= max(times) * (1 - 1e-4)
        assert int(line["wrong counter"]) == sum(row["wrong"] == "1" for row in own)
    assert openings["latency 100 ms"]["accepted"] == "0"
