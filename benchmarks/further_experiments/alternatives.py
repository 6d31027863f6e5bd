"""Alternatives: what the thesis decided against (4.2.1, 4.5.1, 4.6.1, 4.6.2)."""

from collections.abc import Iterator

from further_experiments.alternative_policies import StateLabels, UntilGoal, first_vectors
from further_experiments.analysis import DELIVERED, SCORE, STEPS, Analysis, claim
from further_experiments.episodes import ARENAS, Files, imitator, recall_all, thesis_files
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.pictures import INTERVALS
from further_experiments.rows import RecallEpisode, Row
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.estimates import UNKNOWN, pick
from khepera_forage.figures import legend, levels, panels
from khepera_forage.policies import Policy, Teacher
from khepera_forage.policies.adapters import ClassifierPolicy
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.thesis.claims.claim import Above, Claim, Within, points

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


def _claims(found: Analysis, arena: str, last: int) -> list[Claim]:
    def rows(name: str, amount: int = last) -> list[RecallEpisode]:
        count = 0 if name in (TEACHER, TEACHER_GOAL) else amount
        return pick(found.recalls, condition=name, amount=count, arena=arena)

    def result(name: str, amount: int = last) -> str:
        own = rows(name, amount)
        return f"scores {found.percent(own, SCORE)} and delivers {found.percent(own)}"

    def compared(name: str, statement: str, section: str, better: bool) -> Claim:
        """That an alternative is better than the thesis's choice, or worse."""
        pair = (rows(name), rows(THESIS)) if better else (rows(THESIS), rows(name))
        return claim(
            f"{arena}: {statement}",
            section,
            found.difference(*pair, SCORE),
            Above(0.0),
            points,
            f"After {last} episodes the learner with *{name}* {result(name)}; the learner {THESIS} {result(THESIS)}.",
        )

    return [
        compared(HIGHEST, "the highest confidence is better than a random draw", "4.6.2", True),
        *(
            compared(threshold_name(t), f"a threshold of {t:g} is worse than exact ties", "4.6.1", False)
            for t in THRESHOLDS
        ),
        compared(GOAL, "deciding at every step is better than running until the goal", "4.2.1", False),
        compared(GOAL_ALL, "deciding at every step is better with the same vectors, too", "4.2.1", False),
        claim(
            f"{arena}: with state labels the learner is a copy of the teacher",
            "4.5.1",
            found.difference(rows(LABELS), rows(TEACHER), SCORE),
            Within(EQUAL),
            points,
            f"The learner with *{LABELS}* {result(LABELS)} after {last} episodes, and {result(LABELS, 1)} after one; "
            f"the teacher {result(TEACHER)}.",
        ),
    ]


EXPERIMENT = Experiment(
    "alternatives",
    "Alternatives that the thesis rejected",
    "4.2.1, 4.5.1, 4.6.1, 4.6.2",
    "Did the thesis choose well where it names an alternative?",
    "One set of training files a replication, and learners that use it in different ways. *Highest confidence*: the "
    "behaviour with most votes instead of a random draw. *Threshold*: all vectors within the minimum distance plus a "
    "threshold vote (a pixel is 1/138 in the corridor). *Until the goal*: a behaviour runs until its own goal is "
    "reached or ten seconds have passed. The learner keeps one vector for every behaviour that the teacher began, or, "
    "as a control, all vectors. The goals are written by hand with the thresholds of the teacher's tree, so these "
    "behaviours contain knowledge that a learner that decides at every step has to learn. *State labels*: the first "
    "draft of the thesis, in which the learner has the tree of figure 4.2 and learns only which behaviour was heard "
    "in which state. In a state without any record it draws any behaviour.",
    ("all",),
    run,
    report,
)
