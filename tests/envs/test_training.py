"""Training episodes of teacher and learners (4.5, 5.3)."""

from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import Listener, Teacher
from khepera_forage.sim.arena import Pose
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, FoodType


def play(env: TrainingEnv, rounds: int = 10_000) -> list[list[int]]:
    """Run teacher and learners; returns what every robot did, round by round."""
    teacher, listener = Teacher.of(env), Listener()
    history = []
    for _ in range(rounds):
        if env.terminations[TEACHER] or env.truncations[TEACHER]:
            break
        actions = []
        for agent in env.possible_agents:
            policy = teacher if agent == TEACHER else listener
            actions.append(int(policy.act(env.observe(agent))))
            env.step(actions[-1])
        history.append(actions)
    return history


@pytest.mark.parametrize("learners", [1, 3])
def test_learners_do_what_they_hear_until_the_episode_is_complete(learners: int) -> None:
    env = TrainingEnv(num_learners=learners, decisions=Decisions.v0_1())
    complete = 0
    for seed in range(5):
        env.reset(seed=seed)
        history = play(env)
        assert all(action == row[0] for row in history for action in row)
        complete += env.terminations[TEACHER]
        if env.terminations[TEACHER]:
            for agent in env.possible_agents:
                assert env.infos[agent]["delivered"] == 1
                assert env.observe(agent)[1] > env.home_radius, "complete is outside the home (5.3)"
    assert complete >= 3


@pytest.mark.parametrize("food_type", ["PUSHABLE", "POISONOUS"])
def test_training_with_other_food_is_completed_without_poison_brought_home(food_type: str) -> None:
    env = TrainingEnv(food_types=food_type, decisions=Decisions.v0_1())
    complete = 0
    for seed in range(4):
        env.reset(seed=seed)
        history = play(env)
        complete += env.terminations[TEACHER]
        wanted = Behaviour.PUSH_FOOD if food_type == "PUSHABLE" else Behaviour.AVOID_FOOD
        assert any(row[0] == wanted for row in history) or not env.terminations[TEACHER]
        assert sum(env.infos[agent]["poison_home"] for agent in env.possible_agents) == 0
    assert complete >= 2


@pytest.mark.parametrize("food_type", ["PICKABLE", "PUSHABLE", "POISONOUS"])
def test_training_without_noise_is_complete_under_the_defaults(food_type: str) -> None:
    """Distances repeat without noise: a robot could back off food and approach it for ever."""
    env = TrainingEnv(food_types=food_type, noise=Noise.none())
    env.reset(seed=0)
    assert len(play(env)) < 200
    assert env.terminations[TEACHER]


def test_corresponding_food_has_one_type() -> None:
    env = TrainingEnv(food_types={"PICKABLE": 1, "PUSHABLE": 1, "POISONOUS": 1})
    seen = set()
    for seed in range(12):
        env.reset(seed=seed)
        play(env)
        known = [forager.tracker.foods[0].known for forager in env.foragers]
        assert known[0] == known[1]
        seen.add(known[0])
    assert seen == {FoodType.PICKABLE, FoodType.PUSHABLE, FoodType.POISONOUS}


def put_learner(env: TrainingEnv, dx: float) -> None:
    """Carry the learner `dx` mm further along its corridor."""
    x, y, heading = env.world.poses()[1]
    env.world.place(1, Pose(x + dx, y, heading))


def test_teacher_waits_while_a_separated_learner_recovers() -> None:
    env = TrainingEnv(noise=Noise.none())
    env.reset(seed=0)
    play(env, 3)
    put_learner(env, 5 * Decisions().separation + 30.0)
    play(env, 2)  # noticed at the end of the first, obeyed in the second
    assert env.observe("learner_0")[6] == env.observe(TEACHER)[6] == 1
    before = env.world.poses()
    history = play(env, 2)
    assert history == [[Behaviour.WAIT, Behaviour.WAIT]] * 2
    after = env.world.poses()
    assert np.hypot(after[0][0] - before[0][0], after[0][1] - before[0][1]) < 2.0, (
        "the teacher rolls out and stands"
    )
    assert np.hypot(after[1][0] - before[1][0], after[1][1] - before[1][1]) > 5.0, (
        "the learner moves in an arc"
    )
    assert env.infos["learner_0"]["separated_rounds"] == 4
    assert env.infos["learner_0"]["separations"] == 1


def test_separation_longer_than_patience_ends_the_attempt() -> None:
    env = TrainingEnv(noise=Noise.none(), patience=4)
    env.reset(seed=0)
    put_learner(env, 200.0)
    history = play(env)
    assert env.truncations[TEACHER]
    assert not env.terminations[TEACHER]
    assert env.infos[TEACHER]["complete"] == 0
    assert len(history) < 8


def test_pause_and_resume_puts_the_learner_beside_the_teacher() -> None:
    env = TrainingEnv(noise=Noise.none())
    env.reset(seed=0)
    put_learner(env, 200.0)
    play(env, 3)
    env.resume_beside("learner_0")
    play(env, 1)
    assert env.observe("learner_0")[6] == 0
    teacher, learner = env.world.poses()
    assert learner[0] == pytest.approx(teacher[0], abs=15)
    play(env)
    assert env.terminations[TEACHER], "training continues and is completed"
    with pytest.raises(ValueError, match=r"teacher_0.*learner_0"):
        env.resume_beside(TEACHER)


def test_following_corrects_a_learner_whose_wheels_differ() -> None:
    """Without following, a learner with one slow wheel ends further from the teacher's path."""
    unequal = replace(Noise.none(), wheel_bias=0.04)
    apart = []
    for seed in range(6):
        env = TrainingEnv(noise=unequal)
        env.reset(seed=seed)
        play(env, 20)
        teacher, learner = (forager.raw for forager in env.foragers)
        apart.append(abs(learner.y - teacher.y - 60.0))
    assert np.median(apart) < 4.0
