"""The paired corridors in batch against the paired corridors: the same company, the same experience."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest
from scipy import stats

from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.parameters import site_array
from khepera_forage.envs.compiled.task import raw_of
from khepera_forage.envs.compiled.worlds import empty_worlds, worlds_of
from khepera_forage.envs.forager import site_of
from khepera_forage.envs.training import PATIENCE, TrainingEnv
from khepera_forage.envs.training_episode import _is_done
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.compiled import pair_rows as pair
from khepera_forage.rollouts.compiled import training as pairs
from khepera_forage.rollouts.compiled.pairing import drive_pair, judge, keep_company
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.compiled.training_results import Trained
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.rollouts.training import IncompleteTrainingError, train
from khepera_forage.sim.arena import CORRIDOR, Pose, copies
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.task.behaviours import command
from khepera_forage.task.pairing import Company
from khepera_forage.task.states import Behaviour, FoodType, StateVector

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
ROUGH = Noise(placement_error=15.0, placement_heading_error=20.0, wheel_bias=0.1, wheel_slip=0.2)
"""Robots so bad that learners often get separated."""
ARENAS = copies(CORRIDOR, 2)


def _alike(trained: Trained, experience: Experience, rows: list[TrainingRow], pixels: int = 1) -> None:
    """The same behaviours heard, and state vectors within some pixels."""
    vectors, heard = experience.arrays()
    mine = trained.vectors_of(0)
    assert mine[:, pair.HEARD].tolist() == heard.tolist()
    assert np.abs(mine[:, : pair.HEARD] - vectors)[:, (0, 2, 3)].max() == 0
    assert np.abs(mine[:, : pair.HEARD] - vectors).max() <= pixels
    made = trained.attempts
    assert made.rounds.tolist() == [row.rounds for row in rows]
    assert made.separations.tolist() == [row.separations for row in rows]


@pytest.mark.parametrize("food_type", ["pickable", "pushable", "poisonous"])
def test_without_noise_the_learner_hears_and_records_what_it_does_in_the_single_environment(
    food_type: str,
) -> None:
    env = TrainingEnv(noise=Noise.none(), food_types=food_type)
    single = train(env, np.random.SeedSequence(0))
    batch = train_learners(1, noise=Noise.none(), food_types=food_type)
    _alike(batch, *single)
    shown = Behaviour.AVOID_FOOD in single[0].behaviours
    assert shown == (food_type == "poisonous")


@pytest.mark.parametrize(
    ("ahead", "aside", "turned", "separations"),
    [(0.0, 20.0, 0.3, 0), (-30.0, -10.0, 0.3, 0), (100.0, -10.0, 0.3, 1), (90.0, 20.0, -0.5, 3)],
)
def test_a_learner_that_stands_elsewhere_is_led_and_waited_for_alike(
    ahead: float, aside: float, turned: float, separations: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Following and recovery, from starts off the mark: beyond 70 mm the teacher waits."""
    x, y, heading = ARENAS[1].start
    learner = replace(ARENAS[1], start=Pose(x + ahead, y + aside, heading + turned))
    arenas = (ARENAS[0], learner)
    env = TrainingEnv(noise=Noise.none(), world=PymunkWorld(arenas, (1, 2), Noise.none()))
    monkeypatch.setattr(pairs, "copies", lambda arena, count: arenas)
    experience, rows = train(env, np.random.SeedSequence(0), attempts=1)
    _alike(train_learners(1, noise=Noise.none(), attempts=1), experience, rows)
    assert rows[0].separations == separations


def _two_sides(rng: np.random.Generator) -> "list[_Side]":
    """The worlds of both sides of a block of pairs, with senses of any kind."""
    worlds = empty_worlds(pair.SIDES, 1)
    return [_Side(worlds_of(worlds, side, 0), arena, rng) for side, arena in enumerate(ARENAS)]


