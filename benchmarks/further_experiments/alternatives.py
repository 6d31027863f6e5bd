"""Alternatives: what the thesis decided against (4.2.1, 4.5.1, 4.6.1, 4.6.2)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np

from further_experiments.episodes import ARENAS, Files, imitator, recall_all, thesis_files
from further_experiments.experiment import (
    DELIVERED,
    INTERVALS,
    SCORE,
    STEPS,
    Analysis,
    Experiment,
    RecallEpisode,
    Report,
    Row,
    Trial,
    claim,
)
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.estimates import UNKNOWN, pick
from khepera_forage.experience import Experience
from khepera_forage.figures import legend, levels, panels
from khepera_forage.policies import ClassifierPolicy, Observation, Policy, Teacher
from khepera_forage.policies.policy import state_vector_of
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import (
    BEHAVIOURS,
    Behaviour,
    FoodType,
    State,
    StateVector,
    classify,
    is_raised,
)
from khepera_forage.thesis.claims.claim import Claim, above, points, within

DECISIONS = Decisions().values()
PATIENCE = 100
"""Steps after which a behaviour without success ends: ten seconds. Our decision (4.2.1)."""


def goal_reached(behaviour: int, vector: StateVector, home_radius: int) -> bool:
    """Whether the local goal of a behaviour is reached (4.2.1): the robot is where the next behaviour begins."""
    presence, home, food_type, arm, food = vector
    if behaviour == Behaviour.SEARCH_FOR_FOOD:
        return bool(food <= DECISIONS.close_to_food)
    if behaviour == Behaviour.MOVE_SLOWLY:
        return bool(food <= DECISIONS.next_to_food)
    if behaviour == Behaviour.ORIENT_WITH_FOOD:
        return bool(presence)
    if behaviour == Behaviour.EXPLORE_FOOD:
        return food_type != FoodType.UNKNOWN
    if behaviour == Behaviour.PICK_UP_FOOD:
        return bool(presence) and is_raised(arm, DECISIONS)
    if behaviour in (Behaviour.PUSH_FOOD, Behaviour.GO_HOME):
        return home <= home_radius
    if behaviour == Behaviour.AVOID_HOME:
        return home > home_radius
    return not presence  # RELEASE FOOD and AVOID FOOD


@dataclass
class UntilGoal:
    """A policy whose behaviours run until their goal is reached or `PATIENCE` steps have passed.

    It remembers the running behaviour, so every episode needs a new copy.

    Attributes:
        policy: Decides on the next behaviour.
        home_radius: In pixels.
    """

    policy: Policy
    home_radius: int
    _running: int | None = field(default=None, init=False)
    _steps: int = field(default=0, init=False)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The behaviour that runs, or the next one."""
        vector = state_vector_of(observation)
        running = self._running
        if running is None or self._steps >= PATIENCE or goal_reached(running, vector, self.home_radius):
            running = self._running = self.policy.act(observation, rng)
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

    Attributes:
        home_radius: Of the arena it forages in, in pixels.
        counts: How often each behaviour was heard in each state.
    """

    home_radius: int
    counts: Mapping[State, Mapping[Behaviour, int]]

    @classmethod
    def heard(cls, files: Sequence[Experience], home_radius: int) -> "StateLabels":
        """The learner of these files: behaviours tell the states, as the two correspond one to one (4.4.1)."""
        heard: dict[State, dict[Behaviour, int]] = {}
        for experience in files:
            for behaviour in experience.behaviours:
                counts = heard.setdefault(State(int(behaviour)), {})
                counts[behaviour] = counts.get(behaviour, 0) + 1
        return cls(home_radius, heard)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A behaviour heard in the present state, drawn with its share; any behaviour if none was heard."""
        assert rng is not None
        state = classify(state_vector_of(observation), self.home_radius, DECISIONS)
        counts = self.counts.get(state)
        if counts is None:
            return BEHAVIOURS[int(rng.integers(len(BEHAVIOURS) - 1))]
        behaviours = list(counts)
        shares = np.cumsum(list(counts.values()))
        return behaviours[int(np.searchsorted(shares, rng.random() * shares[-1], side="right"))]


THESIS, HIGHEST, LABELS = "as in the thesis", "highest confidence", "state labels"
GOAL, GOAL_ALL = "until the goal, one vector each", "until the goal, all vectors"
TEACHER, TEACHER_GOAL = "teacher", "teacher until the goal"
THRESHOLDS = (0.01, 0.05, 0.2)
EQUAL = 5.0
"""Points of score within which two policies count as equal. Our decision."""


def threshold_name(threshold: float) -> str:
    """The name of the learner with a threshold."""
    return f"threshold {threshold:g}"


LEARNERS = (THESIS, HIGHEST, *map(threshold_name, THRESHOLDS), GOAL, GOAL_ALL, LABELS)


