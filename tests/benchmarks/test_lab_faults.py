"""`benchmarks/lab_faults.py`: after every fault the robots stand, the experience is right, and training goes on."""

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("serial")
pytest.importorskip("cv2")


def test_after_every_fault_robots_stand_experience_is_right_and_training_goes_on(quick_run: QuickRun) -> None:
    out = quick_run("lab_faults")
    # On a busy machine a virtual robot may reply too late without a fault.
    faults = [row for row in read(out / "faults.csv") if row["kind"] != "unexpected"]
    assert len(faults) == len({row["kind"] for row in faults}) == 10
    assert {row["part"] for row in faults} == {"robot", "camera", "disk"}
    assert {row["outcome"] for row in faults} == {"recovered", "attempt lost", "stopped"}
    for row in faults:
        assert (row["moving"], row["out_of_reach"], row["continued"], row["intact"]) == (
            "0",
            "0",
            "1",
            "1",
        ), row
        assert [row[name] for name in ("altered", "wrong", "outdated")] == ["0"] * 3, row
        # The vector that a full disk does not take.
        assert int(row["missing"]) <= (row["part"] == "disk"), row
        if row["outcome"] != "recovered":
            assert (row["notices"], row["named"]) == ("1", "1"), row
    (training,) = read(out / "table_trainings.csv")
    assert training["complete"] == training["planned"]
    assert training["foreign"] == "0"
