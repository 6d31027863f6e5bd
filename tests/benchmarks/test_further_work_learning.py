"""Attribute weights, state vector and action level of `benchmarks/further_work.py`."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from further_experiments import redesigned_vector as new
from further_experiments.attribute_weights import FIXED
from further_experiments.copied_motors import CopiedMotorsEnv, LearnedBehavioursEnv, hand_coded
from further_experiments.observed_training import ObservingTeacher

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Teacher
from khepera_forage.policies.brute_force import WeightedImitator
from khepera_forage.policies.distance import distance
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.training import attempt, train
from khepera_forage.task.decisions import DEFAULT_VALUES
from khepera_forage.task.perception import RawData, state_vector
from khepera_forage.task.states import Behaviour
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read
from tests.version_0_1 import V0_1

ATTRIBUTES = 5
DIAGONAL = 138
SIGHT: dict[str, Any] = {
    "proximity": (0,) * 6,
    "arm": 215,
    "jaw": 200,
    "x": 40.0,
    "y": 20.0,
    "tracked": True,
    "food_seen": True,
    "food_x": 70.0,
    "food_y": 20.0,
    "home_x": 110.0,
    "home_y": 20.0,
    "home_radius": 20,
    "home_opening": 180.0,
    "wall_distance": 15.0,
    "wall_bearing": 90.0,
}
RAW = RawData(**(dict.fromkeys(RawData._fields, 0) | SIGHT))


def test_the_argument_for_weights_holds_on_the_training_line() -> None:
    """Equal weights tie what lies on one line with start and home; any weight of the food above the home's does not."""
    far = (Behaviour.SEARCH_FOR_FOOD, range(31, 57)), (Behaviour.MOVE_SLOWLY, range(21, 31))
    training = [((0, 36 + food, 0, 215, food), heard) for heard, foods in far for food in foods]
    training.append(((0, 56, 0, 215, 20), Behaviour.ORIENT_WITH_FOOD))
    vectors, heard = (np.array(part) for part in zip(*training, strict=True))
    further_out = np.array([(0, 96, 0, 215, 20)])

    def level(weights: tuple[int, ...]) -> float:
        shares = WeightedImitator(DIAGONAL, weights).fit(vectors, heard).predict_proba(further_out)
        return float(shares[0, list(np.unique(heard)).index(Behaviour.ORIENT_WITH_FOOD)])

    assert level(FIXED["equal"]) == pytest.approx(1 / len(training))
    assert [level(FIXED[name]) for name in ("food ×2", "food ×4", "food ×8")] == [1.0, 1.0, 1.0]
    assert level(FIXED["home ×4"]) == 0.0


def test_equal_weights_are_the_thesis_own_distance() -> None:
    rng = np.random.default_rng(0)
    lows, highs = (0, 0, 0, 215, 0), (2, 60, 4, 256, 60)
    vectors, asked = (rng.integers(lows, highs, (200, ATTRIBUTES)) for _ in range(2))
    heard = rng.integers(0, 10, 200)
    weights = FIXED["equal"]
    mine = WeightedImitator(DIAGONAL, weights).fit(vectors, heard)
    own = NearestNeighbourImitator(DIAGONAL, arithmetic="exact").fit(vectors, heard)
    assert mine.predict_proba(asked) == pytest.approx(own.predict_proba(asked))


def test_food_nearness_and_at_home_by_hand() -> None:
    assert new.REACH == 15
    assert new.food_nearness(RAW) == pytest.approx(15 / 45)
    assert new.food_nearness(RAW._replace(food_x=55.0)) == 0.5
    assert new.food_nearness(RAW._replace(food_seen=False)) == 0.0
    for food_seen in (True, False):
        assert new.food_nearness(RAW._replace(object_presence=255, food_seen=food_seen)) == 1.0
    assert not new.at_home(RAW)
    assert new.at_home(RAW._replace(x=90.0))
    assert not new.at_home(RAW._replace(x=89.9))
    assert new.redesigned(RAW) == (0, 0, 0, 215, 333)


def test_distances_of_the_redesigned_vector() -> None:
    here = new.redesigned(RAW)

    def away(**changes: Any) -> float:
        return float(distance(here, new.redesigned(RAW._replace(**changes)), new.SCALE))

    assert away(home_x=45.0) == 1
    assert away(food_type=2) == 1
    assert away(arm=226) == pytest.approx(11 / 55)
    assert away(food_seen=False) == pytest.approx(1 / 3, abs=1e-3)
    assert away(object_presence=255) == pytest.approx(1 + 2 / 3, abs=1e-3)


def test_the_redesigned_vector_does_not_depend_on_the_distance_of_the_home() -> None:
    redesigned = new.redesigned
    assert {redesigned(RAW._replace(home_x=x)) for x in (61.0, 80.0, 110.0, 200.0)} == {redesigned(RAW)}


