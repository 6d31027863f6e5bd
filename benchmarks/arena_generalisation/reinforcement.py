"""Reinforcement learners: trained for the environment's reward in the corridor or in varied arenas."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from arena_generalisation.contestants import Contestant
from arena_generalisation.joined_envs import JoinedVectorEnv
from arena_generalisation.recall_arenas import RecallArena
from arena_generalisation.size import Size
from arena_generalisation.trainings import CORRIDOR, VARIED, varied_arenas
from khepera_forage.comparison.units import all_learners
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv
from khepera_forage.policies.features import state_vector_features
from khepera_forage.policies.learners import FromSteps
from khepera_forage.policies.model_policy import ModelPolicy, behaviour_probabilities
from khepera_forage.rollouts.reinforcement import MakeEnv, reinforce
from khepera_forage.task.states import NUM_BEHAVIOURS


def reinforcement_learners() -> dict[str, FromSteps]:
    """All reinforcement learners that act with behaviours, those of installed packages too, by name."""
    return _learners(wheels=False)


def wheels_learners() -> dict[str, FromSteps]:
    """All reinforcement learners that command motors, and cannot take part, by name."""
    return _learners(wheels=True)


def _learners(wheels: bool) -> dict[str, FromSteps]:
    return {
        name: learner
        for name, learner in all_learners().items()
        if isinstance(learner, FromSteps) and learner.wheels == wheels
    }


class ModelClassifier:
    """A trained model as a classifier of state vectors.

    Args:
        policy: From `reinforce`, with behaviours as actions.
    """

    classes_ = np.arange(NUM_BEHAVIOURS)

    def __init__(self, policy: ModelPolicy) -> None:
        self._policy = policy

    def predict_proba(self, vectors: NDArray[np.int64]) -> NDArray[np.float64]:
        """The probability of each behaviour; 1 for that of a model which does not draw."""
        shown, model = state_vector_features(vectors), self._policy.model
        if self._policy.sample:
            return behaviour_probabilities(model, shown)
        levels = np.zeros((len(vectors), NUM_BEHAVIOURS))
        levels[np.arange(len(vectors)), model.predict(shown, deterministic=True)[0]] = 1.0
        return levels


def reinforced(
    name: str, learner: FromSteps, replication: int, run_seed: int, seed: int, size: Size
) -> list[Contestant]:
    """A reinforcement learner, trained in the corridor and, for as many steps, in varied arenas.

    Args:
        name: Of the learner.
        learner: From `reinforcement_learners`.
        replication: Its number.
        run_seed: Of the whole run: the varied arenas are those of the replication's imitators.
        seed: Of random choices.
        size: Of the run.
    """
    varied = varied_envs(varied_arenas(run_seed, replication, size.difficulties))
    found = []
    for training, make_env in ((CORRIDOR, None), (VARIED, varied)):
        (trained,) = reinforce(learner, [size.steps], seed, make_env, learner.worlds)
        classifier = ModelClassifier(trained.policy)
        found.append(Contestant(name, training, classifier, learner.sample, hold=learner.hold))
    return found


def varied_envs(arenas: Sequence[RecallArena]) -> MakeEnv:
    """A function that makes environments in many arenas; arenas of the same difficulty have the same settings.

    Every episode takes place in an arena of the environment's difficulty, drawn at random.

    Args:
        arenas: Each difficulty has as large a share of the environments as of these arenas, within one environment.
    """
    groups: dict[str, list[RecallArena]] = {}
    for arena in arenas:
        groups.setdefault(arena.group, []).append(arena)

    def make(count: int) -> JoinedVectorEnv:
        shares = dict.fromkeys(groups, 0)
        for number in range(count):
            shares[arenas[number % len(arenas)].group] += 1
        return JoinedVectorEnv([_envs(groups[name], share) for name, share in shares.items() if share])

    return make


def _envs(arenas: Sequence[RecallArena], count: int) -> BehavioursVectorEnv:
    settings: dict[str, Any] = dict(arenas[0].arguments)
    mode = AutoresetMode.SAME_STEP
    return BehavioursVectorEnv(count, [arena.arena for arena in arenas], autoreset_mode=mode, **settings)