class _Side:
    """Rows of one side, and what `Company` and `_is_done` want to know of the same robots."""

    def __init__(self, worlds: Any, arena: Any, rng: np.random.Generator) -> None:
        self.worlds, self.arena, self.rng = worlds, arena, rng
        self.site, self.place = site_of(arena), site_array(arena)
        self.s, self.t, self.q = worlds.bodies.robots, worlds.tasks, worlds.registers
        self.x, self.y = rng.uniform(50, 90, LANES), rng.uniform(0, 20, LANES)

    def move(self, degrees: Any) -> None:
        rng, site = self.rng, self.site
        self.x += rng.normal(0, 4, LANES)
        self.y += rng.normal(0, 4, LANES)
        self._set(self.s, body.OWN_X, self.x)
        self._set(self.s, body.OWN_Y, self.y + site.home_y)
        self._set(self.s, body.OWN_DEGREES, degrees)
        self._set(self.s, body.OWN_FOUND, 1)
        self._set(self.s, body.ARM_READ, rng.choice((215, 226, 255), LANES))
        self._set(self.s, body.JAW_READ, 200)
        self._set(self.s, body.PRESENT, rng.choice((0, 255), LANES))
        self._set(self.t, at.FOOD_SEEN, 1)
        self._set(self.t, at.FOOD_X, rng.uniform(0, 130, LANES))
        self._set(self.t, at.FOOD_Y, site.home_y + rng.uniform(-20, 20, LANES))
        self._set(self.t, at.WALL_DISTANCE, rng.uniform(5, 20, LANES))
        self._set(self.t, at.WALL_BEARING, rng.uniform(-180, 180, LANES))
        self._set(self.t, at.PRESENCE, rng.integers(0, 2, LANES))
        self._set(self.t, at.HOME_DISTANCE, rng.integers(18, 24, LANES))
        self._set(self.t, at.VECTOR_ARM, rng.choice((215, 226, 255), LANES))
        self._set(self.t, at.DELIVERED, rng.integers(0, 2, LANES))
        self._set(self.t, at.DELIVERABLE, rng.integers(0, 2, LANES))

    def forager(self, i: int) -> Any:
        """What the single environment has of lane i."""
        raw = raw_of(self.s, self.t, i, self.site)
        presence, home, arm = (
            int(self.t[row * LANES + i]) for row in (at.PRESENCE, at.HOME_DISTANCE, at.VECTOR_ARM)
        )
        finished = self.t[at.DELIVERED * LANES + i] == self.t[at.DELIVERABLE * LANES + i]
        known = [FoodType(int(self.q[at.KNOWN * LANES + i]))]
        return SimpleNamespace(
            raw=raw,
            site=self.site,
            vector=StateVector(presence, home, 0, arm, 0),
            register=SimpleNamespace(known=known, finished=finished),
        )

    @staticmethod
    def _set(rows: Any, row: int, values: Any) -> None:
        rows[row * LANES : (row + 1) * LANES] = values


def _row(rows: Any, row: int) -> list[float]:
    return list(rows[row * LANES : (row + 1) * LANES].tolist())


