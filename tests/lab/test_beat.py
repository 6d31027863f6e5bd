"""The beat on a clock that passes only when somebody sleeps or works."""

import logging

import pytest

from khepera_forage.lab.clock import MANY, WallBeat


class Clock:
    """Time that passes only when somebody sleeps or works."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0
        self.now += seconds


def test_the_beat_does_not_drift() -> None:
    clock = Clock()
    beat = WallBeat(0.1, clock, clock.sleep)
    beat.start()
    for i in range(1, 201):
        clock.now += 0.03 + 0.01 * (i % 5)
        beat.wait()
        assert clock.now == pytest.approx(100 + 0.1 * i)
    assert (beat.rounds, beat.overruns, beat.worst) == (200, 0, 0.0)


def test_overruns_are_counted_and_not_caught_up_in_a_burst() -> None:
    clock = Clock()
    beat = WallBeat(0.1, clock, clock.sleep)
    beat.start()
    clock.now += 0.13
    beat.wait()
    assert clock.now == pytest.approx(100.13)
    beat.wait()
    assert clock.now == pytest.approx(100.2), "back on the grid"
    clock.now += 0.57
    beat.wait()
    beat.wait()
    assert clock.now == pytest.approx(100.9), "not 100.8, which is less than half a period away"
    assert beat.overruns == 2
    assert beat.worst == pytest.approx(0.47)
    clock.now += 60.0
    beat.start()
    beat.wait()
    assert beat.overruns == 2, "a pause is no overrun"
    with pytest.raises(ValueError, match="period is 0"):
        WallBeat(0)


@pytest.mark.parametrize("late", [MANY - 1, MANY])
def test_many_overruns_are_told_of_once(late: int, caplog: pytest.LogCaptureFixture) -> None:
    clock = Clock()
    beat = WallBeat(0.1, clock, clock.sleep)
    beat.start()
    with caplog.at_level(logging.WARNING):
        for i in range(100):
            clock.now += 0.12 if i < 2 * late and i % 2 else 0.05
            beat.wait()
    told = [record.getMessage() for record in caplog.records]
    assert told == (
        []
        if late < MANY
        else ["10 of the last 100 rounds took longer than 100 ms; the worst so far was 20 ms over"]
    )
