"""Recalls wholly in the kernel: the imitator there is the imitator, and the account is that of `recall`."""

from typing import Any

import numba
import numpy as np
import pytest
from scipy import stats

from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.vector_envs import BehavioursVectorEnv
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.nearest_neighbour.memories import memories_of
from khepera_forage.rollouts.compiled.recalls import TEACHER, UNIFORM, Episodes, run_recalls, run_teacher
from khepera_forage.rollouts.rows import RecallRow
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.numbers import upper, word
from khepera_forage.task.states import CLOSE_TO_FOOD, Behaviour

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
RECTANGLE: dict[str, Any] = {"foods": 2, "limit": 150, "food_types": MIXED}


class Given:
    """A generator whose next number is known."""

    def __init__(self, chance: float) -> None:
        self.chance = chance

    def random(self) -> float:
        return self.chance


@pytest.fixture(scope="module")
def experience() -> list[tuple[Any, Any]]:
    """Three memories of the teacher's forages in the rectangle, one to three of them, now and then noted wrong."""
    env: Any = BehavioursVectorEnv(8, "rectangle", 2, 300, food_types=MIXED)
    observation, infos = env.reset(seed=11)
    rng = np.random.default_rng(0)
    vectors: list[Any] = [[] for _ in range(3)]
    heard: list[Any] = [[] for _ in range(3)]
    for _ in range(250):
        rows = np.column_stack([np.asarray(v).reshape(8, -1) for v in _columns(observation)])
        behaviours = infos["correct_behaviour"]
        noted = np.where(rng.random(8) < 0.1, rng.integers(0, 10, 8), behaviours)
        for world, memory in enumerate((0, 1, 1, 2, 2, 2)):
            vectors[memory].append(rows[world])
            heard[memory].append(noted[world])
        observation, _, _, _, infos = env.step(behaviours)
    return [(np.array(v), np.array(h)) for v, h in zip(vectors, heard, strict=True)]


def _columns(observation: Any) -> list[Any]:
    names = ("object_presence", "robot_home_distance", "food_type", "arms_height", "robot_food_distance")
    return [observation[name] for name in names]


def test_an_episode_is_that_of_the_imitator_playing_step_by_step(experience: Any) -> None:
    """The environment stepped from Python, the imitator drawing with the kernel's numbers: the same counts."""
    worlds, seed = 30, 4
    which = np.arange(worlds) % 3
    kernel = run_recalls("rectangle", memories_of(experience), which, seed, **RECTANGLE)
    env: Any = BehavioursVectorEnv(worlds, "rectangle", **RECTANGLE)
    batch = env.batch
    imitators = [NearestNeighbourImitator(batch.diagonal).fit(*part) for part in experience]
    observation, infos = env.reset(seed=seed)
    over = np.zeros(worlds, np.bool_)
    rounds, wrong = np.zeros((2, worlds, 10), np.int64)
    ghosts, ties, conflicts = np.zeros((3, worlds), np.int64)
    while not over.all():
        keys = batch.worlds.bodies.keys.reshape(body.KEY_ROWS, -1)
        numbers = keys[body.ROUND] * np.uint64(body.DRAWS) + np.uint64(body.DRAW_POLICY)
        bits: Any = word(keys[body.KEY], numbers)
        chances = np.array(upper(bits))
        actions = np.zeros(worlds, np.int64)
        rows = np.column_stack([np.asarray(v).reshape(worlds, -1) for v in _columns(observation)])
        for i in np.flatnonzero(~over).tolist():
            neighbours = imitators[which[i]].neighbours(rows[i])
            rng: Any = Given(chances[i])
            actions[i] = neighbours.draw(rng)
            right = infos["correct_behaviour"][i]
            rounds[i, right] += 1
            ties[i] += neighbours.tie
            conflicts[i] += neighbours.conflict
            if actions[i] != right:
                wrong[i, right] += 1
                far = batch.task(at.FOOD_DISTANCE)[i] > CLOSE_TO_FOOD
                ghosts[i] += actions[i] == Behaviour.ORIENT_WITH_FOOD and far
        observation, _, terminated, truncated, infos = env.step(actions)
        for i in np.flatnonzero((terminated | truncated) & ~over).tolist():
            over[i] = True
            for name in ("score", "penalty", "steps", "correct", "delivered", "poison_home"):
                assert infos[name][i] == getattr(kernel, name)[i], name
    assert (rounds == kernel.rounds_by_state).all()
    assert (wrong == kernel.wrong_by_state).all()
    for name, counts in (("orient_ghost", ghosts), ("ties", ties), ("conflicts", conflicts)):
        assert (counts == getattr(kernel, name)).all(), name
        assert counts.any(), name
    assert kernel.delivered.any()


