"""`Noise`: its two presets, its sources, and values that are refused."""

import math
from dataclasses import fields, replace
from typing import Any

import pytest

from khepera_forage.noise import SOURCES, Noise

NAMES = [field.name for field in fields(Noise)]
MOST: dict[str, float] = {"proximity_floor": 1023, "position_jitter": 1, "wheel_slip": 1, "wheel_bias": 1}
MOST |= dict.fromkeys(["reversal_rate", "loss_rate_one_hole", "loss_rate_two_holes", "loss_rate_food"], 1)


def test_default_is_the_laboratory_and_none_has_no_noise() -> None:
    assert Noise() == Noise.laboratory()
    quiet = Noise.none()
    for name in (name for names in SOURCES.values() for name in names):
        assert getattr(Noise.laboratory(), name) > getattr(quiet, name)
        assert getattr(quiet, name) == (1 if name == "cable_loss_factor" else 0)


def test_laboratory_noise_agrees_with_the_thesis() -> None:
    noise = Noise.laboratory()
    assert noise.loss_rate_two_holes > noise.loss_rate_one_hole  # 3.5
    assert noise.cable_loss_factor > 1  # 3.7
    assert 0 < noise.reversal_rate < 0.5  # "sometimes", 4.2.2


@pytest.mark.parametrize("source", SOURCES)
def test_only_keeps_one_source(source: str) -> None:
    noise = Noise.only(source)
    for name in NAMES:
        expected = Noise.laboratory() if name in SOURCES[source] else Noise.none()
        assert getattr(noise, name) == getattr(expected, name)


@pytest.mark.parametrize("name", NAMES)
def test_value_that_has_no_meaning_is_refused(name: str) -> None:
    wrong: list[Any] = [-1, -0.001, math.nan, math.inf, "a", None]
    if name in MOST:
        wrong.append(MOST[name] + 0.001)
        replace(Noise.none(), **{name: MOST[name]})
    if name in ("loss_rounds", "cable_loss_factor"):
        wrong.append(0.5)
    for value in wrong:
        with pytest.raises(ValueError, match=rf"{name}.*{value}"):
            replace(Noise.none(), **{name: value})


def test_scaled_noise_has_other_sizes_and_the_same_durations() -> None:
    noise = Noise.laboratory()
    half, double = noise.scaled(0.5), noise.scaled(2)
    assert (half.wheel_slip, double.position_jitter) == (noise.wheel_slip / 2, noise.position_jitter * 2)
    assert (half.proximity_floor, double.proximity_floor) == (3, 12)
    assert half.loss_rate_food == noise.loss_rate_food / 2
    for each in (half, double):
        assert (each.loss_rounds, each.cable_loss_factor) == (noise.loss_rounds, noise.cable_loss_factor)
    assert noise.scaled(1) == noise
    huge = noise.scaled(1e6)
    assert {name: getattr(huge, name) for name in MOST} == MOST
    nothing = noise.scaled(0)
    assert (nothing.loss_rounds, nothing.cable_loss_factor) == (noise.loss_rounds, noise.cable_loss_factor)
    assert replace(nothing, loss_rounds=1, cable_loss_factor=1) == replace(Noise.none(), loss_rounds=1)


@pytest.mark.parametrize("share", [-0.1, math.nan, math.inf, "a"])
def test_share_of_noise_that_is_no_size_is_refused(share: Any) -> None:
    with pytest.raises(ValueError, match=f"share of noise is {share!r}; allowed: a finite number >= 0"):
        Noise.laboratory().scaled(share)