def run(trial: Trial) -> list[Row]:
    """The same training files for all learners, and the same recalls."""
    files, trainings = thesis_files(trial)
    rows: list[Row] = [*trainings]
    for arena in ARENAS:
        env = recall_env(arena, limit=trial.size.steps)
        teacher = Teacher.of(env)
        rows += recall_all(env, teacher, trial, 0, condition=TEACHER)
        until_goal = UntilGoal(teacher, env.home_radius)
        rows += recall_all(env, until_goal, trial, 0, condition=TEACHER_GOAL, fresh=True)
        for amount in trial.size.amounts:
            for name, policy, experience in _policies(files[:amount], env):
                fresh = isinstance(policy, UntilGoal)
                rows += recall_all(env, policy, trial, amount, experience, name, fresh)
        env.close()
    return rows


def _policies(files: Files, env: BehavioursEnv) -> Iterator[tuple[str, Policy, Files]]:
    """Every learner with its name and its experience."""
    thesis = imitator(files, env.diagonal)
    yield THESIS, thesis, files
    yield HIGHEST, ClassifierPolicy(thesis, sample=False, remember=True), files
    for threshold in THRESHOLDS:
        yield threshold_name(threshold), imitator(files, env.diagonal, threshold), files
    few = [first_vectors(experience) for experience in files]
    yield GOAL, UntilGoal(imitator(few, env.diagonal), env.home_radius), few
    yield GOAL_ALL, UntilGoal(thesis, env.home_radius), files
    yield LABELS, StateLabels.heard(files, env.home_radius), files


def report(found: Analysis) -> Report:
    """Whether the thesis chose well."""
    first, last = found.amounts[0], found.amounts[-1]
    claims = [made for arena in ARENAS for made in _claims(found, arena, last)]
    note = (
        "Noise of the laboratory; the same training files and the same recalls for all. Teachers have no training "
        "episodes."
    )
    figure, axes = panels(4, "Alternatives that the thesis names")
    figure.set_figheight(1.2 + 0.68 * (len(LEARNERS) + 2))  # a line for each learner and both teachers
    kinds = [*(f"{n} episode{'s' * (n > 1)}" for n in (first, last)), "no learning"]
    for i, measure in enumerate((SCORE, DELIVERED)):
        for j, arena in enumerate(ARENAS):
            own = pick(found.recalls, arena=arena)
            shown = {
                name: [found.mean(pick(own, condition=name, amount=n), measure) for n in (first, last)]
                for name in LEARNERS
            }
            for name in (TEACHER, TEACHER_GOAL):
                shown[name] = [UNKNOWN, UNKNOWN, found.mean(pick(own, condition=name, amount=0), measure)]
            panel = axes[2 * j + i]
            levels(panel, shown, f"{measure.name}, {arena}", kinds)
            panel.set_xlim(-24 if measure is SCORE else -4, 104)
            if i:
                panel.set_yticklabels([])
    legend(figure, axes[0], INTERVALS)
    return Report(claims, [found.recall_table(note, (SCORE, DELIVERED, STEPS))], figure)


def _claims(found: Analysis, arena: str, last: int) -> Iterator[Claim]:
    def rows(name: str) -> list[RecallEpisode]:
        amount = 0 if name == TEACHER else last
        return pick(found.recalls, condition=name, amount=amount, arena=arena)

    for better, worse, statement in (
        (HIGHEST, THESIS, "the highest confidence is better than a random draw"),
        *((THESIS, threshold_name(t), f"a threshold of {t:g} is worse than exact ties") for t in THRESHOLDS),
        (THESIS, GOAL, "deciding at every step is better than running until the goal"),
        (THESIS, GOAL_ALL, "deciding at every step is better with the same vectors, too"),
    ):
        effect = found.difference(rows(better), rows(worse), SCORE)
        yield claim(f"{arena}: {statement}", effect, above(0.0), points)
    effect = found.difference(rows(LABELS), rows(TEACHER), SCORE)
    name = f"{arena}: with state labels the learner is a copy of the teacher"
    yield claim(name, effect, within(EQUAL), points)


ALTERNATIVES = Experiment(
    "alternatives",
    "Alternatives that the thesis rejected",
    "4.2.1, 4.5.1, 4.6.1, 4.6.2",
    "Did the thesis choose well where it names an alternative?",
    "One set of training files a replication, and learners that use it in different ways. *Highest confidence*: the "
    "behaviour with most votes instead of a random draw. *Threshold*: all vectors within the minimum distance plus a "
    "threshold vote. *Until the goal*: a behaviour runs until its hand-written goal is reached or ten seconds have "
    "passed; the learner keeps one vector for every behaviour that the teacher began, or, as a control, all vectors. "
    "*State labels*: the learner has the tree of figure 4.2 and learns only which behaviour was heard in which state.",
    ("all",),
    run,
    report,
)
