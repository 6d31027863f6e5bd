"""DAgger (Ross, Gordon and Bagnell 2011): the teacher labels the states that the learner visits.

In the thesis a learner records only what it perceives beside the teacher; alone, it reaches states without a record.
With DAgger the learner forages alone, and the teacher's behaviour is recorded in exactly those states.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arguments import whole_number
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies import Policy, Teacher, state_vector_of
from khepera_forage.policies.classifiers import policy_of
from khepera_forage.policies.models import completed
from khepera_forage.rollouts.recall import stopping
from khepera_forage.task.states import StateVector

Arrays = tuple[NDArray[np.int64], NDArray[np.int64]]
"""State vectors and behaviours."""


class DaggerRound(NamedTuple):
    """Counts of one round of queries.

    Attributes:
        queries: Queries to the expert.
        agreed: Queries in which the executed behaviour was the expert's; all of them while the expert itself acts.
        delivered: Food objects brought home in the episodes that ended.
        episodes: Episodes that ended.
    """

    queries: int
    agreed: int
    delivered: int
    episodes: int


class DaggerResult(NamedTuple):
    """The learned policy and the data it learned from.

    Attributes:
        policy: Fitted to all queries.
        vectors: State vectors, of shape (n, 5): those of `start`, then the queries.
        behaviours: The behaviour for each vector.
        rounds: Counts of each round.
    """

    policy: Policy
    vectors: NDArray[np.int64]
    behaviours: NDArray[np.int64]
    rounds: tuple[DaggerRound, ...]


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
) -> DaggerResult:
    """Alternate between foraging, with a query to the expert in every step, and fitting a classifier to all queries.

    In the first round the expert acts, or with `start` a learner fitted to that experience; in later rounds the learner
    of the previous round acts. An episode that has not ended at the end of a round continues in the next.

    Args:
        make: Makes an unfitted classifier with `fit` and `predict_proba`; called once a round.
        env: From `rollouts.recall.recall_env`; the learner forages in it.
        queries: Total number of queries.
        seed: Of places, noise, and random choices of the policies.
        queries_a_round: Queries between two fits.
        sample: Draw behaviours with the classifier's probabilities; otherwise execute the most probable behaviour.
        start: Recorded experience to start from: state vectors and behaviours.
        expert: Policy that labels states; by default the teacher.

    Raises:
        TypeError: `make` makes nothing.
        ValueError: A number of queries or the seed is out of range.
    """
    if not callable(make):
        raise TypeError(f"make is {make!r}; allowed: what makes a classifier when called, such as its class")
    queries, seed = whole_number("queries", queries, 1), whole_number("seed", seed, 0)
    queries_a_round = whole_number("queries_a_round", queries_a_round, 1)
    expert = Teacher() if expert is None else expert
    vectors: list[StateVector] = []
    behaviours: list[int] = []
    if start is not None:
        vectors += [StateVector(*vector) for vector in start[0].tolist()]
        behaviours += start[1].tolist()
    actor = _fitted(make, vectors, behaviours, sample) if vectors else expert
    rng = np.random.default_rng((seed, 1))
    observation, info = env.reset(seed=seed)
    teacher = completed(expert, env)
    rounds = []
    while queries > 0:
        count = min(queries, queries_a_round)
        agreed = delivered = episodes = 0
        with stopping(env.unwrapped):
            for _ in range(count):
                label = int(teacher.act(observation, rng))
                action = label if actor is expert else int(actor.act(observation, rng))
                vectors.append(state_vector_of(observation))
                behaviours.append(label)
                agreed += action == label
                observation, _, terminated, truncated, info = env.step(action)
                if terminated or truncated:
                    delivered += info["delivered"]
                    episodes += 1
                    observation, info = env.reset()
                    teacher = completed(expert, env)
        rounds.append(DaggerRound(count, agreed, delivered, episodes))
        actor = _fitted(make, vectors, behaviours, sample)
        queries -= count
    return DaggerResult(actor, np.array(vectors), np.array(behaviours), tuple(rounds))


def _fitted(make: Callable[[], Any], vectors: list[StateVector], behaviours: list[int], sample: bool) -> Policy:
    classifier = make()
    classifier.fit(np.array(vectors), np.array(behaviours))
    return policy_of(classifier, sample)
