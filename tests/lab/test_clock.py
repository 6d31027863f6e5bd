"""The wall clock of a laboratory, with fake time."""

import logging

import pytest

from khepera_forage.lab.clock import WallClock
from tests.lab.laboratories import Time


def test_rounds_do_not_drift() -> None:
    fake = Time()
    clock = WallClock(0.1, fake.monotonic, lambda seconds: fake.sleep(seconds + 0.002))  # as late as a system wakes it
    clock.start()
    for i in range(1, 201):
        fake.now += 0.03 + 0.01 * (i % 5)
        clock.wait()
        assert fake.now == pytest.approx(100.002 + 0.1 * i)
    assert (clock.rounds, clock.overruns, clock.worst_overrun) == (200, 0, 0.0)


def test_overruns_are_counted_without_a_burst_of_short_rounds() -> None:
    fake = Time()
    clock = WallClock(0.1, fake.monotonic, fake.sleep)
    clock.start()
    fake.now += 0.13
    clock.wait()
    assert fake.now == pytest.approx(100.13)
    clock.wait()
    assert fake.now == pytest.approx(100.2), "back at a multiple of the period"
    fake.now += 0.57
    clock.wait()
    clock.wait()
    assert fake.now == pytest.approx(100.9), "not 100.8, which is less than half a period away"
    assert clock.overruns == 2
    assert clock.worst_overrun == pytest.approx(0.47)
    fake.now += 60.0
    clock.start()
    clock.wait()
    assert clock.overruns == 2, "a pause is not an overrun"
    with pytest.raises(ValueError, match="period is 0"):
        WallClock(0)


@pytest.mark.parametrize("late", [9, 10])
def test_many_overruns_cause_one_warning(late: int, caplog: pytest.LogCaptureFixture) -> None:
    fake = Time()
    clock = WallClock(0.1, fake.monotonic, fake.sleep)
    clock.start()
    with caplog.at_level(logging.WARNING):
        for i in range(100):
            fake.now += 0.12 if i < 2 * late and i % 2 else 0.05
            clock.wait()
    warnings = [record.getMessage() for record in caplog.records]
    assert warnings == (
        [] if late < 10 else ["10 of the last 100 rounds took longer than 100 ms; the worst so far was 20 ms over"]
    )
