"""The teacher decides by the tree of figure 4.2, and waits for a separated learner."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.policies import Teacher
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, FoodType, StateVector, behaviour_for, classify

VECTORS = st.builds(
    StateVector,
    st.integers(0, 1),
    st.integers(0, 200),
    st.sampled_from([int(food_type) for food_type in FoodType]),
    st.integers(215, 255),
    st.integers(0, 200),
)


@settings(deadline=None)
@given(VECTORS, st.integers(1, 60), st.sampled_from(list(Behaviour)))
def test_teacher_follows_the_tree_of_figure_4_2(vector: StateVector, radius: int, heard: int) -> None:
    teacher = Teacher(home_radius=radius)
    decision = behaviour_for(classify(vector, radius, Decisions().values()))
    shown = {name: np.int64(value) for name, value in vector._asdict().items()}
    assert teacher.act(shown) is decision
    assert teacher.act(list(vector)) is decision
    assert teacher.act(np.array([*vector, heard, 0], np.int32)) is decision
    assert teacher.act(np.array([*vector, heard, 1], np.int32)) is Behaviour.WAIT


def test_teacher_of_no_environment_decides_nothing() -> None:
    with pytest.raises(ValueError, match=r"Teacher\(\) knows no environment; allowed: Teacher.of\(env\)"):
        Teacher().act((0, 90, 0, 215, 60))


@pytest.mark.parametrize("radius", [0, -3, float("nan")])
def test_home_radius_not_above_0_is_refused(radius: int) -> None:
    with pytest.raises(ValueError, match=f"home_radius is {radius} pixels; allowed: above 0"):
        Teacher(home_radius=radius)
