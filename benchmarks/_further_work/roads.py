"""Experiment 9: what the thesis decided against (4.2.1, 4.5.1, 4.6.1, 4.6.2)."""

from collections.abc import Iterator

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import DELIVERED, SCORE, STEPS, amounts_of, difference, mean, means_table, pick
from _further_work.phases import ARENAS, Files, imitator, learn, recall_all, training_seeds
from _further_work.pictures import legend, levels, panels
from _further_work.road_policies import StateLabels, UntilGoal, beginnings
from _further_work.rows import Done, Recalled, Unit
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies import Policy, Teacher
from khepera_forage.policies.adapters import ClassifierPolicy
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.thesis.claims.claim import Above, Claim, Within, judged, points
from khepera_forage.thesis.claims.claim import Unit as Scale
from khepera_forage.thesis.statistics import UNKNOWN

OWN, HIGHEST, LABELS = "the thesis' own", "highest confidence", "state labels"
GOAL, GOAL_ALL = "until the goal, one vector each", "until the goal, all vectors"
TEACHER, TEACHER_GOAL = "teacher", "teacher until the goal"
THRESHOLDS = (0.01, 0.05, 0.2)
EQUAL = 5.0
"""Points of score within which two foragers count as equal. Our decision."""
_percent = Scale("%", ".1f")


def threshold_name(threshold: float) -> str:
    """How a threshold's learner is called."""
    return f"threshold {threshold:g}"


LEARNERS = (OWN, HIGHEST, *map(threshold_name, THRESHOLDS), GOAL, GOAL_ALL, LABELS)


def run(unit: Unit) -> Done:
    """The same lessons for all, and the same recalls."""
    env = TrainingEnv()
    taught = list(learn(env, unit, training_seeds(unit).spawn(unit.size.files)))
    env.close()
    files = [experience for experience, _ in taught]
    recalls: list[Recalled] = []
    for arena in ARENAS:
        alone = recall_env(arena)
        teacher = Teacher(alone.home_radius)
        recalls += recall_all(alone, teacher, unit, 0, condition=TEACHER)
        until = UntilGoal(teacher, alone.home_radius)
        recalls += recall_all(alone, until, unit, 0, condition=TEACHER_GOAL, anew=True)
        for amount in unit.size.amounts:
            for name, policy, known in _policies(files[:amount], alone):
                anew = isinstance(policy, UntilGoal)
                recalls += recall_all(alone, policy, unit, amount, known, name, anew)
        alone.close()
    return Done(tuple(lesson for _, lesson in taught), tuple(recalls))


def _policies(files: Files, env: BehavioursEnv) -> Iterator[tuple[str, Policy, Files]]:
    """Every learner with its name and the experience it has."""
    own = imitator(files, env.diagonal)
    yield OWN, own, files
    yield HIGHEST, ClassifierPolicy(own, sample=False, remember=True), files
    for threshold in THRESHOLDS:
        yield threshold_name(threshold), imitator(files, env.diagonal, threshold), files
    few = [beginnings(experience) for experience in files]
    yield GOAL, UntilGoal(imitator(few, env.diagonal), env.home_radius), few
    yield GOAL_ALL, UntilGoal(own, env.home_radius), files
    yield LABELS, StateLabels.heard(files, env.home_radius), files