def test_starts_and_foods_are_those_of_the_worlds() -> None:
    env = BehavioursVectorEnv(12, "rectangle", 2)
    env.reset(seed=9)
    kernel = run_recalls("rectangle", None, np.full(12, TEACHER), 9, foods=2, limit=1)
    food = env.batch.worlds.bodies.food.reshape(2, body.FOOD_ROWS, -1)[:, :2, :12]
    assert (food.transpose(2, 0, 1) == kernel.foods).all()
    robots = env.batch.worlds.bodies.robots.reshape(body.ROBOT_ROWS, -1)[:, :12]
    # One round at rest has passed, in which nothing moves.
    for column, row in enumerate((body.X, body.Y, body.HEADING)):
        assert robots[row] == pytest.approx(kernel.start[:, column], abs=1e-9)


def test_every_episode_makes_a_row(experience: Any) -> None:
    """`RecallRow` refuses fields that contradict each other."""
    which = np.arange(400) % 5 - 2
    kernel = run_recalls("rectangle", memories_of(experience), which, **RECTANGLE)
    for i in range(400):
        _row(kernel, i)
    assert (kernel.deliverable <= 2).all()
    assert (kernel.deliverable < 2).any()
    assert kernel.poison_home.any()
    assert (kernel.food_delivered.sum(axis=1) == kernel.delivered).all()


def _row(kernel: Episodes, i: int) -> RecallRow:
    return RecallRow(
        replication=0,
        arena="rectangle",
        episodes=1,
        file_id="g1",
        recall=i,
        seed=0,
        learner="imitator",
        noise="laboratory",
        correct=int(kernel.correct[i]),
        steps=int(kernel.steps[i]),
        limit=RECTANGLE["limit"],
        penalty=int(kernel.penalty[i]),
        score=float(kernel.score[i]),
        delivered=int(kernel.delivered[i]),
        foods=2,
        poison_home=int(kernel.poison_home[i]),
        food_x=tuple(kernel.foods[i, :, 0].tolist()),
        food_y=tuple(kernel.foods[i, :, 1].tolist()),
        food_delivered=tuple(kernel.food_delivered[i].tolist()),
        start_x=float(kernel.start[i, 0]),
        start_y=float(kernel.start[i, 1]),
        start_heading=float(kernel.start[i, 2]),
        rounds_by_state=tuple(kernel.rounds_by_state[i].tolist()),
        wrong_by_state=tuple(kernel.wrong_by_state[i].tolist()),
        orient_ghost=int(kernel.orient_ghost[i]),
        ties=int(kernel.ties[i]),
        conflicts=int(kernel.conflicts[i]),
        experience_size=0,
    )


def test_an_episode_does_not_depend_on_what_is_beside_it(experience: Any) -> None:
    """How many there are, on how many threads, and who else is there and in which order their memories stand."""
    which = np.arange(300) % 5 - 2
    whole = run_recalls("rectangle", memories_of(experience), which, 3, **RECTANGLE)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    others = [run_recalls("rectangle", memories_of(experience), which, 3, **RECTANGLE)]
    numba.set_num_threads(threads)
    turned = np.where(which >= 0, 2 - which, which)
    others.append(run_recalls("rectangle", memories_of(experience[::-1]), turned[:170], 3, **RECTANGLE))
    for other in others:
        for a, b in zip(whole, other, strict=True):
            assert (a[: len(b)] == b).all()


def test_the_teacher_is_always_right_and_chance_one_time_in_ten() -> None:
    teacher = run_teacher("corridor", 300, 2)
    assert (teacher.correct == teacher.steps).all()
    assert not teacher.wrong_by_state.any()
    assert (teacher.rounds_by_state.sum(axis=1) == teacher.steps).all()
    same = run_recalls("corridor", None, np.full(300, TEACHER), 2)
    for a, b in zip(teacher, same, strict=True):
        assert (a == b).all()
    chance = run_recalls("corridor", None, np.full(300, UNIFORM), 2)
    assert (chance.start == teacher.start).all()
    right, steps = int(chance.correct.sum()), int(chance.steps.sum())
    assert stats.binomtest(right, steps, 0.1).pvalue > 1e-3
    assert not chance.ties.any()


def test_who_knows_one_thing_does_one_thing() -> None:
    memories = memories_of([([(0, 50, 0, 215, 40)], [Behaviour.MOVE_SLOWLY])])
    kernel = run_recalls("corridor", memories, np.zeros(50, np.int64), limit=40)
    moving = kernel.rounds_by_state[:, Behaviour.MOVE_SLOWLY]
    assert (kernel.correct == moving).all()
    assert moving.any()
    assert not kernel.ties.any()
    assert (kernel.score == 100 * moving / 40 - 20).all()


@pytest.mark.parametrize(
    ("which", "message"),
    [
        ([0, 1], r"memory_of_episode has 1; allowed: -2 \(uniform\), -1 \(teacher\)"),
        ([-3], "memory_of_episode has -3"),
        ([0.5], r"memory_of_episode is \[0.5\]"),
        ([], r"memory_of_episode is \[\]"),
    ],
)
def test_bad_memories_are_quoted(which: Any, message: str) -> None:
    memories = memories_of([([(0, 50, 0, 215, 40)], [0])])
    with pytest.raises(ValueError, match=message):
        run_recalls("corridor", memories, which)
