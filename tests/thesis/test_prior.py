"""The prior of decisions: its ranges, its draws, and its errors."""

from collections import Counter

import numpy as np
import pytest

from khepera_forage import Decisions, Noise
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.thesis.inference.prior import PRIOR, Prior, Range, Shares

SOME = Shares({"raised": 0.25, "as it is": 0.75}, "a test")


def drawn(prior: Prior = PRIOR, count: int = 300) -> list[tuple[Decisions, Noise]]:
    rng = np.random.default_rng(0)
    return [prior.draw(rng) for _ in range(count)]


def test_draws_are_within_their_ranges_and_cover_them() -> None:
    sets = drawn()
    for name, part in (*PRIOR.decisions.items(), *PRIOR.noise.items()):
        values = [getattr(noise if name in PRIOR.noise else decisions, name) for decisions, noise in sets]
        if isinstance(part, Range):
            assert part.least <= min(values) <= max(values) <= part.most
            assert max(values) - min(values) > 0.7 * (part.most - part.least), name
        else:
            assert set(values) == set(part.of), name


def test_everything_else_keeps_its_default() -> None:
    for decisions, noise in drawn(count=20):
        assert set(decisions.changed()) <= set(PRIOR.decisions)
        for name in ("wheel_slip", "reversal_rate", "loss_rate_food"):
            assert getattr(noise, name) == getattr(Noise.laboratory(), name)


def test_draws_fit_both_arenas_and_move_slowly_is_no_faster_than_search() -> None:
    for decisions, _ in drawn():
        for arena in ("corridor", "rectangle"):
            checked_arena(arena, decisions)
        assert decisions.slow_speed <= decisions.search_speed
        assert decisions.next_to_food <= decisions.close_to_food


def test_readings_are_drawn_with_their_shares() -> None:
    prior = Prior({"arm_after_orienting": SOME}, {})
    counts = Counter(decisions.arm_after_orienting for decisions, _ in drawn(prior, 2000))
    assert counts["as it is"] / 2000 == pytest.approx(0.75, abs=0.04)


def test_every_part_of_the_prior_names_its_source() -> None:
    for part in (*PRIOR.decisions.values(), *PRIOR.noise.values()):
        assert len(part.source) > 5


def test_same_generator_gives_the_same_laboratories() -> None:
    assert drawn(count=5) == drawn(count=5)


@pytest.mark.parametrize(
    ("decisions", "noise", "message"),
    [
        (
            {"next_to_foot": Range(1, 2, "")},
            {},
            "prior of 'next_to_foot'; allowed: fields of Decisions or Noise",
        ),
        (
            {"next_to_food": Range(20, 15, "")},
            {},
            "next_to_food is 20 to 15; allowed: from small to large, 10 to 30",
        ),
        (
            {"next_to_food": Range(5, 15, "")},
            {},
            "next_to_food is 5 to 15; allowed: from small to large, 10 to 30",
        ),
        (
            {},
            {"wheel_slip": Range(-1, 0, "")},
            "wheel_slip is -1 to 0; allowed: from small to large, 0 to inf",
        ),
        (
            {"arm_after_orienting": Shares({"raised": 0.5}, "")},
            {},
            "arm_after_orienting is {'raised': 0.5}; allowed: probabilities of 'raised', 'as it is', 1 together",
        ),
        ({"arm_after_orienting": Shares({"lost": 1.0}, "")}, {}, "arm_after_orienting is {'lost': 1.0}"),
        ({"recall_marker": Shares({3: 1.0}, "")}, {}, "recall_marker is {3: 1.0}"),
    ],
)
def test_wrong_prior_is_an_error(
    decisions: dict[str, object], noise: dict[str, object], message: str
) -> None:
    with pytest.raises(ValueError) as error:  # noqa: PT011 (the message is compared below)
        Prior(decisions, noise)  # type: ignore[arg-type]
    assert message in str(error.value)


def test_prior_that_no_set_satisfies_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("khepera_forage.thesis.inference.prior._TRIES", 50)
    prior = Prior({"home_radius": Range(110, 110, ""), "home_to_wall": Range(60, 70, "")}, {})
    with pytest.raises(
        ValueError, match=r"none of 50 draws of this prior is possible; the last one: decision home"
    ):
        prior.draw(np.random.default_rng(0))
