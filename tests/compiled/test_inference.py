"""Simulated laboratories: which are admissible, and what the thesis's tables would be under them."""

from dataclasses import replace

import numpy as np
import pytest

from khepera_forage import Decisions, Noise
from khepera_forage.thesis.inference.prior import LabModel
from khepera_forage.thesis.inference.simulate import reason_against, replicate, simulate
from khepera_forage.thesis.inference.summary import NAMES, SLOPES
from tests.version_0_1 import V0_1

LABORATORY = LabModel(V0_1, Noise.laboratory())


@pytest.mark.parametrize(
    ("decisions", "noise", "reason"),
    [
        (Decisions(), Noise.laboratory(), ""),
        (V0_1, Noise.laboratory(), ""),
        (replace(V0_1, next_to_food=15), Noise.laboratory(), "the teacher fails in the corridor"),
        (replace(V0_1, search_speed=5, home_speed=5, slow_speed=4), Noise.laboratory(), "too slow in the corridor"),
        (replace(V0_1, separation=5, patience=1), Noise(placement_error=20), "training is seldom complete"),
    ],
)
def test_laboratory_is_admissible_or_not_for_a_reason(decisions: Decisions, noise: Noise, reason: str) -> None:
    assert [reason_against(LabModel(decisions, noise), seed) for seed in range(2)] == [reason] * 2


def test_replications_give_the_statistics_of_every_table() -> None:
    statistics = replicate(LABORATORY, 5, 3)
    assert statistics.shape == (3, len(NAMES) + len(SLOPES))
    by_name = dict(zip((*NAMES, *SLOPES), statistics.T, strict=True))
    assert by_name["corridor 1 score"].mean() == pytest.approx(40, abs=12)
    assert by_name["corridor 10 food"].mean() == pytest.approx(0.8, abs=0.2)
    assert np.nanmean(by_name["corridor 1 right_failed"]) < 15
    assert np.array_equal(replicate(LABORATORY, 5, 3), statistics, equal_nan=True)


def test_a_set_depends_on_seed_and_number_alone() -> None:
    one, again, other = (simulate(0, number, 1) for number in (3, 3, 4))
    assert repr(one) == repr(again)
    assert one.laboratory != other.laboratory
