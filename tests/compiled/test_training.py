"""Training in compiled pairs: the rounds of one environment, the experience of `train_learners`, results and errors."""

from typing import Any

import numba
import numpy as np
import pytest

from khepera_forage.envs import paired_corridors_v1
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.rollouts.compiled import training
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour
from tests.compiled.decisions import DECISIONS
from tests.version_0_1 import V0_1

WAIT = int(Behaviour.WAIT)
MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
ROUGH = Noise(placement_error=15.0, placement_heading_error=20.0, wheel_bias=0.1, wheel_slip=0.2)
"""Robots so bad that learners often get separated."""
TIMES = Decisions(round_duration=0.2, arm_travel_time=0.5, home_speed=10, following_gain=0.2, close_to_food=35)

# ---------------------------------------------------------------- the same training everywhere


@pytest.mark.parametrize(
    "given",
    [
        {"food_types": "poisonous"},
        {"num_learners": 2, "arena": "rectangle", "food_types": "pickable"},
        {"patience": 4},
        {"decisions": TIMES, "food_types": "pushable"},
        *({"decisions": decisions} for decisions in DECISIONS[1:]),
    ],
    ids=lambda given: "-".join(given),
)
def test_pairs_without_noise_are_those_of_one_environment_round_by_round(given: dict[str, Any]) -> None:
    """Now and then a robot does something else for some rounds, so that learners get separated and are led back."""
    given = {"noise": "none", "max_cycles": 300} | given
    many = paired_corridors_v1.vector_env(2, **given)
    one = paired_corridors_v1.parallel_env(backend="compiled", **given)
    assert many.possible_agents == one.possible_agents
    assert all(many.action_space(agent) == one.action_space(agent) for agent in one.possible_agents)
    apart, outcomes = 0, set()
    for seed, odds in enumerate((0.0, 0.1, 0.3)):
        rng, odd = np.random.default_rng(seed), dict[str, int]()
        (rows, counts), (shown, infos) = many.reset(seed=seed), one.reset(seed=seed)
        while one.agents:
            if infos["teacher_0"]["steps"] % 16 == 0:
                odd = {agent: int(rng.integers(11)) for agent in one.agents if rng.random() < odds}
            said = WAIT if shown["teacher_0"][6] else infos["teacher_0"]["correct_behaviour"]
            actions = {agent: odd.get(agent, said) for agent in one.agents}
            rows, gained, complete, cut, counts = many.step(
                {agent: np.full(2, action) for agent, action in actions.items()}
            )
            shown, rewards, ends, cuts, infos = one.step(actions)
            assert complete["teacher_0"] is not complete["learner_0"], "each agent has an array of its own"
            for agent in rewards:
                assert rows[agent][0].tolist() == shown[agent].tolist()
                assert rows[agent][0] in one.observation_space(agent)
                own = {name: values[0] for name, values in counts[agent].items()}
                assert own == pytest.approx({name: infos[agent][name] for name in own}, abs=1e-9)
                assert gained[agent][0] == pytest.approx(rewards[agent])
                assert (complete[agent][0], cut[agent][0]) == (ends[agent], cuts[agent])
            assert many.state().tolist() == [one.state().tolist()] * 2
        apart += infos["learner_0"]["separations"]
        outcomes.add(ends["teacher_0"])
    assert apart > 0
    if "decisions" not in given:  # under others, three attempts may all fail
        assert any(outcomes)
    if "patience" in given:
        assert not all(outcomes)


def test_attempts_of_pairs_are_those_of_train_learners_up_to_the_first_complete_one() -> None:
    """The teacher waits for its learners, which do at once what they hear; nothing is recorded in silence (5.2)."""
    given: dict[str, Any] = {"noise": ROUGH, "food_types": MIXED, "decisions": V0_1, "patience": 3}
    pairs = 24
    attempts: list[list[Any]] = [[] for _ in range(pairs)]
    envs = paired_corridors_v1.vector_env(pairs, **given)
    observations, infos = envs.reset(seed=5)
    rows: list[list[Any]] = [[] for _ in range(pairs)]
    rewards, waiting = np.zeros(pairs), np.zeros(pairs, np.bool_)
    kept: dict[int, Any] = {}
    while len(kept) < pairs:
        said = np.where(observations["teacher_0"][:, 6] == 1, WAIT, infos["teacher_0"]["correct_behaviour"])
        seen = observations["learner_0"]
        observations, gained, complete, truncated, infos = envs.step(dict.fromkeys(observations, said))
        for i, shouted in enumerate(said):
            if waiting[i]:
                rows[i], rewards[i] = [], 0.0
                assert not gained["learner_0"][i]
                assert not infos["learner_0"]["steps"][i]
            else:
                rows[i] += [(*seen[i, :5], shouted)] if shouted != WAIT else []
                rewards[i] += gained["learner_0"][i]
            if i not in kept and (complete["learner_0"][i] or truncated["learner_0"][i]):
                steps, apart = (int(infos["learner_0"][name][i]) for name in ("steps", "separations"))
                reason = "" if complete["learner_0"][i] else "separated" if steps < 600 else "out of time"
                attempts[i].append((i, 0, len(attempts[i]) + 1, not reason, steps, len(rows[i]), apart, reason))
            if complete["learner_0"][i]:
                kept.setdefault(i, (rows[i], rewards[i]))
        waiting = complete["teacher_0"] | truncated["teacher_0"]
    trained = train_learners(pairs, seed=5, **given)
    for i, (vectors, reward) in kept.items():
        np.testing.assert_array_equal(vectors, trained.vectors_of(i))
        assert reward == pytest.approx(float(trained.rewards_of(i).sum()), abs=1e-4)
    done = zip(*(column.tolist() for column in trained.attempts), strict=True)
    assert sorted(done) == sorted(row for own in attempts for row in own)
    assert {reason for own in attempts for *_, reason in own} == {"", "separated", "out of time"}
    assert max(map(len, attempts)) > 2


# ---------------------------------------------------------------- results of train_learners


def test_a_learner_does_not_depend_on_the_number_of_learners(monkeypatch: pytest.MonkeyPatch) -> None:
    many = train_learners(300, seed=5, noise=ROUGH, food_types=MIXED, episodes=2)
    threads = numba.get_num_threads()
    monkeypatch.setattr(training, "_ROOM", 1)  # one block of episodes at a time
    numba.set_num_threads(1)
    few = train_learners(40, seed=5, noise=ROUGH, food_types=MIXED, episodes=5)
    numba.set_num_threads(threads)
    for learner in range(40):
        for episode in range(2):
            assert (many.vectors_of(learner, episode) == few.vectors_of(learner, episode)).all()
    for name in ("complete", "rounds", "vectors", "separations", "reason"):
        of_many = getattr(many.attempts, name)[many.attempts.learner < 40]
        of_few = getattr(few.attempts, name)[few.attempts.episode < 2]
        assert (of_many == of_few).all()


def test_experience_of_a_learner_can_be_saved_and_loaded_and_a_missing_one_is_quoted(tmp_path: Any) -> None:
    trained = train_learners(2, seed=3, episodes=2)
    whole = trained.experience_of(1)
    assert whole.episodes == 2
    first, second = (trained.experience_of(1, episode) for episode in range(2))
    assert first + second == whole
    whole.save(tmp_path / "g1.csv")
    assert Experience.load(tmp_path / "g1.csv") == whole
    with pytest.raises(ValueError, match="learner is 2; allowed: 0 to 1"):
        trained.vectors_of(2)
    with pytest.raises(ValueError, match="episode is -1; allowed: 0 to 1"):
        trained.vectors_of(0, -1)
