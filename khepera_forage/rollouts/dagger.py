"""DAgger (Ross, Gordon and Bagnell 2011): the learner forages, and asks the teacher about where it gets to.

Imitation as in the thesis records only what the learner perceives beside its teacher; alone, it comes to perceptions
that it has no record of. Here the teacher says what it would do in exactly those.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies import Policy, Teacher, state_vector_of
from khepera_forage.policies.adapters import ClassifierPolicy
from khepera_forage.task.states import StateVector

Arrays = tuple[NDArray[np.int64], NDArray[np.int64]]


class Round(NamedTuple):
    """What a round of queries showed.

    Attributes:
        queries: Queries in it.
        agreed: How many times what was executed is what the teacher said; all of them while the teacher drives.
        delivered: Food brought home.
        episodes: Forages that ended.
    """

    queries: int
    agreed: int
    delivered: int
    episodes: int


class Dagger(NamedTuple):
    """What came out.

    Attributes:
        policy: Fitted on all queries; it learns no further.
        vectors: State vectors asked about, of shape (n, 5), those given at the start first.
        behaviours: What the teacher said on each.
        rounds: One a round.
    """

    policy: Policy
    vectors: NDArray[np.int64]
    behaviours: NDArray[np.int64]
    rounds: tuple[Round, ...]


def dagger(
    make: Callable[[], Any],
    env: BehavioursEnv,
    queries: int,
    seed: int,
    *,
    queries_a_round: int = 100,
    sample: bool = True,
    start: Arrays | None = None,
    expert: Policy | None = None,
) -> Dagger:
    """Ask the teacher, learn from all it said so far, forage with what was learned, and again.

    Every step of every forage is one query. In the first round the teacher itself drives, unless there is experience
    to start from; then always the learner does, as it is after the rounds before. A forage that a round does not end
    goes on in the next.

    Args:
        make: Makes a classifier with `fit` and `predict_proba`, not fitted; called once a round.
        env: From `recalling.recall_env`; where the learner forages.
        queries: How many in all.
        seed: Of places, noise, and the learner's draws.
        queries_a_round: Between two fits.
        sample: Whether the learner draws behaviours with their probabilities, or executes the most probable one.
        start: Experience vectors and behaviours to start from, recorded in training, for which nothing is asked.
        expert: Who is asked; by default the teacher.

    Raises:
        ValueError: No queries.
    """
    if queries < 1 or queries_a_round < 1:
        raise ValueError(f"{queries} queries, {queries_a_round} a round; allowed: at least 1")
    teacher = expert if expert is not None else Teacher(env.home_radius)
    vectors: list[StateVector] = []
    said: list[int] = []
    if start is not None:
        vectors += [StateVector(*vector) for vector in start[0].tolist()]
        said += start[1].tolist()
    driver = _fitted(make, vectors, said, sample) if vectors else teacher
    draws = np.random.default_rng((seed, 1))
    observation, info = env.reset(seed=seed)
    rounds = []
    while queries > 0:
        asked = min(queries, queries_a_round)
        agreed = delivered = episodes = 0
        for _ in range(asked):
            word = int(teacher.act(observation, draws))
            action = int(driver.act(observation, draws))
            vectors.append(state_vector_of(observation))
            said.append(word)
            agreed += action == word
            observation, _, terminated, truncated, info = env.step(action)
            if terminated or truncated:
                delivered += info["delivered"]
                episodes += 1
                observation, info = env.reset()
        rounds.append(Round(asked, agreed, delivered, episodes))
        driver = _fitted(make, vectors, said, sample)
        queries -= asked
    return Dagger(driver, np.array(vectors), np.array(said), tuple(rounds))


def _fitted(make: Callable[[], Any], vectors: list[StateVector], said: list[int], sample: bool) -> Policy:
    return ClassifierPolicy(make().fit(np.array(vectors), np.array(said)), sample, remember=True)
