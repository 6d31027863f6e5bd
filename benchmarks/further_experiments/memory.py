"""Two experiments on what the learner does with its records: attribute weights, and alternatives of the thesis."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import groupby, product

import numpy as np

import further_experiments.common as fw
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.estimates import pick
from khepera_forage.experience import Experience
from khepera_forage.policies import ClassifierPolicy, Observation, Policy, Teacher, WeightedImitator
from khepera_forage.policies.policy import state_vector_of
from khepera_forage.rollouts.training import arrays
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import BEHAVIOURS, Behaviour, FoodType, StateVector, behaviour_for, classify, is_raised
from khepera_forage.thesis.claims import Claim, within

SAME = 10.0
"""Points of food delivered within which two places count as equal. Our decision."""
EQUAL, LEARNED = "equal", "learned"
FIXED = {
    "home ×4": (1, 4, 1, 1, 1),
    EQUAL: (1, 1, 1, 1, 1),
    "food ×2": (1, 1, 1, 1, 2),
    "food ×4": (1, 1, 1, 1, 4),
    "food ×8": (1, 1, 1, 1, 8),
}
"""Weights of ObjectPresence, RobotHomeDistance, FoodType, ArmsHeight and RobotFoodDistance."""
TESTED = ("food ×2", "food ×4", "food ×8", LEARNED)


def run_weights(trial: fw.Trial) -> list[fw.Row]:
    """The same training files for all weights, and the same recalls."""
    return fw.train_and_recall(trial, partial(weighted, trial.replication))


def weighted(seed: int, env: BehavioursEnv, files: fw.Files) -> Iterator[fw.Learner]:
    """One learner for each set of weights."""
    if not files:
        return
    vectors, behaviours = arrays(list(files))
    for name, weights in FIXED.items():
        fixed = WeightedImitator(env.diagonal, weights).fit(vectors, behaviours)
        own = fw.imitator(files, env.diagonal) if name == EQUAL else ClassifierPolicy(fixed, remember=True)
        yield name, own, files
    # Cross-validation leaves out whole episodes. Of a single episode nothing would be left, so it leaves out vectors.
    groups = np.repeat(np.arange(len(files)), [len(file) for file in files]) if len(files) > 1 else None
    learned = WeightedImitator(env.diagonal, random_state=seed).fit(vectors, behaviours, groups)
    yield LEARNED, ClassifierPolicy(learned, remember=True), files


def weight_claims(found: fw.Analysis) -> Iterator[Claim]:
    """Whether weights solve area 1, and their effect on the whole task."""
    recalls = {arena: pick(found.recalls, amount=found.amounts[-1], arena=arena) for arena in fw.ARENAS}
    further, about = (fw.at(recalls["corridor"], place) for place in (fw.FURTHER, fw.ABOUT))
    for name in TESTED:
        rows, equal = (pick(further, condition=one) for one in (name, EQUAL))
        statement = f"corridor, food further out: {name} delivers more than equal weights"
        yield found.compared(statement, rows, equal, fw.DELIVERED)
    for name in TESTED:
        statement = f"corridor: with {name} food further out is delivered as often as where it lay in training"
        rows, others = (pick(place, condition=name) for place in (further, about))
        yield found.compared(statement, rows, others, fw.DELIVERED, within(SAME))
    for arena, name in product(fw.ARENAS, TESTED):
        rows, equal = (pick(recalls[arena], condition=one) for one in (name, EQUAL))
        yield found.compared(f"{arena}: {name} scores more than equal weights", rows, equal, fw.SCORE)


ATTRIBUTE_WEIGHTS = fw.Experiment(
    "attribute_weights",
    "Attribute weights",
    "5.4.1.2, 5.5",
    "Does a larger weight of the distance from the food solve area 1?",
    "In training, start, food and home lie on one line. With equal weights, a robot next to food that lies further out "
    "is therefore equally far from all vectors of SEARCH, MOVE SLOWLY and ORIENT; any weight of the food above that of "
    "the home breaks this tie in favour of ORIENT. The distance from the food counts twice, four and eight times; as "
    "a control, the distance from home four times. *Learned*: the weights with the smallest leave-one-out error on "
    "the training files, which contain only one set-up.",
    conditions=("all",),
    run=run_weights,
    claims=weight_claims,
    picture=(fw.SCORE, fw.DELIVERED),
    recalls=(
        "Noise of the laboratory; the same training files and the same recalls for all weights.",
        (fw.SCORE, fw.DELIVERED, fw.STEPS),
    ),
    places=True,
)

DECISIONS = Decisions().values()
PATIENCE = 100
"""Steps after which a behaviour without success ends: ten seconds. Our decision (4.2.1)."""


def goal_reached(behaviour: int, vector: StateVector, home_radius: int) -> bool:
    """Whether the local goal of a behaviour is reached (4.2.1): the robot is where the next behaviour begins."""
    presence, home, food_type, arm, food = vector
    goals = {
        Behaviour.SEARCH_FOR_FOOD: food <= DECISIONS.close_to_food,
        Behaviour.MOVE_SLOWLY: food <= DECISIONS.next_to_food,
        Behaviour.ORIENT_WITH_FOOD: presence,
        Behaviour.EXPLORE_FOOD: food_type != FoodType.UNKNOWN,
        Behaviour.PICK_UP_FOOD: presence and is_raised(arm, DECISIONS),
        Behaviour.PUSH_FOOD: home <= home_radius,
        Behaviour.AVOID_FOOD: not presence,
        Behaviour.GO_HOME: home <= home_radius,
        Behaviour.AVOID_HOME: home > home_radius,
        Behaviour.RELEASE_FOOD: not presence,
    }
    return bool(goals[Behaviour(behaviour)])


class UntilGoal:
    """A policy whose behaviours run until their goal is reached or `PATIENCE` steps have passed.

    It remembers the running behaviour, so every episode needs a new copy. The radius of the home is in pixels.
    """

    def __init__(self, policy: Policy, home_radius: int) -> None:
        self._policy, self._home_radius = policy, home_radius
        self._running: int | None = None
        self._steps = 0

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The behaviour that runs, or the next one."""
        vector = state_vector_of(observation)
        running = self._running
        if running is None or self._steps >= PATIENCE or goal_reached(running, vector, self._home_radius):
            running = self._running = self._policy.act(observation, rng)
            self._steps = 0
        self._steps += 1
        return running


