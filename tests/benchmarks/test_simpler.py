"""The best set loses the changes that the tables do not ask for."""

import numpy as np
from decision_search.simpler import TOLERANCE, Judgement, simplify

from khepera_forage import Decisions
from khepera_forage.thesis.inference.prior import PRIOR, possible_decisions


def test_simpler_set_keeps_only_changes_that_the_judge_asks_for() -> None:
    """Here only `next_to_food` matters, and the state at an equal distance may change back only after it has."""
    start = possible_decisions({"next_to_food": 14.4, "equal_distance": "farther state", "aimed": 4.0})

    def judge(decisions: Decisions, number: int) -> Judgement:
        if decisions.equal_distance == "nearer state" and decisions.next_to_food == 14.4:
            return Judgement(np.inf, "the teacher fails in the corridor")
        return Judgement(0.5 + 0.4 * abs(decisions.next_to_food - 14.4), "admissible")

    simpler, trials = simplify(start, 0.5, PRIOR, judge, passes=3)
    assert simpler.differing(Decisions.v0_1()) == {"next_to_food": (14.0, 20.0)}
    tried = {(trial.name, trial.simpler): trial.accepted for trial in trials}
    assert tried[("next_to_food", 20.0)] is False, "not as good by more than the tolerance"
    assert tried[("equal_distance", "nearer state")] is True
    assert all(trial.judgement.misfit <= 0.5 + TOLERANCE for trial in trials if trial.accepted)
