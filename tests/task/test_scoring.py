"""The score of a recall (5.4): equation 5.1 and its penalties."""

from khepera_forage.task.episode import penalty, score
from khepera_forage.thesis import appendix_a


def test_score_is_equation_5_1_with_the_penalties_of_the_thesis() -> None:
    assert score(0, 0, penalty(0, 1)) == 0.0
    assert score(75, 100, penalty(1, 1)) == 75.0
    assert score(75, 100, penalty(0, 1)) == 55.0
    assert (penalty(0, 2), penalty(1, 2), penalty(2, 2)) == (20.0, 5.0, 0.0)
    assert penalty(0, 0) == 0.0, "poison never counts as uncollected"


def test_score_agrees_with_every_row_of_appendix_a_without_an_error() -> None:
    agreeing = 0
    for row in appendix_a.recalls():
        share = 100 * row.correct / row.total
        if int(share) == row.percent and row.score == row.percent - row.points:
            foods = 1 if row.arena == "corridor" else 2
            delivered = row.delivered(foods)
            assert int(score(row.correct, row.total, penalty(delivered, foods)) + 1e-9) == row.score
            agreeing += 1
    assert agreeing > 80
