"""Faults of a line: drawn at their rates, from a seed, and counted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.protocol import Reply, decode_reply, encode_reply
from khepera_forage.robots.virtual.line_faults import FAULTS, FaultCounts, Faults, FaultSource

REPLY = encode_reply(Reply("N", (12, 345, 6, 1023, 77, 0, 8, 910)))


def source(faults: Faults, seed: int = 0) -> FaultSource:
    return FaultSource(faults, np.random.default_rng(seed))


def test_each_fault_at_its_rate_and_counted() -> None:
    faults = Faults(drop=0.05, delay=0.1, garble=0.15, duplicate=0.2, reset=0.02, unplug=0.01)
    line = source(faults)
    drawn = [line.next() for _ in range(20_000)]
    for fault in FAULTS:
        assert abs(drawn.count(fault) / len(drawn) - getattr(faults, fault)) < 0.01
        assert getattr(line.counts, fault) == drawn.count(fault)
    assert line.counts.replies == len(drawn)
    assert line.counts.disturbed == len(drawn) - drawn.count(None)


def test_same_seed_same_faults() -> None:
    faults = Faults(drop=0.3, garble=0.3)
    runs = []
    for _ in range(2):
        line = source(faults, seed=5)
        runs.append([(line.next(), line.garble(REPLY), line.either(), line.lateness()) for _ in range(50)])
    assert runs[0] == runs[1]
    assert runs[0] != [(None, REPLY, False, 0.0)] * 50


def test_rates_can_be_changed_at_any_time() -> None:
    line = source(Faults(drop=1.0))
    assert line.next() == "drop"
    line.rates = Faults()
    assert line.next() is None
    line.rates = Faults(reset=1.0)
    assert line.next() == "reset"
    assert line.counts == FaultCounts(replies=3, drop=1, reset=1)


def test_no_faults_need_no_generator_and_some_do() -> None:
    line = FaultSource()
    assert line.next() is None
    with pytest.raises(ValueError, match="default_rng"):
        line.rates = Faults(drop=0.1)
    with pytest.raises(ValueError, match="default_rng"):
        FaultSource(Faults(garble=0.1))


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"drop": -0.1}, "drop is -0.1"),
        ({"reset": 1.5}, "reset is 1.5"),
        ({"garble": float("nan")}, "garble is nan"),
        ({"drop": 0.6, "delay": 0.6}, "add up to 1.2"),
        ({"lateness": (1.0, 0.3)}, "lateness"),
        ({"lateness": (-1.0, 0.3)}, "lateness"),
    ],
)
def test_bad_rates(wrong: dict[str, float], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        Faults(**wrong)  # type: ignore[arg-type]


@given(st.integers(0, 2**32 - 1))
def test_garbling_changes_little(seed: int) -> None:
    garbled = source(Faults(garble=1.0), seed).garble(REPLY)
    assert abs(len(garbled) - len(REPLY)) <= 3
    assert _common(garbled, REPLY) >= len(REPLY) - 3


def _common(one: bytes, other: bytes) -> int:
    """How many bytes, in order, the two have in common."""
    row = [0] * (len(other) + 1)
    for byte in one:
        before = 0
        for i, its in enumerate(other, 1):
            before, row[i] = row[i], before + 1 if byte == its else max(row[i], row[i - 1])
    return row[-1]


def test_garbling_that_no_host_can_see_is_counted_apart() -> None:
    line = source(Faults(garble=1.0))
    true, deceiving = decode_reply(REPLY), 0
    for _ in range(2000):
        garbled = line.garble(REPLY)
        if garbled.endswith((b"\r", b"\n")) and b"\r" not in garbled[:-2] and b"\n" not in garbled[:-2]:
            try:
                read = decode_reply(garbled)
            except ValueError:
                continue
            deceiving += isinstance(read, Reply) and read.command == "N" and read != true
    assert deceiving > 100
    assert abs(line.counts.unseen - deceiving) < 30, "all but those with a line end in their middle"


def test_a_cut_reply_is_a_beginning() -> None:
    line = source(Faults(reset=1.0))
    lengths = set()
    for _ in range(500):
        cut = line.cut(REPLY)
        assert REPLY.startswith(cut)
        lengths.add(len(cut))
    assert lengths == set(range(1, len(REPLY)))


def test_lateness_is_within_its_limits() -> None:
    line = source(Faults(delay=1.0, lateness=(0.05, 0.07)))
    times = [line.lateness() for _ in range(200)]
    assert 0.05 <= min(times) < 0.055 < 0.065 < max(times) <= 0.07