def test_separation_waiting_following_and_recovery_are_those_of_company() -> None:
    """The same poses given to `Company`, round by round: who is apart for how long, and every learner's motors."""
    rng = np.random.default_rng(0)
    teacher, learner = _two_sides(rng)
    c = np.zeros(pair.COMPANY_ROWS * LANES)
    companies: list[Company] = []
    led = recovering = 0
    for number in range(25):
        degrees = rng.integers(0, 360, LANES)
        teacher.move(degrees)
        learner.move((degrees + rng.integers(-20, 21, LANES)) % 360)
        robots = [[teacher.forager(i), learner.forager(i)] for i in range(LANES)]
        if number == 0:
            companies = [Company(both) for both in robots]
        else:
            for company, both in zip(companies, robots, strict=True):
                company._foragers = both
                company.update()
        keep_company(teacher.s, learner.s, c, teacher.place, learner.place)
        assert _row(c, pair.APART) == [company.apart[1] for company in companies]
        assert _row(c, pair.APART_ROUNDS) == [company.rounds[1] for company in companies]
        assert _row(c, pair.SEPARATIONS) == [company.separations[1] for company in companies]
        heard = rng.integers(0, 11, LANES)
        learner._set(learner.t, at.BEHAVIOUR, heard)
        drive_pair(learner.s, learner.t, c, learner.place, True)
        told = [_row(learner.s, row) for row in (body.LEFT, body.RIGHT, body.ARM_TO, body.JAW_TO)]
        for i, company in enumerate(companies):
            own = command(int(heard[i]), robots[i][1].raw)
            lead = applicable(company.lead(1, own, silent=heard[i] == Behaviour.WAIT))
            assert lead == tuple(row[i] for row in told)
            led += lead[:2] != applicable(own)[:2]
            recovering += company.apart[1] and heard[i] == Behaviour.WAIT
    assert led > 300
    assert recovering > 50


def test_an_attempt_ends_as_in_the_single_environment() -> None:
    """Complete when both are done, poison included; otherwise out of time, or separated for too long."""
    rng = np.random.default_rng(1)
    teacher, learner = _two_sides(rng)
    c = np.zeros(pair.COMPANY_ROWS * LANES)
    limit, complete = 12, 0
    for number in range(1, 25):
        for side in (teacher, learner):
            side.move(0)
            side._set(side.t, at.FRESH, number == 1)
        known = rng.choice((0, 1, 3), LANES)
        for side in (teacher, learner):
            side._set(side.q, at.KNOWN, known)
        before = rng.integers(0, limit, LANES)
        apart = rng.integers(0, PATIENCE + 2, LANES)
        teacher._set(c, pair.ROUNDS, before)
        teacher._set(c, pair.APART_ROUNDS, apart)
        ended = judge(teacher.worlds, learner.worlds, c, 1, teacher.place[2], limit, PATIENCE)
        for i in range(LANES):
            done = number > 1 and _is_done(teacher.forager(i)) and _is_done(learner.forager(i))
            late = before[i] + 1 >= limit or apart[i] >= PATIENCE
            assert c[pair.COMPLETE * LANES + i] == done
            assert c[pair.OVER * LANES + i] == (number > 1 and (done or late))
            assert c[pair.ROUNDS * LANES + i] == before[i] + (number > 1)
            complete += done
        assert ended == any(_row(c, pair.OVER))
    assert complete > 50


def test_corresponding_food_is_of_one_type_and_poison_is_always_avoided() -> None:
    """What is heard follows the teacher's food, and what is perceived the learner's own."""
    trained = train_learners(600, food_types=MIXED)
    shown = {FoodType.PICKABLE: Behaviour.PICK_UP_FOOD, FoodType.PUSHABLE: Behaviour.PUSH_FOOD}
    shown[FoodType.POISONOUS] = Behaviour.AVOID_FOOD
    types: list[FoodType] = []
    both = 0
    for learner in range(600):
        rows = trained.vectors_of(learner)
        perceived = {FoodType(t) for t in rows[:, 2].tolist()} - {FoodType.UNKNOWN}
        told = {t for t, behaviour in shown.items() if behaviour in rows[:, pair.HEARD]}
        # Who has nothing in its gripper when the other identifies the food may not come to show, or see, its type.
        assert len(told | perceived) <= 1
        types += told | perceived
        both += bool(told and perceived)
    assert both > 350
    assert len(types) > 590
    assert stats.chisquare(np.bincount(types)[1:]).pvalue > 1e-3


def test_a_learner_is_the_same_however_many_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    many = train_learners(300, seed=5, noise=ROUGH, food_types=MIXED, episodes=2)
    threads = numba.get_num_threads()
    monkeypatch.setattr(pairs, "_ROOM", 1)  # one block of episodes at a time
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


