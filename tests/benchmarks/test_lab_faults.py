"""`benchmarks/lab_faults.py`: after every fault the robots stand, the experience is right, and training goes on."""

import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

UNEXPECTED = "unexpected"
"""On a busy machine a virtual robot may reply too late without a fault."""


@pytest.fixture(scope="module")
def faults(quick_run: QuickRun) -> list[dict[str, str]]:
    return [row for row in read(quick_run("lab_faults") / "faults.csv") if row["kind"] != UNEXPECTED]


@pytest.fixture(scope="module")
def training(quick_run: QuickRun) -> dict[str, str]:
    (row,) = read(quick_run("lab_faults") / "table_trainings.csv")
    return row


def test_every_part_of_the_laboratory_fails(faults: list[dict[str, str]]) -> None:
    assert len(faults) == len({row["kind"] for row in faults}) == 10
    assert {row["part"] for row in faults} == {"robot", "camera", "disk"}
    assert {row["outcome"] for row in faults} == {"recovered", "attempt lost", "stopped"}


def test_robots_stand_still_after_every_fault(faults: list[dict[str, str]]) -> None:
    assert [row["moving"] for row in faults] == ["0"] * len(faults)
    assert [row["out_of_reach"] for row in faults] == ["0"] * len(faults)


def test_no_experience_is_damaged_or_wrong(faults: list[dict[str, str]]) -> None:
    for row in faults:
        assert row["intact"] == "1", row
        assert [row[name] for name in ("altered", "wrong", "outdated")] == ["0"] * 3, row
        # The vector that a full disk does not take.
        assert int(row["missing"]) <= (row["part"] == "disk"), row


def test_every_loss_has_one_message_that_names_it(faults: list[dict[str, str]]) -> None:
    for row in faults:
        if row["outcome"] != "recovered":
            assert (row["notices"], row["named"]) == ("1", "1"), row


def test_training_goes_on_to_its_planned_end(faults: list[dict[str, str]], training: dict[str, str]) -> None:
    assert all(row["continued"] == "1" for row in faults)
    assert training["complete"] == training["planned"]
    assert (training["foreign"], training["stuck"]) == ("0", "0")
