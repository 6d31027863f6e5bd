"""Fault injection: rates, seeds and counts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.khepera_protocol import KHEPERA
from khepera_forage.robots.serial.protocol import Reply
from khepera_forage.robots.virtual.faults import FAULTS, FaultCounts, FaultInjector, Faults

REPLY = KHEPERA.encode_reply(Reply("N", (12, 345, 6, 1023, 77, 0, 8, 910)))


def make_injector(faults: Faults, seed: int = 0) -> FaultInjector:
    return FaultInjector(KHEPERA, faults, np.random.default_rng(seed))


def test_faults_occur_at_their_rates_and_are_counted() -> None:
    faults = Faults(drop=0.05, delay=0.1, garble=0.15, duplicate=0.2, reset=0.02, unplug=0.01)
    injector = make_injector(faults)
    drawn = [injector.draw() for _ in range(20_000)]
    for fault in FAULTS:
        assert abs(drawn.count(fault) / len(drawn) - getattr(faults, fault)) < 0.01
        assert getattr(injector.counts, fault) == drawn.count(fault)
    assert injector.counts.replies == len(drawn)
    assert injector.counts.disturbed == len(drawn) - drawn.count(None)


def test_same_seed_draws_the_same_faults() -> None:
    faults = Faults(drop=0.3, garble=0.3)
    runs = []
    for _ in range(2):
        injector = make_injector(faults, seed=5)
        runs.append(
            [
                (injector.draw(), injector.garble(REPLY), injector.coin_toss(), injector.lateness())
                for _ in range(50)
            ]
        )
    assert runs[0] == runs[1]
    assert runs[0] != [(None, REPLY, False, 0.0)] * 50


def test_new_rates_apply_to_the_next_reply() -> None:
    injector = make_injector(Faults(drop=1.0))
    assert injector.draw() == "drop"
    injector.rates = Faults()
    assert injector.draw() is None
    injector.rates = Faults(reset=1.0)
    assert injector.draw() == "reset"
    assert injector.counts == FaultCounts(replies=3, drop=1, reset=1)


def test_faults_without_a_random_generator_are_rejected() -> None:
    injector = FaultInjector(KHEPERA)
    assert injector.draw() is None
    with pytest.raises(ValueError, match="default_rng"):
        injector.rates = Faults(drop=0.1)
    with pytest.raises(ValueError, match="default_rng"):
        FaultInjector(KHEPERA, Faults(garble=0.1))


@pytest.mark.parametrize(
    ("rates", "message"),
    [
        ({"drop": -0.1}, "drop is -0.1"),
        ({"reset": 1.5}, "reset is 1.5"),
        ({"garble": float("nan")}, "garble is nan"),
        ({"drop": 0.6, "delay": 0.6}, "add up to 1.2"),
        ({"lateness": (1.0, 0.3)}, "lateness"),
        ({"lateness": (-1.0, 0.3)}, "lateness"),
    ],
)
def test_invalid_rates_are_rejected(rates: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Faults(**rates)  # type: ignore[arg-type]


@given(st.integers(0, 2**32 - 1))
def test_garbling_changes_at_most_three_bytes(seed: int) -> None:
    garbled = make_injector(Faults(garble=1.0), seed).garble(REPLY)
    assert abs(len(garbled) - len(REPLY)) <= 3
    assert _common_bytes(garbled, REPLY) >= len(REPLY) - 3


def _common_bytes(one: bytes, other: bytes) -> int:
    """Length of the longest common subsequence."""
    row = [0] * (len(other) + 1)
    for byte in one:
        before = 0
        for i, its in enumerate(other, 1):
            before, row[i] = row[i], before + 1 if byte == its else max(row[i], row[i - 1])
    return row[-1]


def test_undetectable_garbling_is_counted_separately() -> None:
    injector = make_injector(Faults(garble=1.0))
    original, undetectable = KHEPERA.decode_reply(REPLY), 0
    for _ in range(2000):
        garbled = injector.garble(REPLY)
        if garbled.endswith((b"\r", b"\n")) and b"\r" not in garbled[:-2] and b"\n" not in garbled[:-2]:
            try:
                decoded = KHEPERA.decode_reply(garbled)
            except ValueError:
                continue
            undetectable += isinstance(decoded, Reply) and decoded.command == "N" and decoded != original
    assert undetectable > 100
    assert abs(injector.counts.undetectable - undetectable) < 30, (
        "the loop skips replies with a line end in the middle"
    )


def test_truncated_replies_have_all_possible_lengths() -> None:
    injector = make_injector(Faults(reset=1.0))
    lengths = set()
    for _ in range(500):
        truncated = injector.truncate(REPLY)
        assert REPLY.startswith(truncated)
        lengths.add(len(truncated))
    assert lengths == set(range(1, len(REPLY)))


def test_lateness_is_uniform_within_its_limits() -> None:
    injector = make_injector(Faults(delay=1.0, lateness=(0.05, 0.07)))
    times = [injector.lateness() for _ in range(200)]
    assert 0.05 <= min(times) < 0.055 < 0.065 < max(times) <= 0.07