def first_vectors(experience: Experience) -> Experience:
    """The first vector of every behaviour that the teacher began: the one perceptual experience of 4.2.1."""
    first = [next(run) for _, run in groupby(experience, key=lambda pair: pair[1])]
    return Experience([vector for vector, _ in first], [heard for _, heard in first], arena=experience.arena)


@dataclass(frozen=True, slots=True)
class StateLabels:
    """The learner of the first draft (4.5.1): it classifies states, and learns which behaviour belongs to which.

    States and behaviours correspond one to one (4.4.1), so that each state has one behaviour, once it was heard. The
    radius is that of the home in the arena it forages in, in pixels.
    """

    home_radius: int
    heard: frozenset[Behaviour]

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour of the present state; any behaviour if that was never heard."""
        assert rng is not None
        behaviour = behaviour_for(classify(state_vector_of(observation), self.home_radius, DECISIONS))
        if behaviour not in self.heard:
            return BEHAVIOURS[int(rng.integers(len(BEHAVIOURS) - 1))]
        rng.random()  # for the draw among all behaviours of the state
        return behaviour


THESIS, HIGHEST, LABELS = "as in the thesis", "highest confidence", "state labels"
GOAL, GOAL_ALL = "until the goal, one vector each", "until the goal, all vectors"
TEACHER, TEACHER_GOAL = "teacher", "teacher until the goal"
THRESHOLDS = {f"threshold {threshold:g}": threshold for threshold in (0.01, 0.05, 0.2)}
COPY = 5.0
"""Points of score within which two policies count as equal. Our decision."""


def alternatives(env: BehavioursEnv, files: fw.Files) -> Iterator[fw.Learner]:
    """Every learner, and without files the teachers."""
    if not files:
        teacher = Teacher.of(env)
        yield TEACHER, teacher, files
        yield TEACHER_GOAL, UntilGoal(teacher, env.home_radius), files
        return
    thesis = fw.imitator(files, env.diagonal)
    yield THESIS, thesis, files
    yield HIGHEST, ClassifierPolicy(thesis, sample=False, remember=True), files
    for name, threshold in THRESHOLDS.items():
        yield name, fw.imitator(files, env.diagonal, threshold), files
    few = [first_vectors(experience) for experience in files]
    yield GOAL, UntilGoal(fw.imitator(few, env.diagonal), env.home_radius), few
    yield GOAL_ALL, UntilGoal(thesis, env.home_radius), files
    heard = frozenset(behaviour for experience in files for behaviour in experience.behaviours)
    yield LABELS, StateLabels(env.home_radius, heard), files


def alternative_claims(found: fw.Analysis) -> Iterator[Claim]:
    """Whether the thesis chose well."""
    for arena in fw.ARENAS:
        rows = fw.by_condition(pick(found.recalls, arena=arena, amount=found.amounts[-1]))
        for better, worse, statement in (
            (HIGHEST, THESIS, "the highest confidence is better than a random draw"),
            *((THESIS, name, f"a {name.replace(' ', ' of ')} is worse than exact ties") for name in THRESHOLDS),
            (THESIS, GOAL, "deciding at every step is better than running until the goal"),
            (THESIS, GOAL_ALL, "deciding at every step is better with the same vectors, too"),
        ):
            yield found.compared(f"{arena}: {statement}", rows[better], rows[worse], fw.SCORE)
        teacher = pick(found.recalls, condition=TEACHER, arena=arena)
        name = f"{arena}: with state labels the learner is a copy of the teacher"
        yield found.compared(name, rows[LABELS], teacher, fw.SCORE, within(COPY))


ALTERNATIVES = fw.Experiment(
    "alternatives",
    "Alternatives that the thesis names",
    "4.2.1, 4.5.1, 4.6.1, 4.6.2",
    "Did the thesis choose well where it names an alternative?",
    "One set of training files a replication, and learners that use it in different ways. *Highest confidence*: the "
    "behaviour with most votes instead of a random draw. *Threshold*: all vectors within the minimum distance plus a "
    "threshold vote. *Until the goal*: a behaviour runs until its hand-written goal is reached or ten seconds have "
    "passed; the learner keeps one vector for every behaviour that the teacher began, or, as a control, all vectors. "
    "*State labels*: the learner has the tree of figure 4.2 and learns only which behaviour was heard in which state.",
    conditions=("all",),
    run=partial(fw.train_and_recall, learners=alternatives),
    claims=alternative_claims,
    picture=(fw.SCORE, fw.DELIVERED),
    recalls=(
        "Noise of the laboratory; the same training files and the same recalls for all. Teachers have no training "
        "episodes.",
        (fw.SCORE, fw.DELIVERED, fw.STEPS),
    ),
)