def report(done: Done, rng: np.random.Generator) -> Report:
    """Whether the thesis chose well."""
    last = max(amounts_of(done.recalls))
    claims = tuple(claim for arena in ARENAS for claim in _claims(done, arena, last, rng))
    table = means_table(
        "recalls",
        "Recall",
        "Noise of the laboratory; the same training files and the same recalls for all. Teachers have no "
        "episodes.",
        "episodes",
        done.recalls,
        (SCORE, DELIVERED, STEPS),
        rng,
    )
    figure, axes = panels(4, "The roads not taken")
    for i, measure in enumerate((SCORE, DELIVERED)):
        for j, arena in enumerate(ARENAS):
            shown = {
                name: [mean(pick(done.recalls, name, n, arena), measure, rng) for n in _shown(done)]
                for name in LEARNERS
            }
            for name in (TEACHER, TEACHER_GOAL):
                taught = mean(pick(done.recalls, name, 0, arena), measure, rng)
                shown[name] = [UNKNOWN, UNKNOWN, taught]
            panel = axes[2 * j + i]
            kinds = [*(f"{n} episode{'s' * (n > 1)}" for n in _shown(done)), "nothing to learn"]
            levels(panel, shown, kinds, f"{measure.name}, {arena}")
            panel.set_xlim(-24 if measure is SCORE else -4, 104)
            if i:
                panel.set_yticklabels([])
    legend(figure, axes[0])
    return Report(claims, (table,), figure)


def _shown(done: Done) -> list[int]:
    amounts = amounts_of(done.recalls)
    return [amounts[0], amounts[-1]]


def _claims(done: Done, arena: str, last: int, rng: np.random.Generator) -> list[Claim]:
    own = pick(done.recalls, OWN, last, arena)

    def rows(name: str) -> list[Recalled]:
        return pick(done.recalls, name, None if name in (TEACHER, TEACHER_GOAL) else last, arena)

    def against_own(name: str, claim: str, section: str, better: bool) -> Claim:
        """That another way is better than the thesis' own, or worse."""
        pair = (rows(name), own) if better else (own, rows(name))
        return judged(
            f"{arena}: {claim}",
            section,
            difference(*pair, SCORE, rng),
            Above(0.0),
            points,
            "",
            f"After {last} episodes {name} {_told(rows(name), rng)}; {OWN} {_told(own, rng)}.",
        )

    return [
        against_own(HIGHEST, "always the highest confidence is better than a draw", "4.6.2", True),
        *(
            against_own(
                threshold_name(t),
                f"a threshold of {t:g} gives poorer results than exact ties",
                "4.6.1",
                False,
            )
            for t in THRESHOLDS
        ),
        against_own(GOAL, "deciding at every step is better than running until the goal", "4.2.1", False),
        against_own(GOAL_ALL, "it is better even with the same experience", "4.2.1", False),
        judged(
            f"{arena}: with state labels the learner is a copy of the teacher",
            "4.5.1",
            difference(rows(LABELS), rows(TEACHER), SCORE, rng),
            Within(EQUAL),
            points,
            "",
            f"After {last} episodes {LABELS} {_told(rows(LABELS), rng)}, after one "
            f"{_told(pick(done.recalls, LABELS, 1, arena), rng)}; the teacher {_told(rows(TEACHER), rng)}.",
        ),
    ]


def _told(rows: list[Recalled], rng: np.random.Generator) -> str:
    score, food = mean(rows, SCORE, rng).value, mean(rows, DELIVERED, rng).value
    return f"scores {_percent(score)} and delivers {_percent(food)}"


EXPERIMENT = Experiment(
    "roads",
    "The roads not taken",
    "4.2.1, 4.5.1, 4.6.1, 4.6.2",
    "Did the thesis choose well where it names an alternative?",
    "One set of training files a replication, and learners that use it differently. *Highest confidence*: the "
    "behaviour with most votes instead of a draw. *Threshold*: all vectors within the minimum distance plus a "
    "threshold vote (a pixel is 1/138 in the corridor). *Until the goal*: a behaviour, once chosen, runs until its own "
    "goal is reached or ten seconds have passed, and the learner keeps one vector for every behaviour that the teacher "
    "began (or, as a control, all). These goals are written by hand with the thresholds of the teacher's own tree, so "
    "that its behaviours know part of what a learner that decides at every step has to learn. *State labels*: the "
    "first draft, whose learner knows the tree of figure 4.2 and learns only which behaviour was shouted with which "
    "state; in a state it never heard of it draws any behaviour.",
    ("all",),
    run,
    report,
)
