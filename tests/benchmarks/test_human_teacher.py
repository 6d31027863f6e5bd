"""The simulated person of `benchmarks/further_experiments/human_teacher.py`: its delay and its wrong keys."""

import numpy as np
import pytest
from further_experiments.human_teacher import SimulatedPerson

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.policies import Teacher
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import V0_1

FAR, CLOSE, NEXT = (0, 90, 0, 215, 60), (0, 90, 0, 215, 25), (0, 90, 0, 215, 20)
SEARCH, SLOWLY, ORIENT = (
    Behaviour.SEARCH_FOR_FOOD,
    Behaviour.MOVE_SLOWLY,
    Behaviour.ORIENT_WITH_FOOD,
)


@pytest.fixture
def env() -> TrainingEnv:
    env = TrainingEnv(decisions=V0_1)
    env.reset(seed=1)
    return env


def seen(vector: tuple[int, ...], separated: int = 0) -> list[int]:
    return [*vector, Behaviour.WAIT, separated]


def test_every_key_but_the_first_is_late(env: TrainingEnv) -> None:
    draws = np.random.default_rng(0)
    person = SimulatedPerson(env, delay=2, wrong=0.0)
    for attempt in range(2):
        keys = []
        for step, vector in enumerate((CLOSE if attempt else FAR, CLOSE, NEXT, NEXT, NEXT, FAR)):
            env.infos[TEACHER]["steps"] = step
            keys.append(person.act(seen(vector), draws))
        first = SLOWLY if attempt else SEARCH
        assert keys == [first, first, first, SLOWLY, ORIENT, ORIENT]


def test_without_faults_it_is_the_teacher(env: TrainingEnv) -> None:
    draws, person = np.random.default_rng(0), SimulatedPerson(env, delay=0, wrong=0.0)
    for vector in (FAR, CLOSE, NEXT, FAR):
        for separated in (0, 1):
            assert person.act(seen(vector, separated), draws) == Teacher.of(env).act(seen(vector, separated))


def test_wrong_keys_have_the_given_rate_and_equal_odds(env: TrainingEnv) -> None:
    draws, person = np.random.default_rng(0), SimulatedPerson(env, delay=0, wrong=0.2)
    keys = [person.act(seen(FAR), draws) for _ in range(5000)]
    counts = np.bincount(keys, minlength=10)
    assert len(counts) == 10, "WAIT is never pressed"
    assert abs(counts[SEARCH] - 4000) < 6 * np.sqrt(5000 * 0.2 * 0.8)
    assert np.all(np.abs(counts[1:] - 1000 / 9) < 6 * np.sqrt(1000 / 9))


def test_it_needs_a_generator(env: TrainingEnv) -> None:
    with pytest.raises(TypeError, match="rng is None"):
        SimulatedPerson(env, 0, 0.0).act(seen(FAR))
