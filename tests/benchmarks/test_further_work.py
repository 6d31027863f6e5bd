"""`benchmarks/further_work.py`: every experiment gives a page, a picture and rows that agree with each other."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from further_experiments import memory
from further_experiments import perception as new
from further_experiments.common import ExperimentSize, Trial
from further_experiments.memory import FIXED, PATIENCE, StateLabels, UntilGoal, goal_reached
from further_experiments.perception import (
    CopiedMotorsEnv,
    LearnedBehavioursEnv,
    ObservingTeacher,
    learned_command,
    observe,
)
from further_experiments.teachers import SimulatedPerson

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher, WeightedImitator
from khepera_forage.policies.distance import distance
from khepera_forage.robots.khepera import ARM_RAISED, JAW_CLOSED, applicable
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.training import attempt
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import DEFAULT_VALUES
from khepera_forage.task.perception import RawData, state_vector
from khepera_forage.task.states import BEHAVIOURS, Behaviour, StateVector
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import is_picture, read
from tests.benchmarks.test_scripts import EXPERIMENTS
from tests.version_0_1 import V0_1, VALUES

WITHOUT_RECALLS = {"several_learners"}
WITH_RECALLS = sorted(set(EXPERIMENTS) - WITHOUT_RECALLS)
Rows = list[dict[str, str]]


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("further_work")


def rows_of(out: Path, name: str, kind: str = "recalls", **wanted: str) -> Rows:
    rows = read(out / name / f"{kind}.csv")
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def test_every_experiment_has_page_picture_tables_rows_and_claims(out: Path) -> None:
    assert {folder.name for folder in out.iterdir()} == set(EXPERIMENTS)
    printed = (out.parent / "printed").read_text(encoding="utf-8")
    for name in EXPERIMENTS:
        assert is_picture(out / name / f"{name}.png")
        assert read(out / name / "trainings.csv")
        assert bool(read(out / name / "recalls.csv")) is (name not in WITHOUT_RECALLS)
        page = (out / name / f"{name}.md").read_text(encoding="utf-8")
        assert f"]({name}.png)" in page
        claims = read(out / name / "table_claims.csv")
        assert claims
        for claim in claims:
            assert claim["verdict"] == "undecided", "one replication gives no interval"
            assert claim["claim"][:39] in printed
            assert f"| {claim['claim']} | {claim['effect']} |" in page


@pytest.mark.parametrize("name", WITH_RECALLS)
def test_table_is_that_of_the_rows(out: Path, name: str) -> None:
    key = {"chains_of_learners": "generation", "human_teacher": "delay (rounds)"}.get(name, "episodes")
    column = "food settled (%)" if name == "push_and_avoid" else "food delivered (%)"
    table = read(out / name / "table_recalls.csv")
    for line in table:
        own = rows_of(out, name, condition=line["condition"], arena=line["arena"], amount=line[key])
        assert len(own) == int(line["rows"]) > 0
        settled = sum(int(row["delivered"]) for row in own)
        if name == "push_and_avoid":
            settled += sum(int(row["avoided"]) for row in own)
        foods = sum(int(row["foods"]) for row in own)
        assert float(line[column]) == pytest.approx(100 * settled / foods, abs=1e-3)
    assert sum(int(line["rows"]) for line in table) == len(rows_of(out, name))


def test_effects_are_differences_of_the_rows(out: Path) -> None:
    def score(condition: str, arena: str) -> float:
        rows = rows_of(out, "spatial_variety", condition=condition, arena=arena, amount="2")
        return float(np.mean([float(row["score"]) for row in rows]))

    claims = {line["claim"]: line["value"] for line in read(out / "spatial_variety" / "table_claims.csv")}
    for arena in ("corridor", "rectangle"):
        for condition in ("food moved", "start and food moved"):
            effect = score(condition, arena) - score("one set-up", arena)
            assert float(claims[f"{condition}, {arena}: variety helps"]) == pytest.approx(effect, rel=1e-4)


def seeds_of(out: Path, name: str) -> dict[tuple[str, str], set[tuple[str, ...]]]:
    """The seeds of the recalls in each replication and arena, under every condition and after every amount."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for row in rows_of(out, name):
        groups.setdefault((row["replication"], row["arena"], row["condition"], row["amount"]), []).append(row["seed"])
    seeds: dict[tuple[str, str], set[tuple[str, ...]]] = {}
    for (replication, arena, *_), numbers in groups.items():
        seeds.setdefault((replication, arena), set()).add(tuple(numbers))
    return seeds


