"""Paired corridors by the thousand: the attempts of `train_learners`, step by step."""

from typing import Any

import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from khepera_forage.envs import paired_corridors_v1
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.task.states import Behaviour

WAIT = int(Behaviour.WAIT)


def as_taught(observations: Any, infos: Any) -> Any:
    """The teacher waits for its learners, which do at once what they hear."""
    separated = observations["teacher_0"][:, 6] == 1
    return dict.fromkeys(observations, np.where(separated, WAIT, infos["teacher_0"]["correct_behaviour"]))


def test_first_complete_attempts_are_those_of_train_learners() -> None:
    pairs = 24
    envs = paired_corridors_v1.vector_env(pairs)
    observations, infos = envs.reset(seed=5)
    rows: list[list[Any]] = [[] for _ in range(pairs)]
    rewards, waiting = np.zeros(pairs), np.zeros(pairs, np.bool_)
    kept: dict[int, Any] = {}
    while len(kept) < pairs:
        actions, seen = as_taught(observations, infos), observations["learner_0"]
        observations, gained, complete, truncated, infos = envs.step(actions)
        for i, shouted in enumerate(actions["teacher_0"]):
            if waiting[i]:
                rows[i], rewards[i] = [], 0.0
                assert not gained["learner_0"][i]
                assert not infos["learner_0"]["steps"][i]
            else:
                rows[i] += [(*seen[i, :5], shouted)] if shouted != WAIT else []
                rewards[i] += gained["learner_0"][i]
            if complete["learner_0"][i]:
                kept.setdefault(i, (rows[i], rewards[i]))
        waiting = complete["teacher_0"] | truncated["teacher_0"]
    trained = train_learners(pairs, seed=5)
    for i, (vectors, reward) in kept.items():
        np.testing.assert_array_equal(vectors, trained.vectors_of(i))
        assert reward == pytest.approx(float(trained.rewards_of(i).sum()), abs=1e-4)


def test_it_has_the_spaces_and_states_of_parallel_env_and_repeats_itself() -> None:
    envs, one = (
        make(num_learners=2, arena="rectangle")
        for make in (
            lambda **settings: paired_corridors_v1.vector_env(3, **settings),
            paired_corridors_v1.parallel_env,
        )
    )
    assert envs.possible_agents == one.possible_agents
    films: list[Any] = []
    for _ in range(2):
        observations, _ = envs.reset(seed=1)
        film, rng = [], np.random.default_rng(0)
        for _ in range(50):
            actions = {agent: rng.integers(10, size=3) for agent in envs.possible_agents}
            observations, *_ = envs.step(actions)
            for agent in envs.possible_agents:
                assert envs.action_space(agent) == one.action_space(agent)
                assert all(row in one.observation_space(agent) for row in observations[agent])
            assert (observations["learner_1"][:, 5] == actions["teacher_0"]).all()
            film.append(envs.state())
        films.append(film)
    assert envs.state().shape == (3, 3 * 7)
    np.testing.assert_array_equal(films[0], films[1])


@pytest.mark.parametrize("actions", [{}, {"teacher_0": [0, 1], "learner_0": [0, 11]}, {"teacher_0": [0, 1]}])
def test_wrong_actions_change_nothing(actions: Any) -> None:
    envs = paired_corridors_v1.vector_env(2)
    with pytest.raises(ResetNeeded):
        envs.step(actions)
    envs.reset(seed=1)
    before = envs.state()
    with pytest.raises(ValueError, match="allowed"):
        envs.step(actions)
    np.testing.assert_array_equal(before, envs.state())