def test_the_account_of_attempts_is_that_of_training_rows() -> None:
    """Incomplete attempts are counted, and what they recorded is forgotten (5.2)."""
    trained = train_learners(400, seed=1, noise=ROUGH, food_types=MIXED, episodes=2)
    made = trained.attempts
    rows = [
        TrainingRow(0, learner + 1, attempt, trained.seed, "rough", complete, rounds, vectors, apart, reason)
        for learner, _, attempt, complete, rounds, vectors, apart, reason in zip(
            *(column.tolist() for column in made), strict=True
        )
    ]
    assert sum(row.complete for row in rows) == 800
    assert {row.reason for row in rows} == {"", "separated", "out of time"}
    assert all(row.rounds < 600 for row in rows if row.reason == "separated")
    assert sum(row.separations for row in rows) > 100
    assert sum(row.vectors < row.rounds for row in rows) > 100  # nothing is recorded in silence
    assert np.diff(trained.offsets).ravel().tolist() == [row.vectors for row in rows if row.complete]
    assert trained.offsets[-1, -1] == len(trained.experience)
    assert (trained.experience[:, pair.HEARD] < Behaviour.WAIT).all()


def test_training_takes_as_long_as_in_pymunk() -> None:
    """Some tens of trainings here; thousands in docs/batch.md."""
    env = TrainingEnv(noise=ROUGH, food_types=MIXED)
    single = [train(env, seed)[1] for seed in np.random.SeedSequence(1).spawn(60)]
    batch = train_learners(4000, seed=2, noise=ROUGH, food_types=MIXED).attempts
    for name in ("rounds", "vectors", "separations"):
        ours, theirs = getattr(batch, name)[batch.complete], [getattr(rows[-1], name) for rows in single]
        assert stats.ks_2samp(ours, theirs).pvalue > 1e-3
    assert stats.ks_2samp(np.bincount(batch.learner), [len(rows) for rows in single]).pvalue > 1e-3


def test_the_experience_of_a_learner_is_experience(tmp_path: Any) -> None:
    trained = train_learners(2, seed=3, episodes=2)
    whole = trained.experience_of(1)
    assert whole.episodes == 2
    first, second = (trained.experience_of(1, episode) for episode in range(2))
    assert first + second == whole
    whole.save(tmp_path / "g1.csv")
    assert Experience.load(tmp_path / "g1.csv") == whole


def test_what_never_gets_complete_is_hopeless() -> None:
    with pytest.raises(RuntimeError, match="none of 3 attempts") as batch:
        train_learners(2, max_cycles=9, attempts=3)
    with pytest.raises(IncompleteTrainingError) as single:
        train(TrainingEnv(max_cycles=9), np.random.SeedSequence(0), attempts=3)
    assert str(batch.value) == str(single.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": 0}, "n is 0"),
        ({"episodes": 0}, "episodes is 0"),
        ({"seed": -1}, "seed is -1"),
        ({"patience": 0}, "patience is 0"),
        ({"max_cycles": 1.5}, "max_cycles is 1.5"),
        ({"arena": "moon"}, "arena is 'moon'"),
        ({"arena": CORRIDOR.shifted(3000.0, 0.0)}, "what the camera sees"),
        ({"options": {"foods": [(90.0, 115.0)]}}, "overlaps"),
        ({"options": {"place": 1}}, "reset option 'place'"),
        ({"noise": Noise(placement_error=1e6)}, "too near a wall for a placement error"),
    ],
)
def test_bad_arguments_are_quoted(arguments: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        train_learners(**{"n": 1, **arguments})


@pytest.mark.parametrize(("learner", "episode", "name"), [(1, None, "learner"), (0, 2, "episode")])
def test_a_learner_that_is_not_there_is_quoted(learner: int, episode: int | None, name: str) -> None:
    trained = train_learners(1)
    value = learner if episode is None else episode
    with pytest.raises(ValueError, match=f"{name} is {value}; allowed: 0 to"):
        trained.vectors_of(learner, episode)