def test_conditions_share_their_places_and_replications_have_their_own(out: Path, quick_run: QuickRun) -> None:
    for name in WITH_RECALLS:
        seeds = seeds_of(out, name)
        assert len(seeds) == 2
        assert all(len(kinds) == 1 for kinds in seeds.values())
    repeated = quick_run("further_work", "--only", "spatial_variety", "--replications", "2")
    assert {folder.name for folder in repeated.iterdir()} == {"spatial_variety"}
    seeds = seeds_of(repeated, "spatial_variety")
    assert len(seeds) == len(set.union(*seeds.values())) == 4


def test_trainings_agree_with_themselves(out: Path) -> None:
    for name in EXPERIMENTS:
        for row in rows_of(out, name, "trainings"):
            true, vectors, rounds, everything = (int(row[key]) for key in ("true", "vectors", "rounds", "all_rounds"))
            assert 0 <= true <= vectors <= rounds <= everything
            assert (int(row["attempts"]) == 1) is (rounds == everything)


def test_a_person_with_whom_an_episode_is_never_complete_has_no_rows(out: Path) -> None:
    files: dict[tuple[str, str], list[str]] = {}
    for row in rows_of(out, "human_teacher", "trainings"):
        files.setdefault((row["condition"], row["amount"]), []).append(row["file"])
    assert 0 < len(files) < 3 * 4
    assert all(numbers == ["1", "2"] for numbers in files.values())
    assert {(row["condition"], row["amount"]) for row in rows_of(out, "human_teacher")} == set(files)


def test_action_level_has_every_pair_of_program_and_behaviours(out: Path) -> None:
    rows = read(out / "action_level" / "recalls.csv")
    assert {row["condition"] for row in rows} == {
        f"{setup}: {what}"
        for setup in ("one set-up", "start and food moved")
        for what in ("the teacher", "learned program", "learned behaviours", "both learned")
    }
    for row in rows:
        if row["condition"].endswith(("the teacher", "learned behaviours")):
            assert row["correct"] == row["steps"], "the program is the teacher's"


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


def test_variety_is_variety(out: Path) -> None:
    """Two episodes of one set-up leave fewer different state vectors than two of several."""
    distinct = {
        condition: np.mean(
            [int(row["distinct"]) for row in rows_of(out, "spatial_variety", condition=condition, amount="2")]
        )
        for condition in ("one set-up", "food moved", "start and food moved")
    }
    assert distinct["one set-up"] < min(distinct["food moved"], distinct["start and food moved"])


def test_a_robot_with_another_arm_reading_cannot_use_the_teachers_program(out: Path) -> None:
    def delivered(condition: str) -> int:
        return sum(int(row["delivered"]) for row in rows_of(out, "different_robots", condition=condition, amount="0"))

    assert delivered("arm reads 231 when raised") == 0
    assert delivered("same robot") == 1 + 2


def test_state_labels_forage_exactly_as_the_teacher(out: Path) -> None:
    """After two episodes: in one alone the single round of EXPLORE FOOD may not come up."""
    for arena in ("corridor", "rectangle"):
        teacher = rows_of(out, "alternatives", condition="teacher", arena=arena)
        labels = rows_of(out, "alternatives", condition="state labels", arena=arena, amount="2")
        for name in ("steps", "correct", "delivered"):
            assert [row[name] for row in labels] == [row[name] for row in teacher]


def test_alternatives_end_differently(out: Path) -> None:
    """Learners that use the same files differently end differently."""
    ends = {
        name: tuple((row["steps"], row["correct"]) for row in rows_of(out, "alternatives", condition=name, amount="2"))
        for name in ("as in the thesis", "highest confidence", "threshold 0.2", "until the goal, all vectors")
    }
    assert len(set(ends.values())) == len(ends)


