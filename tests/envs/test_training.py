"""Training episodes of teacher and learners (4.5, 5.3), on marks, in pools of arenas, and on both backends."""

import math
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from khepera_forage.envs import paired_corridors_v1, paired_corridors_wheels_v1
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies import Listener, Teacher
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.raw_episodes import encoded_motors
from khepera_forage.rollouts.training import IncompleteTrainingError, attempt, train
from khepera_forage.sim.arena import Pose
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour
from tests.arenas import HALL
from tests.version_0_1 import V0_1

QUIET = Noise.none()
on_both_backends = pytest.mark.parametrize("backend", ["pymunk", "compiled"])


def play(env: TrainingEnv, rounds: int = 10_000) -> list[list[int]]:
    """Run teacher and learners; returns what every robot did, round by round."""
    policies: dict[str, Any] = {TEACHER: Teacher.of(env)}
    history = []
    for _ in range(rounds):
        if env.terminations[TEACHER] or env.truncations[TEACHER]:
            break
        actions = []
        for agent in env.possible_agents:
            actions.append(int(policies.get(agent, Listener()).act(env.observe(agent))))
            env.step(actions[-1])
        history.append(actions)
    return history


@pytest.mark.parametrize(
    ("food_type", "learners", "robot"),
    [
        *(("PICKABLE", 1, "khepera"), ("PICKABLE", 3, "khepera"), ("PUSHABLE", 1, "khepera"), ("PUSHABLE", 2, "toio")),
        *(("POISONOUS", 1, "khepera"), ("POISONOUS", 2, "e-puck2")),
    ],
)
@on_both_backends
def test_learners_do_what_they_hear_until_the_episode_is_complete(
    food_type: str, learners: int, robot: str, backend: str
) -> None:
    env = TrainingEnv(num_learners=learners, food_types=food_type, robot=robot, backend=backend, decisions=V0_1)
    shown = {"PICKABLE": Behaviour.GO_HOME, "PUSHABLE": Behaviour.PUSH_FOOD, "POISONOUS": Behaviour.AVOID_FOOD}
    complete = 0
    for seed in range(5):
        env.reset(seed=seed)
        history = play(env)
        assert all(action == row[0] for row in history for action in row)
        complete += env.terminations[TEACHER]
        for agent in env.possible_agents:
            assert env.infos[agent]["poison_home"] == 0
            if env.terminations[TEACHER]:
                assert env.infos[agent]["delivered"] == (food_type != "POISONOUS")
                assert env.observe(agent)[1] > env.home_radius, "complete is outside the home (5.3)"
                assert [shown[food_type]] * len(env.possible_agents) in history
    assert complete >= 3


@pytest.mark.parametrize("food_type", ["PICKABLE", "PUSHABLE", "POISONOUS"])
def test_training_without_noise_is_complete_under_the_defaults(food_type: str) -> None:
    """Distances repeat without noise: a robot could back off food and approach it for ever."""
    env = TrainingEnv(food_types=food_type, noise=QUIET)
    env.reset(seed=0)
    assert len(play(env)) < 200
    assert env.terminations[TEACHER]


def put_learner(env: TrainingEnv, dx: float) -> None:
    """Carry the learner `dx` mm further along its corridor."""
    x, y, heading = env.world.poses()[1]
    env.world.place(1, Pose(x + dx, y, heading))


def test_teacher_waits_while_a_separated_learner_recovers() -> None:
    env = TrainingEnv(noise=QUIET)
    env.reset(seed=0)
    play(env, 3)
    put_learner(env, 5 * Decisions().separation + 30.0)
    play(env, 2)  # noticed at the end of the first, obeyed in the second
    assert env.observe("learner_0")[6] == env.observe(TEACHER)[6] == 1
    before = env.world.poses()
    history = play(env, 2)
    assert history == [[Behaviour.WAIT, Behaviour.WAIT]] * 2
    after = env.world.poses()
    moved = [math.dist(one[:2], other[:2]) for one, other in zip(before, after, strict=True)]
    robots = env.view().robots
    assert [robot.executed for robot in robots] == history[-1]
    assert robots[0].correct not in (None, Behaviour.WAIT)
    assert moved[0] < 2.0, "the teacher rolls out and stands"
    assert moved[1] > 5.0, "the learner moves in an arc"
    assert env.infos["learner_0"]["separated_rounds"] == 4
    assert env.infos["learner_0"]["separations"] == 1


@pytest.mark.parametrize(
    "given",
    [{"patience": 4}, {"decisions": Decisions(patience=4)}, {"patience": 4, "decisions": Decisions(patience=9)}],
)
def test_separation_longer_than_patience_ends_the_attempt(given: dict[str, Any]) -> None:
    env = TrainingEnv(noise=QUIET, **given)
    env.reset(seed=0)
    put_learner(env, 200.0)
    history = play(env)
    assert (env.truncations[TEACHER], env.terminations[TEACHER]) == (True, False)
    assert (env.infos[TEACHER]["complete"], env.infos["learner_0"]["separated_rounds"]) == (0, 4)
    assert len(history) < 8


def test_pause_and_resume_puts_the_learner_beside_the_teacher() -> None:
    env = TrainingEnv(noise=QUIET)
    env.reset(seed=0)
    put_learner(env, 200.0)
    play(env, 30)
    env.resume_beside("learner_0")
    play(env, 1)
    assert env.observe("learner_0")[6] == 0
    teacher, learner = env.world.poses()
    assert learner[0] == pytest.approx(teacher[0], abs=15)
    play(env)
    assert env.terminations[TEACHER], "training continues and is completed"
    with pytest.raises(ValueError, match=r"teacher_0.*learner_0"):
        env.resume_beside(TEACHER)


