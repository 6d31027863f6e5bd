"""`benchmarks/wire.py`: its tables are those of its rows.

What it measures are times, which depend on what else runs. The promises about them are tested on lines with a clock of
their own (`tests/robots/test_serial_timing.py`), and by what robots do (`tests/robots`).
"""

from statistics import median

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("serial")


def test_tables_are_those_of_the_rows(quick_run: QuickRun) -> None:
    out, lines = quick_run("wire"), 0
    rows = read(out / "measurements.csv")
    for part in ("rounds", "latency", "disturbances", "endings"):
        for line in read(out / f"table_{part}.csv"):
            key = (part, line["case"], line["measure"])
            own = [float(row["value"]) for row in rows if (row["part"], row["case"], row["measure"]) == key]
            assert int(line["values"]) == len(own) > 0
            assert float(line["longest"]) == pytest.approx(max(own), rel=1e-4)
            assert float(line["median"]) == pytest.approx(median(own), rel=1e-4)
            assert float(line["median: low"]) <= float(line["median"]) <= float(line["median: high"])
            lines += 1
    assert lines == len({(row["part"], row["case"], row["measure"]) for row in rows})