FAR = StateVector(0, 90, 0, 215, 60)
CLOSE = FAR._replace(robot_food_distance=25)
NEXT = FAR._replace(robot_food_distance=20)
INSIDE = StateVector(1, 60, 0, 255, 12)
KNOWN = INSIDE._replace(food_type=1)
LIFTED = KNOWN._replace(arms_height=220)
HOME = LIFTED._replace(robot_home_distance=18)
RELEASED = StateVector(0, 18, 0, 255, 13)
ROUTE = (FAR, CLOSE, NEXT, INSIDE, KNOWN, LIFTED, HOME, RELEASED, FAR)
DONE = (
    Behaviour.SEARCH_FOR_FOOD,
    Behaviour.MOVE_SLOWLY,
    Behaviour.ORIENT_WITH_FOOD,
    Behaviour.EXPLORE_FOOD,
    Behaviour.PICK_UP_FOOD,
    Behaviour.GO_HOME,
    Behaviour.RELEASE_FOOD,
    Behaviour.AVOID_HOME,
)


def test_each_goal_is_where_the_next_behaviour_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "DECISIONS", VALUES)
    for behaviour, here, there in zip(DONE, ROUTE[:-1], ROUTE[1:], strict=True):
        assert not goal_reached(behaviour, here, 20)
        assert goal_reached(behaviour, there, 20)
    for behaviour in (Behaviour.AVOID_FOOD, Behaviour.PUSH_FOOD):
        assert not goal_reached(behaviour, KNOWN, 20)
    assert goal_reached(Behaviour.AVOID_FOOD, RELEASED, 20)
    assert goal_reached(Behaviour.PUSH_FOOD, HOME, 20)


def test_a_behaviour_runs_until_its_goal_or_for_a_limited_time() -> None:
    decisions = []

    class Searching:
        def act(self, observation: object, rng: np.random.Generator | None = None) -> int:
            decisions.append(observation)
            return Behaviour.SEARCH_FOR_FOOD

    policy = UntilGoal(Searching(), 20)
    for _ in range(PATIENCE):
        assert policy.act(FAR) == Behaviour.SEARCH_FOR_FOOD
    assert len(decisions) == 1
    policy.act(FAR)
    assert len(decisions) == 2
    policy.act(CLOSE)
    assert len(decisions) == 3


def test_state_labels_draw_any_behaviour_in_a_state_without_record() -> None:
    learner = StateLabels(20, frozenset(BEHAVIOURS[:2]))
    rng = np.random.default_rng(0)
    assert {learner.act(FAR, rng) for _ in range(20)} == {Behaviour.SEARCH_FOR_FOOD}
    assert len({learner.act(HOME, rng) for _ in range(100)}) == 10


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


def test_redesigned_vector_and_its_distances_by_hand() -> None:
    assert new.REACH == 15
    here = new.redesigned(RAW)
    assert here == (0, 0, 0, 215, 333)
    assert [new.redesigned(RAW._replace(x=x))[1] for x in (40.0, 89.9, 90.0)] == [0, 0, new.SCALE]
    for changes, nearness, away in (
        ({"home_x": 45.0}, 1 / 3, 1),
        ({"food_type": 2}, 1 / 3, 1),
        ({"arm": 226}, 1 / 3, 11 / 55),
        ({"food_x": 55.0}, 1 / 2, 1 / 6),
        ({"food_seen": False}, 0, 1 / 3),
        ({"object_presence": 255}, 1, 1 + 2 / 3),
        ({"object_presence": 255, "food_seen": False}, 1, 1 + 2 / 3),
    ):
        raw = RAW._replace(**changes)
        assert new.food_nearness(raw) == pytest.approx(nearness)
        assert float(distance(here, new.redesigned(raw), new.SCALE)) == pytest.approx(away, abs=1e-3)


def test_recorded_moments_are_those_of_the_experience_file() -> None:
    """Those of failed attempts are dropped."""
    env = TrainingEnv(decisions=V0_1, max_cycles=90)  # whose vectors follow from the raw data alone
    trial = Trial(seed=0, replication=0, condition="all", size=ExperimentSize())
    files, rows, moments = observe(trial, env, [np.random.SeedSequence(seed) for seed in (1, 2)])
    assert all(row.attempts > 1 for row in rows)
    for experience, own in zip(files, moments, strict=True):
        vectors = [state_vector(moment.raw, -1.0, DIAGONAL, DEFAULT_VALUES) for moment in own]
        assert vectors == list(experience.vectors)
        assert [moment.heard for moment in own] == list(experience.behaviours)
    env.close()


