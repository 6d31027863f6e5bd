"""`benchmarks/further_work.py`: every experiment gives a page, a picture and rows that agree with each other."""

from pathlib import Path

import numpy as np
import pytest
from further_experiments import alternative_policies
from further_experiments.alternative_policies import (
    PATIENCE,
    StateLabels,
    UntilGoal,
    first_vectors,
    goal_reached,
)

from khepera_forage.experience import Experience
from khepera_forage.task.states import Behaviour, StateVector
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import is_picture, read
from tests.benchmarks.test_scripts import EXPERIMENTS, SCRIPTS
from tests.version_0_1 import VALUES

WITHOUT_RECALLS = {"several_learners"}
Rows = list[dict[str, str]]


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("further_work")


def rows_of(out: Path, name: str, kind: str = "recalls", **wanted: str) -> Rows:
    rows = read(out / name / f"{kind}.csv")
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def test_every_experiment_has_page_picture_tables_and_rows(out: Path) -> None:
    assert {folder.name for folder in out.iterdir()} == set(EXPERIMENTS)
    for name in EXPERIMENTS:
        assert is_picture(out / name / f"{name}.png")
        assert read(out / name / "trainings.csv")
        assert bool(read(out / name / "recalls.csv")) is (name not in WITHOUT_RECALLS)
        page = (out / name / f"{name}.md").read_text(encoding="utf-8")
        assert f"]({name}.png)" in page


def test_every_claim_is_printed_and_answered_on_its_page(out: Path) -> None:
    printed = (out.parent / "printed").read_text(encoding="utf-8")
    for name in EXPERIMENTS:
        claims = read(out / name / "table_claims.csv")
        page = (out / name / f"{name}.md").read_text(encoding="utf-8")
        assert claims
        for claim in claims:
            assert claim["verdict"] == "undecided", "one replication gives no interval"
            assert f"| {claim['claim']} | {claim['effect']} |" in printed
            assert f"- **{claim['claim']}: undecided.** " in page


@pytest.mark.parametrize("name", sorted(set(EXPERIMENTS) - WITHOUT_RECALLS))
def test_table_is_that_of_the_rows(out: Path, name: str) -> None:
    key = {"chains_of_learners": "generation", "human_teacher": "delay"}.get(name, "episodes")
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


def places_of(out: Path, name: str) -> dict[tuple[str, str], set[tuple[str, ...]]]:
    """The seeds of the recalls in each replication and arena, under every condition and after every amount."""
    seeds: dict[tuple[str, str], set[tuple[str, ...]]] = {}
    groups: dict[tuple[str, ...], list[str]] = {}
    for row in rows_of(out, name):
        where = (row["replication"], row["arena"])
        groups.setdefault((*where, row["condition"], row["amount"]), []).append(row["seed"])
    for (replication, arena, *_), numbers in groups.items():
        seeds.setdefault((replication, arena), set()).add(tuple(numbers))
    return seeds


def test_conditions_share_their_places(out: Path) -> None:
    for name in sorted(set(EXPERIMENTS) - WITHOUT_RECALLS):
        seeds = places_of(out, name)
        assert len(seeds) == 2
        assert all(len(kinds) == 1 for kinds in seeds.values())


def test_trainings_agree_with_themselves(out: Path) -> None:
    for name in EXPERIMENTS:
        for row in rows_of(out, name, "trainings"):
            true, vectors, rounds, everything = (
                int(row[key]) for key in ("true", "vectors", "rounds", "all_rounds")
            )
            assert 0 <= true <= vectors <= rounds <= everything
            assert (int(row["attempts"]) == 1) is (rounds == everything)


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
        return sum(
            int(row["delivered"]) for row in rows_of(out, "different_robots", condition=condition, amount="0")
        )

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
        name: tuple(
            (row["steps"], row["correct"]) for row in rows_of(out, "alternatives", condition=name, amount="2")
        )
        for name in ("as in the thesis", "highest confidence", "threshold 0.2", "until the goal, all vectors")
    }
    assert len(set(ends.values())) == len(ends)


def test_only_the_experiments_given_are_run(quick_run: QuickRun) -> None:
    out = quick_run("further_work", *(SCRIPTS["further_work"].repeatable or ()))
    assert {folder.name for folder in out.iterdir()} == {"spatial_variety"}


def test_replications_have_places_of_their_own(quick_run: QuickRun) -> None:
    seeds = places_of(
        quick_run("further_work", *(SCRIPTS["further_work"].repeatable or ())), "spatial_variety"
    )
    assert len(seeds) == 4
    assert all(len(kinds) == 1 for kinds in seeds.values())
    assert len(set.union(*seeds.values())) == 4


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
    monkeypatch.setattr(alternative_policies, "DECISIONS", VALUES)
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


def test_first_vectors_are_the_first_vector_of_every_behaviour() -> None:
    heard = [0, 0, 1, 1, 0, 2]
    vectors = [FAR._replace(robot_home_distance=90 - i) for i in range(6)]
    first = first_vectors(Experience(vectors, heard))
    assert [vector.robot_home_distance for vector in first.vectors] == [90, 88, 86, 85]
    assert list(first.behaviours) == [0, 1, 0, 2]


def test_state_labels_draw_any_behaviour_in_a_state_without_record() -> None:
    learner = StateLabels.heard([Experience([FAR, CLOSE], [0, 1])], 20)
    rng = np.random.default_rng(0)
    assert {learner.act(FAR, rng) for _ in range(20)} == {Behaviour.SEARCH_FOR_FOOD}
    assert len({learner.act(HOME, rng) for _ in range(100)}) == 10
    with pytest.raises(TypeError, match="rng is None"):
        learner.act(FAR)
