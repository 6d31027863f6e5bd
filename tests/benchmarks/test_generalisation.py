"""`benchmarks/generalisation.py`: recalls of any classifier in any arena, and what wrong decisions are due to."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import generalisation
import numpy as np
import pytest
from arena_generalisation import method_texts
from arena_generalisation.analysis import Analysis
from arena_generalisation.attribution import CHANGES, Visits, wrong_decisions
from arena_generalisation.batch_recalls import arena_batch, recall_all
from arena_generalisation.decision_table import Decider, DecisionTable
from arena_generalisation.joined_envs import JoinedVectorEnv
from arena_generalisation.learning import imitating_learners
from arena_generalisation.recall_arenas import named_arenas, procedural_arenas
from arena_generalisation.reinforcement import reinforcement_learners, varied_envs
from arena_generalisation.rows import AS_IT_IS, IMITATOR, ArenaRecalls
from arena_generalisation.size import Size
from arena_generalisation.trainings import (
    CORRIDOR,
    EPISODES,
    HALF,
    MOVED,
    VARIED,
    WHOLE,
    Training,
    corridor_trainings,
    training_arenas,
    varied_arenas,
    varied_trainings,
)
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from khepera_forage.comparison.units import missing_extra
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.experiments.arguments import parse
from khepera_forage.experiments.row_folder import RowFolder
from khepera_forage.policies import NearestNeighbourImitator
from khepera_forage.policies.learners import FromSteps
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES, Decisions
from khepera_forage.task.states import NUM_BEHAVIOURS, Behaviour, State, StateVector, classify
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytestmark = pytest.mark.skipif(
    find_spec("numba") is None, reason="the compiled backend needs numba, the extra `fast`"
)

FOOD = StateVector._fields.index("robot_food_distance")
HOME = StateVector._fields.index("robot_home_distance")
DIFFICULTIES = ("easy", "medium")
SEARCH = StateVector(0, 80, 0, 215, 60)
NEXT = StateVector(0, 80, 0, 215, 10)


class TeachersTree:
    """The teacher as a classifier of state vectors, which counts the vectors that it classifies."""

    classes_ = np.arange(NUM_BEHAVIOURS)

    def __init__(self, home_radius: int) -> None:
        self.home_radius = home_radius
        self.classified: list[StateVector] = []

    def predict_proba(self, rows: NDArray[np.int64]) -> NDArray[np.float64]:
        vectors = [StateVector(*row) for row in rows.tolist()]
        self.classified += vectors
        states = [classify(vector, self.home_radius, DEFAULT_VALUES) for vector in vectors]
        return np.eye(NUM_BEHAVIOURS)[states]


class Undecided:
    """SEARCH FOR FOOD in 30 % and GO HOME in 70 % of the decisions."""

    classes_ = np.array([Behaviour.SEARCH_FOR_FOOD, Behaviour.GO_HOME])

    def predict_proba(self, rows: NDArray[np.int64]) -> NDArray[np.float64]:
        return np.tile([0.3, 0.7], (len(rows), 1))


@pytest.fixture(scope="module")
def corridor() -> dict[str, Training]:
    return corridor_trainings(0, 0)


def test_decision_table_classifies_each_vector_once() -> None:
    tree = TeachersTree(16)
    table = DecisionTable([Decider(tree, sample=True)])
    vectors, rng = np.array([SEARCH, NEXT, SEARCH]), np.random.default_rng(0)
    expected = [Behaviour.SEARCH_FOR_FOOD, Behaviour.ORIENT_WITH_FOOD, Behaviour.SEARCH_FOR_FOOD]
    for _ in range(2):
        assert table.decide(np.zeros(3, np.int64), vectors, rng).tolist() == expected
    assert sorted(tree.classified) == sorted([SEARCH, NEXT])
    visited, levels, times = table.visited(0)
    assert dict(zip(map(tuple, visited.tolist()), times.tolist(), strict=True)) == {SEARCH: 4, NEXT: 2}
    assert levels.sum(axis=1).tolist() == [1, 1]


def test_decision_table_draws_behaviours_with_their_probabilities() -> None:
    table = DecisionTable([Decider(Undecided(), sample=True), Decider(Undecided(), sample=False)])
    vectors, rng = np.tile(SEARCH, (4_000, 1)), np.random.default_rng(0)
    drawn = table.decide(np.repeat([0, 1], 2_000), vectors, rng)
    assert set(drawn[:2_000].tolist()) == {Behaviour.SEARCH_FOR_FOOD, Behaviour.GO_HOME}
    assert (drawn[:2_000] == Behaviour.GO_HOME).mean() == pytest.approx(0.7, abs=0.04)
    assert (drawn[2_000:] == Behaviour.GO_HOME).all()


@pytest.mark.parametrize("name", ["corridor", "mixed_foods"])
def test_classifier_that_decides_like_the_teacher_forages_like_the_teacher(name: str) -> None:
    from khepera_forage.rollouts.compiled import recalls

    (arena,) = named_arenas([name])
    tree = TeachersTree(arena_map_of(checked_arena(arena.arena, DEFAULT_DECISIONS)).home_radius)
    seeds = [3, 1, 4, 15]
    batch = arena_batch(arena, [0], seeds)
    recall_all([batch], DecisionTable([Decider(tree, sample=True)]), np.random.default_rng(0))
    teacher = recalls.run_recalls(
        arena.arena, None, np.full(4, recalls.TEACHER), np.array(seeds), **arena.arguments
    )
    for field in ("score", "steps", "delivered", "poison_home"):
        assert getattr(batch, field).tolist() == getattr(teacher, field).tolist()
    assert (batch.delivered <= batch.not_poisonous).all()
    assert batch.delivered.sum() >= 0.9 * batch.not_poisonous.sum()


def test_behaviours_hold_for_their_rounds() -> None:
    (arena,) = named_arenas(["corridor"])
    batch = arena_batch(arena.limited(58), [0, 1], [3, 1])
    table = DecisionTable([Decider(Undecided(), sample=True, hold=hold) for hold in (5, 1)])
    executed = []
    while not batch.over.all():
        deciding = batch.deciding(table.holds)
        batch.step(
            deciding,
            table.decide(
                batch.deciders[deciding], batch.vectors[deciding], np.random.default_rng(batch.rounds)
            ),
        )
        executed.append(batch.behaviours.copy())
    held, free = np.array(executed)[:, :2], np.array(executed)[:, 2:]
    assert batch.steps.tolist() == [58] * 4
    assert all((held[begin : begin + 5] == held[begin]).all() for begin in range(0, 58, 5))
    assert not all((free[begin : begin + 5] == free[begin]).all() for begin in range(0, 58, 5))
    assert [table.visited(number)[2].sum() for number in range(2)] == [2 * 12, 2 * 58]


def test_corridor_trainings_share_their_episodes(corridor: dict[str, Training]) -> None:
    half, whole, moved = (corridor[name] for name in (HALF, CORRIDOR, MOVED))
    assert np.unique(whole.episodes).tolist() == list(range(EPISODES))
    assert np.unique(half.episodes).tolist() == list(range(EPISODES // 2))
    assert half.vectors.tolist() == whole.vectors[: len(half.vectors)].tolist()
    # The food of figure 5.1 lies 78 pixels from the start; random places differ from episode to episode.
    first = [
        {int(own.vectors[own.episodes == k][0, FOOD]) for k in range(EPISODES)} for own in (whole, moved)
    ]
    assert len(first[0]) < len(first[1])


def test_varied_training_has_as_many_vectors_as_asked_for() -> None:
    varied, whole = varied_trainings(0, 0, 300, DIFFICULTIES, DEFAULT_DECISIONS).values()
    assert len(varied.vectors) == 300 < len(whole.vectors)
    assert set(map(tuple, varied.vectors.tolist())) <= set(map(tuple, whole.vectors.tolist()))
    assert np.unique(whole.episodes).tolist() == list(range(EPISODES))
    path = varied_trainings(0, 0, 300, DIFFICULTIES, Decisions(distances="along the path"))[WHOLE]
    assert path.vectors[:, HOME].mean() > whole.vectors[:, HOME].mean()


def test_varied_arenas_are_those_of_the_varied_training() -> None:
    arenas = varied_arenas(0, 0, DIFFICULTIES)
    assert [arena.group for arena in arenas] == list(DIFFICULTIES) * 5
    assert {arena.name for arena in training_arenas(0, DIFFICULTIES)} <= {arena.name for arena in arenas}
    training = varied_trainings(0, 0, 300, DIFFICULTIES, DEFAULT_DECISIONS)[WHOLE]
    for number, arena in enumerate(arenas):
        diagonal = arena_map_of(checked_arena(arena.arena, DEFAULT_DECISIONS)).diagonal
        own = training.vectors[training.episodes == number]
        assert own[:, FOOD].max() <= diagonal, "without food the distance is the diagonal"
    assert len({arena.name for arena in arenas}) == len(arenas)


def test_difficulties_share_the_environments_as_they_share_the_arenas() -> None:
    arenas = [arena for name in DIFFICULTIES for arena in procedural_arenas(name, "train", 0, 1)]
    arenas += procedural_arenas("easy", "train", 1, 1)
    env: Any = varied_envs(arenas)(8)
    limits = [part.batch.limit for part in env.parts for _ in range(part.num_envs)]
    assert limits == [arenas[0].limit] * 5 + [arenas[1].limit] * 3
    env.close()


def test_joined_environments_are_those_of_its_parts() -> None:
    """Episodes end at different times, some worlds begin again alone."""
    joined, (first, second) = JoinedVectorEnv(_parts()), _parts()
    shown, infos = joined.reset(seed=7)
    own: tuple[Any, ...] = first.reset(seed=7)
    other: tuple[Any, ...] = second.reset(seed=9)
    rng, ended = np.random.default_rng(0), 0
    for round_number in range(60):
        for name in shown:
            np.testing.assert_array_equal(shown[name], np.concatenate((own[0][name], other[0][name])))
        np.testing.assert_array_equal(infos["steps"], np.concatenate((own[-1]["steps"], other[-1]["steps"])))
        actions = rng.integers(0, NUM_BEHAVIOURS, 5)
        shown, rewards, terminated, truncated, infos = joined.step(actions)
        own, other = first.step(actions[:2]), second.step(actions[2:])
        results: list[Any] = [rewards, terminated, truncated]
        for found, its, theirs in zip(results, own[1:4], other[1:4], strict=True):
            assert found.tolist() == [*its.tolist(), *theirs.tolist()]
        ends = terminated | truncated
        if ends.any():
            ended += int(ends.sum())
            assert infos["_final_obs"].tolist() == ends.tolist()
            assert [final is not None for final in infos["final_obs"]] == ends.tolist()
            assert infos["final_info"]["steps"][ends].min() >= 20
        if round_number == 30:
            mask = np.array([False, False, True, False, True])
            shown, infos = joined.reset(options={"reset_mask": mask})
            own, other = (own[0], own[-1]), second.reset(options={"reset_mask": mask[2:]})
            assert infos["_steps"].tolist() == mask.tolist()
            infos["steps"][:2] = own[-1]["steps"]
    assert ended == 2 * 3 + 3 * 2, "each of 20 or 26 rounds"
    joined.close()


def test_training_and_test_arenas_differ() -> None:
    training = [
        arena.name for replication in range(3) for arena in training_arenas(replication, DIFFICULTIES)
    ]
    test = [arena.name for name in DIFFICULTIES for arena in procedural_arenas(name, "test", 0, 5)]
    assert len(set(training)) == 6
    assert not set(training) & set(test)


def test_a_wrong_decision_is_put_down_to_its_attribute() -> None:
    """Near food the imitator searches, because of the one vector recorded at that distance from home."""
    training = _training([(NEXT, Behaviour.ORIENT_WITH_FOOD), (SEARCH._replace(robot_home_distance=20), 0)])
    query = NEXT._replace(robot_home_distance=22)
    rows = wrong_decisions(_visits(training, query, 7), training, CORRIDOR, 0)
    found = {row.change: row for row in rows}
    assert tuple(found) == CHANGES
    assert {row.state for row in rows} == {State.NEXT_TO_FOOD.name}
    assert {(row.decisions, row.wrong, row.beyond) for row in rows} == {(7, 7.0, 0.0)}
    assert found["robot_home_distance"].corrected == 7
    assert found["robot_home_distance"].still_wrong == 0
    assert found["robot_food_distance"].still_wrong == found[AS_IT_IS].still_wrong == 7


def test_wrong_decisions_beyond_the_training_are_counted() -> None:
    training = _training([(NEXT, Behaviour.ORIENT_WITH_FOOD)])
    query = SEARCH._replace(robot_food_distance=11, robot_home_distance=81)
    rows = wrong_decisions(
        _visits(training, query._replace(robot_food_distance=50), 3), training, CORRIDOR, 0
    )
    assert {(row.decisions, row.wrong, row.beyond) for row in rows} == {(3, 3.0, 3.0)}


def test_unchanged_distance_is_that_of_the_imitator(corridor: dict[str, Training]) -> None:
    training, rng = corridor[CORRIDOR], np.random.default_rng(0)
    for row in rng.choice(training.vectors, 20):
        moved = np.array([0, rng.integers(-3, 4), 0, 0, rng.integers(-3, 4)])
        query = StateVector(*(row + moved).clip(0).tolist())
        visits = _visits(training, query, 1)
        (unchanged,) = [
            row for row in wrong_decisions(visits, training, CORRIDOR, 0) if row.change == AS_IT_IS
        ]
        assert unchanged.still_wrong == pytest.approx(unchanged.wrong)


def test_values_beyond_all_experience_decide_like_the_nearest_one(corridor: dict[str, Training]) -> None:
    """The reason why the page does not set attributes to the nearest value of the training."""
    training, rng = corridor[CORRIDOR], np.random.default_rng(0)
    imitator = NearestNeighbourImitator(diagonal=400).fit(training.vectors, training.behaviours)
    most = training.vectors.max(axis=0)
    for column in (HOME, FOOD):
        near = rng.choice(training.vectors, 30)
        near[:, column] = most[column]
        far = near.copy()
        far[:, column] += rng.integers(1, 200, len(far))
        assert imitator.predict_proba(far).tolist() == imitator.predict_proba(near).tolist()


def _parts() -> list[BehavioursVectorEnv]:
    """Two easy worlds and three medium ones, with food and limits of their own."""
    parts = []
    for count, limit, name in ((2, 20, "easy"), (3, 26, "medium")):
        (arena,) = procedural_arenas(name, "train", 0, 1)
        settings: dict[str, Any] = {**arena.arguments, "limit": limit}
        mode = AutoresetMode.SAME_STEP
        parts.append(BehavioursVectorEnv(count, arena.arena, autoreset_mode=mode, **settings))
    return parts


def _training(heard: list[tuple[StateVector, int]]) -> Training:
    vectors, behaviours = zip(*heard, strict=True)
    return Training(np.array(vectors), np.array(behaviours, np.int64), np.zeros(len(heard), np.int64))


def _visits(training: Training, query: StateVector, times: int) -> Visits:
    """Decisions of an imitator in one state vector, in the corridor."""
    diagonal = arena_map_of(checked_arena("corridor", DEFAULT_DECISIONS)).diagonal
    imitator: Any = NearestNeighbourImitator(diagonal).fit(training.vectors, training.behaviours)
    vectors = np.array([query])
    (arena,) = named_arenas(["corridor"])
    return Visits(arena, vectors, Decider(imitator, sample=True).levels(vectors), np.array([times]))


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("generalisation")


def test_every_learner_has_a_line_for_each_training(out: Path) -> None:
    for name in ("table_arenas.csv", "table_difficulty.csv"):
        lines = [(row["learner"], row["trained in"]) for row in read(out / name)]
        titles = [learner.title for learner in imitating_learners().values()] + ["DAgger", "DAgger, tree"]
        titles += [one.title for one in reinforcement_learners().values() if not missing_extra(one)]
        trained = [(title, training) for title in titles for training in (CORRIDOR, VARIED)]
        assert lines == [("the teacher", "-"), *trained, ("random behaviours", "-")]


def test_teacher_delivers_most_and_random_behaviours_least(out: Path) -> None:
    rows = read(out / "table_arenas.csv")
    shares = [float(row["family (%)"]) for row in rows]
    assert shares[0] == max(shares) > 75
    assert shares[-1] == min(shares) == 0


def test_learners_forage_for_the_same_food(out: Path) -> None:
    foods: dict[str, set[str]] = {}
    for row in read(out / "recalls.csv"):
        foods.setdefault(row["arena"], set()).add(row["foods"])
        assert 0 <= int(row["delivered"]) <= int(row["foods"])
    assert len(foods) == 6
    assert all(len(found) == 1 for found in foods.values())


def test_changes_are_judged_on_the_same_decisions(out: Path) -> None:
    decisions: dict[tuple[str, ...], list[str]] = {}
    for row in read(out / "wrong_decisions.csv"):
        key = (row["training"], row["arena"], row["state"])
        decisions.setdefault(key, []).append(row["decisions"])
        assert float(row["corrected"]) <= float(row["wrong"]) + 1e-9
        assert float(row["beyond"]) <= float(row["wrong"]) + 1e-9 <= int(row["decisions"]) + 1e-6
    for counts in decisions.values():
        assert len(counts) == len(CHANGES)
        assert len(set(counts)) == 1


def test_page_answers_the_thesis_first(out: Path) -> None:
    page = (out / "generalisation.md").read_text(encoding="utf-8")
    first, *rest = page.split("\n## ")
    assert '"any kind of environment" (4.9, 5.5)' in first
    assert [section.splitlines()[0] for section in rest if section.splitlines()[0].endswith("?")] == [
        "How much does each learner reach in each arena?",
        "How do results fall with difficulty?",
        "Which attribute of the state vector fails where?",
        "What do distances along the path change?",
    ]


def test_page_says_why_learners_on_wheels_are_missing(out: Path) -> None:
    page = (out / "generalisation.md").read_text(encoding="utf-8")
    assert (
        "Learners on wheels (PPO on wheels; SAC on wheels) were left out, because they command motors" in page
    )


def test_page_says_how_often_the_teacher_is_queried(out: Path) -> None:
    page = (out / "generalisation.md").read_text(encoding="utf-8")
    assert "DAgger (behavioural cloning); DAgger, tree (decision tree)." in page
    assert f"Each training has {generalisation.QUICK_QUERIES} queries" in page


def test_page_says_which_learners_were_left_out(out: Path) -> None:
    page = (out / "generalisation.md").read_text(encoding="utf-8")
    printed = (out.parent / "printed").read_text(encoding="utf-8")
    for name, learner in reinforcement_learners().items():
        reason = missing_extra(learner)
        assert (f"`{name}` was left out: {reason}." in page) == bool(reason)
        assert (f"{name} is left out: {reason}" in printed) == bool(reason)


class TestWithoutBaselines:
    """Reinforcement learners cannot be trained here, whatever is installed."""

    REASON = "stable-baselines3 is not installed (pip install 'khepera-forage[baselines]')"
    SIZE = Size(1, 1, ("corridor",), DIFFICULTIES, 1_000)

    @pytest.fixture(autouse=True)
    def missing(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(generalisation, "missing_extra", self.reason)

    def reason(self, learner: Any) -> str:
        return self.REASON if isinstance(learner, FromSteps) else ""

    def test_learners_are_left_out(self, tmp_path: Path) -> None:
        given = parse("generalisation", "", given=["--out", str(tmp_path)])
        units, left_out = generalisation.single(given, self.SIZE, range(2))
        assert [unit.key for unit in units] == ["dagger 0", "dagger 1"]
        assert left_out == dict.fromkeys(reinforcement_learners(), self.REASON)
        found = Analysis([_recalls(IMITATOR)], [], np.random.default_rng(0))
        assert method_texts.left_out(left_out).startswith(f"`ppo` was left out: {self.REASON}.")
        assert method_texts.reinforcement(found, 1_000) == method_texts.querying(found) == ""

    def test_learners_with_rows_of_an_earlier_run_take_part(self, tmp_path: Path) -> None:
        folder = RowFolder(tmp_path, generalisation.TABLES, {})
        for key in ("ppo 0", "ppo 1", "dqn 0"):
            folder.add(key, [_recalls(key.split()[0])])
        folder.close([])
        given = parse("generalisation", "", given=["--out", str(tmp_path)])
        units, left_out = generalisation.single(given, self.SIZE, range(2))
        assert [unit.key for unit in units] == ["dagger 0", "dagger 1", "ppo 0", "ppo 1"]
        assert left_out == {"dqn": self.REASON}
        given = parse("generalisation", "", given=["--out", str(tmp_path), "--fresh"])
        units, _ = generalisation.single(given, self.SIZE, range(2))
        assert [unit.key for unit in units] == ["dagger 0", "dagger 1"]


def _recalls(learner: str) -> ArenaRecalls:
    return ArenaRecalls(learner, CORRIDOR, "straight", 0, "thesis", "corridor", 0, 1, 1, 1, 0, 50.0, 90)
