"""The sizes of the troubles."""

from dataclasses import FrozenInstanceError, fields, replace
from typing import Any

import pytest

from khepera_forage.noise import SOURCES, Noise

NAMES = [field.name for field in fields(Noise)]
RATES = ["reversal_rate", "loss_rate_one_hole", "loss_rate_two_holes", "loss_rate_food"]


def test_the_laboratory_is_the_default_and_none_is_quiet() -> None:
    assert Noise() == Noise.laboratory()
    quiet = Noise.none()
    for name in (name for names in SOURCES.values() for name in names):
        assert getattr(Noise.laboratory(), name) > getattr(quiet, name)
        assert getattr(quiet, name) == (1 if name == "cable_loss_factor" else 0)


def test_what_the_thesis_says_of_the_sizes() -> None:
    noise = Noise.laboratory()
    assert noise.loss_rate_two_holes > noise.loss_rate_one_hole  # 3.5
    assert noise.cable_loss_factor > 1  # 3.7
    assert 0 < noise.reversal_rate < 0.5  # "sometimes", 4.2.2


def test_every_field_belongs_to_one_source_or_shapes_one() -> None:
    listed = [name for names in SOURCES.values() for name in names]
    assert len(listed) == len(set(listed))
    assert set(NAMES) - set(listed) == {"loss_rounds"}  # how long a loss lasts, if there is one


@pytest.mark.parametrize("source", SOURCES)
def test_only_one_source(source: str) -> None:
    noise = Noise.only(source)
    for name in NAMES:
        expected = Noise.laboratory() if name in SOURCES[source] else Noise.none()
        assert getattr(noise, name) == getattr(expected, name)


def test_all_sources_are_the_laboratory_and_no_source_is_none() -> None:
    assert Noise.only(*SOURCES) == Noise.laboratory()
    assert Noise.only() == Noise.none()


def test_an_unknown_source_is_refused_with_its_name() -> None:
    with pytest.raises(ValueError, match=r"'wind'.*wheels"):
        Noise.only("wheels", "wind")


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [-1, -0.001, float("nan"), float("inf")])
def test_sizes_are_finite_and_not_negative(name: str, value: float) -> None:
    change: dict[str, Any] = {name: value}
    with pytest.raises(ValueError, match=rf"{name}.*{value}"):
        replace(Noise.none(), **change)


@pytest.mark.parametrize("name", RATES)
def test_rates_are_probabilities(name: str) -> None:
    certain: dict[str, Any] = {name: 1.0}
    replace(Noise.none(), **certain)
    beyond: dict[str, Any] = {name: 1.001}
    with pytest.raises(ValueError, match=rf"{name}.*1\.001"):
        replace(Noise.none(), **beyond)


@pytest.mark.parametrize("name", ["loss_rounds", "cable_loss_factor"])
def test_some_sizes_are_at_least_one(name: str) -> None:
    change: dict[str, Any] = {name: 0.5}
    with pytest.raises(ValueError, match=rf"{name}.*0\.5"):
        replace(Noise.none(), **change)


def test_sizes_cannot_be_changed() -> None:
    with pytest.raises(FrozenInstanceError):
        Noise.none().wheel_slip = 1.0  # type: ignore[misc]
