"""Teacher and learner beside each other: separation, silence, how the learner is led, and when an attempt ends."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.arena import copies
from khepera_forage.task.decisions import DEFAULT_VALUES, Decisions
from khepera_forage.task.pairing import (
    Pairing,
    attempt_ends,
    follow,
    is_complete,
    lead,
    recover,
    rounds_since_done,
    teacher_says,
    update_pairing,
)
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import CORRIDOR

TEACHER_ARENA, ARENA = (arena_map_of(arena) for arena in copies(CORRIDOR, 2))
OFFSET = ARENA.home_y - TEACHER_ARENA.home_y
AHEAD = Motors(8.0, 8.0, 215, 200)
PLACE = st.floats(0.0, 130.0)
DEGREES = st.integers(0, 359)


def update(pairing: Pairing, apart: float, decisions: Decisions | None = None) -> None:
    """A round after which the learner is so far from the teacher's place in its own arena, in pixels."""
    values = (Decisions() if decisions is None else decisions).values()
    update_pairing(pairing, 50.0 + apart, 20.0 + OFFSET, ARENA, 50.0, 20.0, 30.0, TEACHER_ARENA, values)


def test_teacher_is_moved_into_the_learners_arena() -> None:
    pairing = Pairing()
    update(pairing, 5.0)
    assert (pairing.teacher_x, pairing.teacher_y, pairing.teacher_orientation) == (50.0, 20.0 + OFFSET, 30.0)
    assert not pairing.separated


def test_pairing_counts_separations_and_their_rounds() -> None:
    pairing = Pairing()
    history = []
    for apart in (5.0, 14.0, 14.1, 20.0, 13.0, 30.0):
        update(pairing, apart)
        history.append((pairing.separated, pairing.separated_rounds, pairing.separations))
    assert history == [
        (False, 0, 0),
        (False, 0, 0),
        (True, 1, 1),
        (True, 2, 1),
        (False, 0, 1),
        (True, 1, 2),
    ]


def test_pairing_separates_at_the_distance_of_the_decisions() -> None:
    pairing = Pairing()
    update(pairing, 14.1, Decisions(separation=15.0))
    assert not pairing.separated


@pytest.mark.parametrize("state", range(10))
def test_teacher_says_its_behaviour_and_nothing_while_a_learner_is_separated(state: int) -> None:
    assert teacher_says(state, False) == state
    assert teacher_says(state, True) == Behaviour.WAIT


@given(x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES, separated=st.booleans())
def test_lead_recovers_when_a_separated_learner_waits_and_follows_otherwise(
    x: float, y: float, heading: int, tx: float, ty: float, teachers: int, separated: bool
) -> None:
    pairing = Pairing(separated=separated, teacher_x=tx, teacher_y=ty, teacher_orientation=teachers)
    still = Motors(0.0, 0.0, 255, 0)
    following = follow(AHEAD, x, y, heading, tx, ty, teachers, DEFAULT_VALUES)
    assert lead(pairing, AHEAD, Behaviour.SEARCH_FOR_FOOD, x, y, heading, DEFAULT_VALUES) == following
    waiting = lead(pairing, still, Behaviour.WAIT, x, y, heading, DEFAULT_VALUES)
    assert waiting == (recover(still, x, y, heading, tx, ty, DEFAULT_VALUES) if separated else still)


@pytest.mark.parametrize(
    ("complete", "rounds", "separated_rounds", "over"),
    [
        (False, 0, 0, False),
        (False, 599, 99, False),
        (True, 10, 0, True),
        (False, 600, 0, True),
        (False, 10, 100, True),
        (True, 600, 100, True),
    ],
)
def test_attempt_ends_when_it_is_complete_out_of_time_or_separated_for_too_long(
    complete: bool, rounds: int, separated_rounds: int, over: bool
) -> None:
    assert attempt_ends(complete, rounds, 600, separated_rounds, 100) is over


def test_training_is_complete_some_rounds_after_the_robots_have_done_their_part() -> None:
    for rounds in (0, 3):
        decisions = Decisions(rounds_after_training=rounds).values()
        since, complete = 0, []
        for done in (False, True, False, False, True, True):
            since = rounds_since_done(since, done)
            complete.append(is_complete(since, decisions))
        assert complete == [number > rounds for number in range(6)]
