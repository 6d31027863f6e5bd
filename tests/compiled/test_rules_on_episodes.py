"""Pairing, account of an episode and behaviours: the same in Python and on records in compiled code."""

from typing import Any

import numpy as np
import pytest

from khepera_forage.compilation.decorators import entrance
from khepera_forage.envs.compiled import rules  # noqa: F401 (registers the rules)
from khepera_forage.envs.compiled.parameters import (
    arena_map,
)
from khepera_forage.envs.compiled.records import (
    episode_dtype,
    food_object_dtype,
    tracker_dtype,
)
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.robots.khepera import Motors
from khepera_forage.rollouts.compiled.records import decision_dtype, pair_dtype
from khepera_forage.sim.arena import copies
from khepera_forage.sim.compiled import tracking  # noqa: F401 (registers the rules of association)
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.episode import (
    DecisionCounts,
    Episode,
    begin_episode,
    count_decision,
    end_step,
    has_done_its_part,
)
from khepera_forage.task.food_tracking import (
    FoodObject,
    FoodTracker,
)
from khepera_forage.task.pairing import Pairing, lead, update_pairing
from khepera_forage.task.perception import RawData
from khepera_forage.task.scoring import penalty, score
from khepera_forage.task.states import Behaviour, StateVector, classify
from tests.compiled.rule_records import DECISIONS, IDS, check_same, records, task_of
from tests.task.raw_data import OPEN_FLOOR, placed
from tests.version_0_1 import CORRIDOR


@entrance
def _pair(
    pair: Any, learner: Any, task: Any, teacher: Any, teacher_task: Any, motors: Any, behaviour: int, led: Any
) -> None:
    decisions = task.decisions[0]
    update_pairing(
        pair[0],
        learner[0],
        learner[1],
        arena_map(task),
        teacher[0],
        teacher[1],
        teacher[2],
        arena_map(teacher_task),
        decisions,
    )
    own = Motors(motors[0], motors[1], int(motors[2]), int(motors[3]))
    bent = lead(pair[0], own, behaviour, learner[0], learner[1], learner[2], decisions)
    led[0], led[1], led[2], led[3] = bent.left, bent.right, bent.arm, bent.jaw


@pytest.mark.parametrize("decisions", DECISIONS, ids=IDS)
def test_pairing_is_the_same_on_records(decisions: Decisions) -> None:
    rng, arenas = np.random.default_rng(0), copies(CORRIDOR, 2)
    maps, tasks = [arena_map_of(arena) for arena in arenas], [task_of(arena, decisions) for arena in arenas]
    offset, values = maps[1].home_y - maps[0].home_y, decisions.values()
    bent = separations = 0
    for _ in range(40):
        pairing = Pairing()
        record = records(pair_dtype, [pairing])
        place = rng.uniform((30, 10), (100, 35))
        for _ in range(30):
            degrees = float(rng.integers(0, 360))
            teacher = (float(place[0]), float(place[1]), degrees)
            x, y = (place + rng.normal(0, 6, 2)).tolist()
            learner = (x, y + offset, (degrees + float(rng.integers(-20, 21))) % 360)
            behaviour = int(rng.integers(0, 11))
            left, right = rng.choice((0.0, 4.0, 8.0, 12.0, -5.0), 2).tolist()
            own, led = Motors(left, right, 215, 200), np.zeros(4)
            update_pairing(pairing, learner[0], learner[1], maps[1], *teacher, maps[0], values)
            expected = lead(pairing, own, behaviour, *learner, values)
            _pair(
                record,
                np.array(learner),
                tasks[1],
                np.array(teacher),
                tasks[0],
                np.array(own),
                behaviour,
                led,
            )
            check_same(record, [pairing])
            assert led == pytest.approx(expected, abs=1e-9)
            bent += expected != own
        separations += pairing.separations
    assert bent > 100
    assert separations > 40


@entrance
def _step(
    episode: Any, tracker: Any, after: Any, correct: bool, limit: int, begins: bool
) -> tuple[float, float]:
    if begins:
        begin_episode(episode[0], tracker[0])
    end_step(episode[0], after[0], correct, limit)
    lost = penalty(after[0].delivered, after[0].deliverable)
    return score(episode[0].correct, episode[0].steps, lost), lost


