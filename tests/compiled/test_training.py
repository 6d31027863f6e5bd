"""Training in the kernel against `TrainingEnv` over the same bodies, without noise, round by round."""

from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from khepera_forage.envs.arguments import timing_of
from khepera_forage.envs.compiled import pairs
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies.policy import HEARD
from khepera_forage.rollouts.compiled.training import Trained, train_learners
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.rollouts.training import train
from khepera_forage.sim.arena import Arena, Pose, copies
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import CORRIDOR, V0_1

ARENAS = copies(CORRIDOR, 2)


def _check_same(trained: Trained, experience: Experience, rows: list[TrainingRow]) -> None:
    """The same behaviours heard, and the same state vectors."""
    vectors, heard = experience.arrays()
    mine = trained.vectors_of(0)
    assert mine[:, HEARD].tolist() == heard.tolist()
    assert mine[:, :HEARD].tolist() == vectors.tolist()
    attempts = trained.attempts
    assert attempts.rounds.tolist() == [row.rounds for row in rows]
    assert attempts.separations.tolist() == [row.separations for row in rows]


@pytest.mark.parametrize("food_type", ["pickable", "pushable", "poisonous"])
def test_without_noise_a_learner_records_the_experience_that_it_records_in_the_environment(
    food_type: str,
) -> None:
    env = TrainingEnv(noise=Noise.none(), food_types=food_type, backend="compiled")
    single = train(env, np.random.SeedSequence(0))
    _check_same(train_learners(1, noise=Noise.none(), food_types=food_type), *single)
    avoided = Behaviour.AVOID_FOOD in single[0].behaviours
    assert avoided == (food_type == "poisonous")


def _learner_beside_its_mark(
    monkeypatch: pytest.MonkeyPatch, ahead: float, aside: float, turned: float
) -> tuple[Arena, Arena]:
    """The paired corridors with another mark for the learner."""
    x, y, heading = ARENAS[1].start
    arenas = ARENAS[0], replace(ARENAS[1], start=Pose(x + ahead, y + aside, heading + turned))
    monkeypatch.setattr(pairs, "copies", lambda arena, count: arenas)
    return arenas


def _environment(arenas: tuple[Arena, Arena], decisions: Decisions = V0_1, **kwargs: Any) -> TrainingEnv:
    world = CompiledWorld(arenas, (1, 2), Noise.none(), timing=timing_of(decisions))
    return TrainingEnv(noise=Noise.none(), world=world, decisions=decisions, **kwargs)


@pytest.mark.parametrize(
    ("ahead", "aside", "turned", "separations"),
    [(0.0, 20.0, 0.3, 0), (-30.0, -10.0, 0.3, 0), (100.0, -10.0, 0.3, 1), (90.0, 20.0, -0.5, 3)],
)
def test_a_learner_beside_its_mark_is_led_and_waited_for_as_in_the_environment(
    ahead: float, aside: float, turned: float, separations: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Following and recovery: beyond 70 mm the teacher waits."""
    arenas = _learner_beside_its_mark(monkeypatch, ahead, aside, turned)
    experience, rows = train(_environment(arenas), np.random.SeedSequence(0), attempts=1)
    _check_same(train_learners(1, noise=Noise.none(), attempts=1, decisions=V0_1), experience, rows)
    assert rows[0].separations == separations


@pytest.mark.parametrize(
    ("changes", "mark"),
    [
        ({"round_duration": 0.2}, (-30.0, -10.0, 0.3)),
        ({"arm_travel_time": 0.5}, (-30.0, -10.0, 0.3)),
        ({"close_to_food": 35}, (-30.0, -10.0, 0.3)),
        ({"equal_distance": "farther state"}, (-30.0, -10.0, 0.3)),
        ({"home_speed": 10}, (-30.0, -10.0, 0.3)),
        ({"separation": 20}, (90.0, 20.0, -0.5)),
        ({"following_gain": 0.2}, (90.0, 20.0, -0.5)),
    ],
    ids=str,
)
def test_decisions_change_training_as_in_the_environment(
    changes: dict[str, Any], mark: tuple[float, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    arenas, decisions = _learner_beside_its_mark(monkeypatch, *mark), Decisions.from_changes(changes, V0_1)
    single = train(_environment(arenas, decisions), np.random.SeedSequence(0), attempts=1)
    compiled = train_learners(1, noise=Noise.none(), attempts=1, decisions=decisions)
    _check_same(compiled, *single)
    usual = train_learners(1, noise=Noise.none(), attempts=1, decisions=V0_1)
    assert not np.array_equal(compiled.experience, usual.experience)


def test_an_attempt_ends_in_the_same_round_as_in_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the smallest limit and patience an attempt is complete; with one round less it is not."""
    arenas = _learner_beside_its_mark(monkeypatch, 90.0, 20.0, -0.5)
    env, separated = _environment(arenas), [0]
    _, rows = train(
        env,
        np.random.SeedSequence(0),
        callback=lambda: separated.append(env.infos["learner_0"]["separated_rounds"]),
    )
    rounds, longest = rows[0].rounds, max(separated)
    assert longest > 3
    for patience, max_cycles, complete in (
        (longest + 1, rounds, True),
        (longest, rounds, False),
        (longest + 1, rounds - 1, False),
    ):
        terms: dict[str, Any] = {"patience": patience, "max_cycles": max_cycles}
        with nullcontext() if complete else pytest.raises(RuntimeError, match="none of 1 attempts"):
            train(_environment(arenas, **terms), np.random.SeedSequence(0), attempts=1)
        with nullcontext() if complete else pytest.raises(RuntimeError, match="none of 1 attempts"):
            train_learners(1, noise=Noise.none(), attempts=1, decisions=V0_1, **terms)