def test_recorded_moments_are_those_of_the_experience_file() -> None:
    env = TrainingEnv(decisions=V0_1)  # whose vectors follow from the raw data alone
    teacher = ObservingTeacher(env)
    with pytest.raises(AssertionError, match="there was no training"):
        teacher.moments()
    for seed in (1, 2):
        experience, rows = train(env, np.random.SeedSequence(seed), teacher=teacher)
        moments = teacher.moments()
        assert rows[-1].complete
        assert [state_vector(moment.raw, DIAGONAL, DEFAULT_VALUES) for moment in moments] == list(
            experience.vectors
        )
        assert [moment.heard for moment in moments] == list(experience.behaviours)
    env.close()


def test_moments_of_a_failed_attempt_are_dropped() -> None:
    env = TrainingEnv(max_cycles=20)
    teacher = ObservingTeacher(env)
    for seed in (1, 2):
        assert not attempt(env, seed, lambda *_: None, teacher=teacher).complete
        assert 0 < len(teacher.moments()) <= 20
    env.close()


def test_without_noise_copied_motors_are_the_teachers() -> None:
    """Without noise both robots stand in the same place, and following has nothing to bend."""
    env = CopiedMotorsEnv(noise=Noise.none())
    teacher = ObservingTeacher(env)
    told = []

    def watch() -> None:
        teacher, learner = env.foragers
        told.append((teacher.applied, learner.applied))

    assert attempt(env, 3, lambda *_: None, teacher=teacher, callback=watch).complete
    env.close()
    assert len(told) > 50
    assert [learner for _, learner in told] == [teacher for teacher, _ in told]
    assert [moment.motors for moment in teacher.moments()] == [learner for _, learner in told]


def test_copied_motors_are_the_teachers_unless_following_bends_them() -> None:
    """In the laboratory's noise the learner's motors are the teacher's, unless following bends them."""
    env = CopiedMotorsEnv()
    shown = []

    def watch() -> None:
        teacher, learner = env.foragers
        shown.append((teacher.applied[2:], learner.applied[2:]))
        same_mean.append(sum(teacher.applied[:2]) == pytest.approx(sum(learner.applied[:2]), abs=1.01))

    same_mean: list[bool] = []
    attempt(env, 4, lambda *_: None, callback=watch)
    env.close()
    assert all(teacher == learner for teacher, learner in shown)
    assert np.mean(same_mean) > 0.9, "only a learner that recovers goes at a speed of its own"


def test_recall_with_the_given_behaviours_is_recall() -> None:
    given = recall_env("corridor")
    own = LearnedBehavioursEnv(arena="corridor", foods=given.foods, limit=given.limit)
    for seed in (5, 6):
        assert recall(own, Teacher(), seed) == recall(given, Teacher(), seed)
    own.command = lambda behaviour, raw: applicable(hand_coded(Behaviour.WAIT, raw))
    still = recall(own, Teacher(), 5)
    assert (still.steps, still.delivered) == (given.limit, 0)
    given.close()
    own.close()


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("further_work")


def test_rows_of_equal_weights_the_old_vector_and_the_thesis_own_are_the_same(out: Path) -> None:
    """The same files, recalls and learner under three names."""
    names = {
        "attribute_weights": "equal",
        "state_vector": "the thesis's state vector",
        "alternatives": "as in the thesis",
    }
    rows = {
        name: [row | {"condition": ""} for row in read(out / name / "recalls.csv") if row["condition"] == own]
        for name, own in names.items()
    }
    assert len(rows["alternatives"]) == 4
    assert rows["attribute_weights"] == rows["state_vector"] == rows["alternatives"]


def test_pages_have_a_summary(out: Path) -> None:
    for name in ("attribute_weights", "state_vector", "action_level"):
        page = (out / name / f"{name}.md").read_text(encoding="utf-8")
        summary = page.split("**In short:** ")[1].split("\n\n")[0]
        assert "after 2 episodes" in summary.lower()
        assert "nan" not in summary


def test_wrong_steps_by_state_add_up(out: Path) -> None:
    rows = read(out / "action_level" / "recalls.csv")
    assert {row["condition"] for row in rows} == {
        f"{setup}: {what}"
        for setup in ("one set-up", "start and food moved")
        for what in ("the teacher", "learned program", "learned behaviours", "both learned")
    }
    for row in rows:
        spent, wrong = (
            [int(n) for n in row[key].split(";")] for key in ("rounds_by_state", "wrong_by_state")
        )
        assert sum(spent) == int(row["steps"])
        assert sum(wrong) == int(row["steps"]) - int(row["correct"])
        if row["condition"].endswith(("the teacher", "learned behaviours")):
            assert sum(wrong) == 0, "the program is the teacher's"
