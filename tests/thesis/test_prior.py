"""The prior of decisions: its ranges, its draws, and its errors."""

import numpy as np
import pytest

from khepera_forage import Noise
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.thesis.inference.prior import PRIOR, Prior, PriorRange, Shares


def test_draws_cover_their_ranges_and_everything_else_keeps_its_default() -> None:
    rng = np.random.default_rng(0)
    sets = [PRIOR.draw(rng) for _ in range(300)]
    for name, part in PRIOR.parts.items():
        values = [getattr(noise if name in PRIOR.noise else decisions, name) for decisions, noise in sets]
        if isinstance(part, PriorRange):
            assert part.least <= min(values) <= max(values) <= part.most
            assert max(values) - min(values) > 0.7 * (part.most - part.least), name
        else:
            assert set(values) == set(part.of), name
    for decisions, noise in sets:
        assert set(decisions.changed()) <= set(PRIOR.decisions)
        for name in ("wheel_slip", "reversal_rate", "loss_rate_food"):
            assert getattr(noise, name) == getattr(Noise.laboratory(), name)
        for arena in ("corridor", "rectangle"):
            checked_arena(arena, decisions)
        assert decisions.slow_speed <= decisions.search_speed
        assert decisions.next_to_food <= decisions.close_to_food


def test_readings_are_drawn_with_their_shares() -> None:
    prior = Prior({"arm_after_orienting": Shares({"raised": 0.25, "as it is": 0.75}, "a test")}, {})
    rng = np.random.default_rng(0)
    drawn = [prior.draw(rng).decisions.arm_after_orienting for _ in range(2000)]
    assert drawn.count("as it is") / 2000 == pytest.approx(0.75, abs=0.04)


def test_a_prior_without_any_allowed_set_is_refused() -> None:
    prior = Prior({"close_to_food": PriorRange(12, 13, "a test")}, {})
    with pytest.raises(ValueError, match=r"none of 1,000 sets .*; the last one: decision close_to_food is 12\."):
        prior.draw(np.random.default_rng(0))