def test_account_of_an_episode_is_the_same_on_records() -> None:
    rng = np.random.default_rng(0)
    python: Any = _step.py_func  # type: ignore[attr-defined]
    ends = set()
    for _ in range(60):
        episode, limit = Episode(), int(rng.integers(1, 30))
        record, tracker = records(episode_dtype, [episode]), FoodTracker(deliverable=3)
        for number in range(30):
            after = FoodTracker(
                delivered=min(3, tracker.delivered + int(rng.random() < 0.1)),
                poison_home=tracker.poison_home + int(rng.random() < 0.1),
                deliverable=3,
            )
            correct = bool(rng.integers(0, 2))
            scored = python([episode], [tracker], [after], correct, limit, number == 0)
            before, then = records(tracker_dtype, [tracker]), records(tracker_dtype, [after])
            assert _step(record, before, then, correct, limit, number == 0) == scored
            check_same(record, [episode])
            ends.add((episode.terminated, episode.truncated))
            tracker = after
    assert ends == {(False, False), (True, False), (False, True)}


@entrance
def _judge(counts: Any, tracker: Any, foods: Any, vector: Any, behaviour: int, task: Any) -> tuple[bool, int]:
    arena, decisions = arena_map(task), task.decisions[0]
    perceived = StateVector(vector[0], vector[1], vector[2], vector[3], vector[4])
    state = classify(perceived, arena.home_radius, decisions).value
    count_decision(counts[0], state, behaviour, perceived.robot_food_distance, decisions)
    return has_done_its_part(tracker[0], foods, perceived, arena.home_radius, decisions), state


@pytest.mark.parametrize("decisions", DECISIONS, ids=IDS)
def test_states_and_their_account_are_the_same_on_records(decisions: Decisions) -> None:
    rng, arena, task, values = (
        np.random.default_rng(0),
        arena_map_of(CORRIDOR),
        task_of(CORRIDOR, decisions),
        decisions.values(),
    )
    counts = DecisionCounts()
    record = np.zeros(1, decision_dtype)
    done, states = 0, set()
    for _ in range(3000):
        vector = StateVector(
            int(rng.integers(0, 2)),
            int(rng.integers(15, 30)),
            int(rng.integers(0, 4)),
            int(rng.choice((215, 225, 226, 255))),
            int(rng.integers(12, 45)),
        )
        foods = [FoodObject(0.0, 0.0, known=int(rng.choice((0, 1, 3))))]
        tracker = FoodTracker(delivered=int(rng.integers(0, 2)), deliverable=int(rng.integers(0, 2)))
        behaviour = int(rng.integers(0, 10))
        state = classify(vector, arena.home_radius, values)
        count_decision(counts, int(state), behaviour, vector.robot_food_distance, values)
        expected = has_done_its_part(tracker, foods, vector, arena.home_radius, values)
        got = _judge(
            record,
            records(tracker_dtype, [tracker]),
            records(food_object_dtype, foods),
            np.array(vector),
            behaviour,
            task,
        )
        assert got == (expected, state)
        done += expected
        states.add(int(state))
    check_same(record, [counts])
    assert counts.orient_without_food > 10
    assert done > 50
    assert states == set(range(10))


@entrance
def _command(raw: RawData, behaviour: int, task: Any, motors: Any) -> None:
    given = command(behaviour, raw, task.decisions[0])
    motors[0], motors[1], motors[2], motors[3] = given.left, given.right, given.arm, given.jaw


@pytest.mark.parametrize("decisions", DECISIONS[:4], ids=IDS[:4])
@pytest.mark.parametrize("behaviour", Behaviour)
def test_behaviours_command_the_same_motors(behaviour: Behaviour, decisions: Decisions) -> None:
    rng, task, values = np.random.default_rng(0), task_of(CORRIDOR, decisions), decisions.values()
    given = set()
    for _ in range(400):
        raw = placed(
            OPEN_FLOOR,
            proximity=tuple(int(reading) for reading in rng.choice((0, 40, 300, 1023), 6)),
            arm=int(rng.choice((215, 220, 235, 252, 255))),
            jaw=int(rng.choice((0, 20, 60, 198, 200))),
            object_presence=int(rng.choice((0, 255))),
            x=float(rng.uniform(10, 120)),
            y=float(rng.uniform(5, 40)),
            orientation=int(rng.integers(0, 360)),
            food_seen=bool(rng.random() < 0.8),
            food_x=float(rng.uniform(10, 120)),
            food_y=float(rng.uniform(5, 40)),
            wall_distance=float(rng.uniform(4, 20)),
            wall_bearing=float(rng.uniform(-180, 180)),
        )
        motors = np.zeros(4)
        _command(raw, int(behaviour), task, motors)
        expected = command(behaviour, raw, values)
        assert motors == pytest.approx(expected, abs=1e-9)
        given.add(expected)
    assert len(given) > (2 if behaviour not in (Behaviour.EXPLORE_FOOD, Behaviour.AVOID_FOOD) else 0)