@pytest.mark.parametrize("resume", [False, True])
def test_resume_goes_on_where_a_separation_would_end_the_attempt(resume: bool) -> None:
    decisions = Decisions(no_food_distance="diagonal of the arena")  # a learner behind the teacher can leave the home
    env, rounds = TrainingEnv(noise=QUIET, patience=4, decisions=decisions), count(1)

    def separate() -> None:
        if next(rounds) == 5:
            put_learner(env, 200.0)

    done = attempt(env, 0, lambda *_: None, resume, separate)
    assert (done.complete, done.resumed, done.separations) == (resume, int(resume), 1)
    assert done.reason == ("" if resume else "separated")


def test_following_corrects_a_learner_whose_wheels_differ() -> None:
    """Without following, which begins at 45 degrees in the second case, it ends further from the teacher's path."""
    apart = []
    for decisions in (Decisions(), Decisions(same_heading=45)):
        env = TrainingEnv(noise=replace(Noise.none(), wheel_bias=0.15), decisions=decisions)
        for seed in range(6):
            env.reset(seed=seed)
            play(env, 20)
            teacher, learner = (forager.raw for forager in env.foragers)
            apart.append(abs(learner.y - teacher.y - 60.0))
    assert sum(apart[:6]) < 0.85 * sum(apart[6:])


# ---------------------------------------------------------------- on given marks


def test_robots_and_food_stand_on_the_given_marks_apart_from_the_placement_error() -> None:
    env, marks = TrainingEnv(num_learners=2, noise=QUIET), {"start": (110, 90, 45), "foods": [(300, 140)]}
    env.reset(seed=1, options=marks)
    for arena, pose, food in zip(env.arenas, env.world.poses(), env.world.food_places(), strict=True):
        home = env.arenas[0].home
        dx, dy = arena.home.x - home.x, arena.home.y - home.y
        assert pose == pytest.approx((110 + dx, 90 + dy, np.pi / 4))
        assert food[:2] == pytest.approx((300 + dx, 140 + dy))
    env = TrainingEnv()
    env.reset(seed=1, options=marks)
    first, second = (np.array(pose[:2]) for pose in env.world.poses())
    assert 0 < np.linalg.norm(first - (110, 90)) < 5 * Noise.laboratory().placement_error
    assert np.abs(second - first - (0, 300)).max() > 1e-3


def test_marks_with_the_gripper_in_a_wall_are_refused_and_the_attempt_goes_on() -> None:
    facing_the_wall = {"start": (60, 100, 180)}
    message = r"placement error of 0 mm.*\(60, 100\) mm has its gripper in a wall"
    env, other = (TrainingEnv(noise=replace(QUIET, wheel_slip=0.1), arena=["corridor", HALL]) for _ in range(2))
    for each in (env, other):
        each.reset(seed=1)
    for seed in (None, 6, 8):  # the last two in the hall
        with pytest.raises(ValueError, match=message):
            env.reset(seed=seed, options=facing_the_wall)
        assert play(env, 2) == play(other, 2)
        assert env.world.poses() == other.world.poses()
        assert env.arenas == other.arenas


# ---------------------------------------------------------------- in several arenas


def test_experience_names_the_arena_of_its_attempt(tmp_path: Path) -> None:
    env, names = TrainingEnv(arena=["corridor", HALL, "rectangle"]), set()
    for seed in range(4):
        path = tmp_path / f"g{seed}.csv"
        try:
            experience, _ = train(env, seed, path=path, attempts=3)
        except IncompleteTrainingError:
            continue
        assert Experience.load(path) == experience
        assert experience.seed is not None
        assert experience.arena == env.arena_of(experience.seed).name == env.arenas[0].name
        names.add(experience.arena)
    assert len(names) > 1


# ---------------------------------------------------------------- on both backends


def test_attempts_begin_alike_on_both_backends_with_corresponding_food() -> None:
    starts, types = [], set()
    for backend in ("pymunk", "compiled"):
        odds = {"PICKABLE": 2, "PUSHABLE": 1, "POISONOUS": 1}
        env = TrainingEnv(arena="t_maze", backend=backend, noise="none", food_types=odds)
        for seed in (4, None, None):
            env.reset(seed=seed)
            one, other = ([int(food.type) for food in forager.food.objects] for forager in env.foragers)
            assert one == other
            types |= set(one)
            starts.append([*(pose[:2] for pose in env.world.poses()), *(food[:2] for food in env.world.food_places())])
    assert np.allclose(starts[:3], starts[3:])
    assert len(types) > 1


@on_both_backends
def test_wheels_that_do_what_the_behaviours_command_train_as_the_behaviours_do(backend: str) -> None:
    """Round by round, bit for bit; learners hear the behaviour that the teacher's motors mean."""
    behaviours = paired_corridors_v1.raw_env(backend=backend)
    wheels = paired_corridors_wheels_v1.raw_env(backend=backend)
    behaviours.reset(seed=3)
    wheels.reset(seed=3)
    while not any((*behaviours.terminations.values(), *behaviours.truncations.values())):
        said = 10 if behaviours.observe("teacher_0")[6] else behaviours.infos["teacher_0"]["correct_behaviour"]
        for i, agent in enumerate(behaviours.agents):
            assert wheels.observe(agent)[-2:].tolist() == behaviours.observe(agent)[5:].tolist()
            action = np.array(encoded_motors(applicable(wheels.foragers[i].motors_for(said))))
            behaviours.step(said)
            wheels.step(action)
        assert wheels.world.poses() == behaviours.world.poses()
        assert wheels.terminations == behaviours.terminations
        assert wheels.truncations == behaviours.truncations
    assert wheels.infos["learner_0"]["delivered"] == behaviours.infos["learner_0"]["delivered"] == 1