def test_without_noise_copied_motors_are_the_teachers() -> None:
    """Without noise both robots stand in the same place, and following has nothing to bend."""
    env = CopiedMotorsEnv(noise=Noise.none())
    teacher = ObservingTeacher(env)
    told = []

    def watch() -> None:
        teacher()
        told.append(tuple(robot.applied for robot in env.foragers))

    assert attempt(env, 3, lambda *_: None, teacher=teacher, callback=watch).complete
    env.close()
    assert len(told) > 50
    assert [learner for _, learner in told] == [teacher for teacher, _ in told]
    assert [moment.motors for moment in teacher.attempts[-1]] == [learner for _, learner in told]


def test_recall_with_the_given_behaviours_is_recall() -> None:
    usual = recall_env("corridor")
    own = LearnedBehavioursEnv(arena="corridor", foods=usual.foods, limit=usual.limit)
    own.command = lambda behaviour, raw: command(behaviour, raw, DEFAULT_VALUES)
    for seed in (5, 6):
        assert recall(own, Teacher(), seed) == recall(usual, Teacher(), seed)
    own.command = lambda _, raw: applicable(command(Behaviour.WAIT, raw, DEFAULT_VALUES))
    still = recall(own, Teacher(), 5)
    assert (still.steps, still.delivered) == (usual.limit, 0)
    usual.close()
    own.close()


def test_every_key_of_a_person_but_the_first_is_late_and_some_are_wrong() -> None:
    env, draws = TrainingEnv(decisions=V0_1), np.random.default_rng(0)
    env.reset(seed=1)

    def seen(vector: StateVector, separated: int = 0) -> list[int]:
        return [*vector, Behaviour.WAIT, separated]

    exact = SimulatedPerson(env, delay=0, wrong=0.0)
    for vector in (FAR, CLOSE, NEXT, FAR):
        for separated in (0, 1):
            shown = seen(vector, separated)
            assert exact.act(shown, draws) == Teacher.of(env).act(shown)
    late, keys = SimulatedPerson(env, delay=2, wrong=0.0), []
    for step, vector in enumerate((FAR, CLOSE, NEXT, NEXT, NEXT, FAR)):
        env.infos[TEACHER]["steps"] = step
        keys.append(late.act(seen(vector), draws))
    search, slowly, orient = DONE[:3]
    assert keys == [search, search, search, slowly, orient, orient]
    careless = SimulatedPerson(env, delay=0, wrong=0.2)
    counts = np.bincount([careless.act(seen(FAR), draws) for _ in range(5000)], minlength=10)
    assert len(counts) == 10, "WAIT is never pressed"
    assert abs(counts[search] - 4000) < 6 * np.sqrt(5000 * 0.2 * 0.8)
    assert np.all(np.abs(counts[1:] - 1000 / 9) < 6 * np.sqrt(1000 / 9))


def test_behaviours_learned_from_the_teacher_s_motors_forage_at_new_places() -> None:
    """Robots that stand still, or drive at random, deliver nothing."""

    def forages(name: str, seeds: range, action: Callable[[int, RawData], Any]) -> int:
        env: Any = gym.make(f"khepera_forage/{name}-v1").unwrapped
        delivered = 0
        for seed in seeds:
            (_, info), over = env.reset(seed=seed), False
            while not over:
                _, _, terminated, truncated, info = env.step(action(info["correct_behaviour"], env.forager.raw))
                over = terminated or truncated
            delivered += info["delivered"]
        return delivered

    shown: list[tuple[int, RawData]] = []

    def recorded(behaviour: int, raw: RawData) -> int:
        shown.append((behaviour, raw))
        return behaviour

    def wheels(behaviour: int, raw: RawData) -> Any:
        left, right, arm, jaw = learned(behaviour, raw)
        return np.array((left / 20, right / 20, 2.0 * (arm == ARM_RAISED) - 1.0, 2.0 * (jaw == JAW_CLOSED) - 1.0))

    forages("Corridor", range(12), recorded)
    motors = [command(*step, DEFAULT_VALUES) for step in shown]
    learned = learned_command([raw for _, raw in shown], [behaviour for behaviour, _ in shown], motors)
    assert forages("CorridorWheels", range(100, 106), wheels) >= 1
