"""Two experiments on what the learner does with its records: attribute weights, and rejected alternatives."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

import further_experiments.common as fw
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.estimates import UNKNOWN, Measure, pick
from khepera_forage.experience import Experience
from khepera_forage.figures import COLOURS, MARKERS, SMALL, entry, grid, legend, levels, mark, panels
from khepera_forage.policies import ClassifierPolicy, Observation, Policy, Teacher, WeightedImitator
from khepera_forage.policies.policy import state_vector_of
from khepera_forage.rollouts.training import arrays
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import BEHAVIOURS, Behaviour, FoodType, StateVector, behaviour_for, classify, is_raised
from khepera_forage.thesis.claims import Claim, within

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
CONDITIONS = (*FIXED, LEARNED)
TESTED = ("food ×2", "food ×4", "food ×8", LEARNED)


def run_weights(trial: fw.Trial) -> list[fw.Row]:
    """The same training files for all weights, and the same recalls."""
    files, trainings = fw.all_files(trial)
    rows: list[fw.Row] = [*trainings]
    for arena in fw.ARENAS:
        env = trial.alone(arena)
        for amount in trial.size.amounts:
            for name, policy in _weighted(files[:amount], env.diagonal, trial.replication):
                rows += fw.recall_all(env, policy, trial, amount, files[:amount], name)
    return rows


def _weighted(files: fw.Files, diagonal: int, seed: int) -> Iterator[tuple[str, Policy]]:
    """One learner for each set of weights."""
    vectors, behaviours = arrays(list(files))
    for name, weights in FIXED.items():
        if name == EQUAL:
            yield name, fw.imitator(files, diagonal)
        else:
            weighted = WeightedImitator(diagonal, weights).fit(vectors, behaviours)
            yield name, ClassifierPolicy(weighted, remember=True)
    # Cross-validation leaves out whole episodes. Of a single episode nothing would be left, so it leaves out vectors.
    groups = np.repeat(np.arange(len(files)), [len(file) for file in files]) if len(files) > 1 else None
    learned = WeightedImitator(diagonal, random_state=seed).fit(vectors, behaviours, groups)
    yield LEARNED, ClassifierPolicy(learned, remember=True)


def report_weights(found: fw.Analysis) -> fw.Report:
    """Whether weights solve area 1, and their effect on the whole task."""
    last = max(found.amounts)
    note = "Noise of the laboratory; the same training files and the same recalls for all weights."
    tables = (found.recall_table(note, (fw.SCORE, fw.DELIVERED, fw.STEPS)), found.places_table(last))
    return list(_weight_claims(found, last)), tables, _weight_figure(found, last)


def _weight_figure(found: fw.Analysis, last: int) -> "Figure":
    figure, axes = panels(4, "Attribute weights in the distance of 4.6.1")
    for panel, arena in zip(axes, fw.ARENAS, strict=False):
        own = pick(found.recalls, arena=arena)
        lines = {
            f"{amount} training episode{'s' * (amount > 1)}": pick(own, amount=amount)
            for amount in dict.fromkeys((min(found.amounts), last))
        }
        _weight_curves(panel, found, lines, fw.SCORE)
        panel.set_title(arena, fontsize=10)
    own = pick(found.recalls, amount=last)
    _weight_curves(axes[2], found, {f"food {place}": fw.at(own, place) for place in fw.PLACES}, fw.DELIVERED)
    _weight_curves(axes[3], found, {"both food objects": pick(own, arena="rectangle")}, fw.DELIVERED)
    for panel, arena in zip(axes[2:], fw.ARENAS, strict=True):
        panel.set_title(f"{arena}, {last} episodes", fontsize=10)
        panel.set_xlabel(f"weight; {fw.INTERVALS}")
    return figure


def _weight_curves(
    axes: "Axes",
    found: fw.Analysis,
    lines: Mapping[str, Sequence[fw.RecallEpisode]],
    measure: Measure[fw.RecallEpisode],
) -> None:
    """For each group of recalls a curve over the fixed weights, and a point for the learned ones."""
    for i, (name, rows) in enumerate(lines.items()):
        means = [found.mean(pick(rows, condition=condition), measure) for condition in CONDITIONS]
        places = [place + 0.14 * (i - (len(lines) - 1) / 2) for place in range(len(means))]
        fixed = slice(len(FIXED))
        axes.plot(places[fixed], [e.value for e in means[fixed]], color=COLOURS[i], lw=1)
        entry(axes, name, COLOURS[i], MARKERS[i], "-")
        for place, estimate in zip(places, means, strict=True):
            mark(axes, place, estimate.value, estimate, COLOURS[i], marker=MARKERS[i])
    axes.set_xticks(range(len(CONDITIONS)), CONDITIONS, fontsize=SMALL)
    axes.set_ylim(-10 if measure is fw.SCORE else -4, 104)
    axes.set_ylabel(measure.name)
    grid(axes)
    axes.legend(fontsize=SMALL)


def _weight_claims(found: fw.Analysis, last: int) -> Iterator[Claim]:
    def rows(name: str, arena: str = "corridor", place: str = "") -> list[fw.RecallEpisode]:
        own = pick(found.recalls, condition=name, amount=last, arena=arena)
        return fw.at(own, place) if place else own

    for name in TESTED:
        further, equal = (rows(one, place=fw.FURTHER) for one in (name, EQUAL))
        statement = f"corridor, food further out: {name} delivers more than equal weights"
        yield found.compared(statement, further, equal, fw.DELIVERED)
    for name in TESTED:
        further, about = (rows(name, place=place) for place in (fw.FURTHER, fw.ABOUT))
        statement = f"corridor: with {name} food further out is delivered as often as where it lay in training"
        yield found.compared(statement, further, about, fw.DELIVERED, within(SAME))
    for arena in fw.ARENAS:
        for name in TESTED:
            statement = f"{arena}: {name} scores more than equal weights"
            yield found.compared(statement, rows(name, arena), rows(EQUAL, arena), fw.SCORE)


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
    ("all",),
    run_weights,
    report_weights,
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
LEARNERS = (THESIS, HIGHEST, *THRESHOLDS, GOAL, GOAL_ALL, LABELS)


def run_alternatives(trial: fw.Trial) -> list[fw.Row]:
    """The same training files for all learners, and the same recalls."""
    files, trainings = fw.all_files(trial)
    rows: list[fw.Row] = [*trainings]
    for arena in fw.ARENAS:
        env = trial.alone(arena)
        teacher = Teacher.of(env)
        rows += fw.recall_all(env, teacher, trial, condition=TEACHER)
        rows += fw.recall_all(env, UntilGoal(teacher, env.home_radius), trial, condition=TEACHER_GOAL)
        for amount in trial.size.amounts:
            for name, policy, experience in _policies(files[:amount], env):
                rows += fw.recall_all(env, policy, trial, amount, experience, name)
    return rows


def _policies(files: fw.Files, env: BehavioursEnv) -> Iterator[tuple[str, Policy, fw.Files]]:
    """Every learner with its name and its experience."""
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


def report_alternatives(found: fw.Analysis) -> fw.Report:
    """Whether the thesis chose well."""
    first, last = found.amounts[0], found.amounts[-1]
    claims = [made for arena in fw.ARENAS for made in _alternative_claims(found, arena, last)]
    note = (
        "Noise of the laboratory; the same training files and the same recalls for all. Teachers have no training "
        "episodes."
    )
    figure, axes = panels(4, "Alternatives that the thesis names")
    figure.set_figheight(1.2 + 0.68 * (len(LEARNERS) + 2))  # a line for each learner and both teachers
    kinds = [*(f"{n} episode{'s' * (n > 1)}" for n in (first, last)), "no learning"]
    for i, measure in enumerate((fw.SCORE, fw.DELIVERED)):
        for j, arena in enumerate(fw.ARENAS):
            own = pick(found.recalls, arena=arena)
            shown = {
                name: [found.mean(pick(own, condition=name, amount=n), measure) for n in (first, last)]
                for name in LEARNERS
            }
            for name in (TEACHER, TEACHER_GOAL):
                shown[name] = [UNKNOWN, UNKNOWN, found.mean(pick(own, condition=name, amount=0), measure)]
            panel = axes[2 * j + i]
            levels(panel, shown, f"{measure.name}, {arena}", kinds)
            panel.set_xlim(-24 if measure is fw.SCORE else -4, 104)
            if i:
                panel.set_yticklabels([])
    legend(figure, axes[0], fw.INTERVALS)
    return claims, [found.recall_table(note, (fw.SCORE, fw.DELIVERED, fw.STEPS))], figure


def _alternative_claims(found: fw.Analysis, arena: str, last: int) -> Iterator[Claim]:
    def rows(name: str) -> list[fw.RecallEpisode]:
        amount = 0 if name == TEACHER else last
        return pick(found.recalls, condition=name, amount=amount, arena=arena)

    for better, worse, statement in (
        (HIGHEST, THESIS, "the highest confidence is better than a random draw"),
        *((THESIS, name, f"a {name.replace(' ', ' of ')} is worse than exact ties") for name in THRESHOLDS),
        (THESIS, GOAL, "deciding at every step is better than running until the goal"),
        (THESIS, GOAL_ALL, "deciding at every step is better with the same vectors, too"),
    ):
        yield found.compared(f"{arena}: {statement}", rows(better), rows(worse), fw.SCORE)
    name = f"{arena}: with state labels the learner is a copy of the teacher"
    yield found.compared(name, rows(LABELS), rows(TEACHER), fw.SCORE, within(COPY))


ALTERNATIVES = fw.Experiment(
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
    run_alternatives,
    report_alternatives,
)
