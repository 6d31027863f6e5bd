"""Action level: the behaviours are imitated, too, for a complete imitation learning system (4.8, 6.2)."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from further_experiments.analysis import (
    ATTEMPTS,
    DELIVERED,
    FOOD_POINTS,
    PERCENT,
    ROUNDS,
    SCORE,
    SEPARATIONS,
    STEPS,
    TRUE,
    Analysis,
    claim,
    spent,
)
from further_experiments.copied_motors import CopiedMotorsEnv, LearnedBehavioursEnv
from further_experiments.episodes import ARENAS, imitator, recall_all, training_seeds
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.observed_training import Observed, observe
from further_experiments.pictures import INTERVALS, curves
from further_experiments.rows import RecallEpisode, Row
from further_experiments.spatial_variety import ALL, ONE, setups
from khepera_forage.estimates import pick
from khepera_forage.figures import legend, panels
from khepera_forage.policies import Teacher
from khepera_forage.policies.learned_behaviours import LearnedBehaviours
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.thesis.claims.claim import Above, Claim, Within

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PROGRAM, BEHAVIOURS, BOTH = "learned program", "learned behaviours", "both learned"
TEACHER = "the teacher"
SAME = 10.0
"""Points of food delivered within which two robots count as equal. Our decision."""
MOST = 50.0
"""Percent of the food above which a system counts as foraging. Our decision."""


def condition_of(setup: str, learned: str) -> str:
    """The name of a system: the set-up of its training, and which part of it is learned."""
    return f"{setup}: {learned}"


def run(trial: Trial) -> list[Row]:
    """Training with copied motors; recalls with a program and behaviours of which either, or both, are learned."""
    seeds, places = training_seeds(trial).spawn(2)
    env = CopiedMotorsEnv(max_cycles=trial.size.rounds)
    marks = setups(trial.condition, np.random.default_rng(places))
    trained = observe(env, trial, seeds.spawn(trial.size.files), marks)
    env.close()
    files = [episode.experience for episode in trained]
    behaviours = {amount: learned(trained[:amount], trial.replication) for amount in trial.size.amounts}
    rows: list[Row] = [episode.row for episode in trained]
    for arena in ARENAS:
        given = recall_env(arena, limit=trial.size.steps)
        own = LearnedBehavioursEnv(arena=arena, foods=given.foods, limit=given.limit)
        teacher = Teacher.of(given)
        rows += recall_all(given, teacher, trial, 0, condition=condition_of(trial.condition, TEACHER))
        for amount, learned_behaviours in behaviours.items():
            own.command = learned_behaviours.command
            program = imitator(files[:amount], given.diagonal)
            for what, alone, policy in (
                (PROGRAM, given, program),
                (BEHAVIOURS, own, teacher),
                (BOTH, own, program),
            ):
                condition = condition_of(trial.condition, what)
                rows += recall_all(alone, policy, trial, amount, files[:amount], condition)
        given.close()
        own.close()
    return rows


def learned(episodes: Sequence[Observed], seed: int) -> LearnedBehaviours:
    """Behaviours learned from what the learner perceived, heard and drove."""
    raws, heard, motors = zip(*(moment for episode in episodes for moment in episode.moments), strict=True)
    return LearnedBehaviours(random_state=seed).fit(raws, heard, motors)


def report(found: Analysis) -> Report:
    """Which part of the system can be learned, and from which set-ups."""
    last = max(found.amounts)
    tables = (
        found.recall_table(
            "Noise of the laboratory; random places, the same for every line of an arena. 0 episodes: the teacher's "
            "program and the hand-coded behaviours. The score counts steps in which the program chose as the teacher "
            "would have; the food tells how good the behaviours are.",
            (DELIVERED, SCORE, STEPS),
        ),
        found.training_table(
            "The learner drives the motor commands that it receives, bent by following.",
            (ATTEMPTS, ROUNDS, SEPARATIONS, TRUE),
        ),
        found.states_table(
            "Where learned behaviours get stuck",
            f"With the teacher's program, which is never wrong, after {last} episodes: share of all steps by state.",
            [(arena, _with_the_teachers_program(found, last, arena)) for arena in ARENAS],
            (spent,),
        ),
    )
    return Report(list(_claims(found, last)), tables, _figure(found), _summary(found, last))


def _with_the_teachers_program(
    found: Analysis, last: int, arena: str
) -> list[tuple[str, Sequence[RecallEpisode]]]:
    """Recalls with hand-coded behaviours, and with those learned from one set-up and from several."""
    hand_coded = pick(found.recalls, condition=condition_of(ONE, TEACHER), amount=0, arena=arena)
    names = [condition_of(setup, BEHAVIOURS) for setup in (ONE, ALL)]
    own = [(name, pick(found.recalls, condition=name, amount=last, arena=arena)) for name in names]
    return [(TEACHER, hand_coded), *own]


def _summary(found: Analysis, last: int) -> str:
    def foods(setup: str) -> str:
        parts = []
        for what in (PROGRAM, BEHAVIOURS, BOTH):
            own = pick(found.recalls, condition=condition_of(setup, what), amount=last)
            values = " and ".join(found.percent(pick(own, arena=arena)) for arena in ARENAS)
            parts.append(f"{what} {values}")
        return "; ".join(parts)

    return (
        f"Food delivered in corridor and rectangle after {last} episodes with {ALL}: {foods(ALL)}. The same after as "
        f"many episodes with {ONE}: {foods(ONE)}."
    )


def _figure(found: Analysis) -> "Figure":
    figure, axes = panels(
        4, "Action level: food delivered with a learned program, learned behaviours, and both"
    )
    for i, setup in enumerate((ONE, ALL)):
        for j, arena in enumerate(ARENAS):
            own = [
                replace(row, condition=what)
                for what in (PROGRAM, BEHAVIOURS, BOTH)
                for row in pick(found.recalls, condition=condition_of(setup, what), arena=arena)
            ]
            title = f"{arena}, training with {setup}"
            curves(axes[2 * i + j], found, own, DELIVERED, "training episodes", title)
    legend(figure, axes[0], INTERVALS)
    return figure


def _claims(found: Analysis, last: int) -> Iterator[Claim]:
    def rows(setup: str, what: str, arena: str) -> list[RecallEpisode]:
        amount = 0 if what == TEACHER else last
        return pick(found.recalls, condition=condition_of(setup, what), amount=amount, arena=arena)

    def food(setup: str, what: str, arena: str) -> str:
        return found.percent(rows(setup, what, arena))

    for arena in ARENAS:
        for setup in (ONE, ALL):
            yield claim(
                f"{arena}, {setup}: learned behaviours are as good as hand-coded ones",
                "4.8",
                found.difference(rows(setup, BEHAVIOURS, arena), rows(setup, TEACHER, arena), DELIVERED),
                Within(SAME),
                FOOD_POINTS,
                f"With the teacher's program, after {last} episodes, learned behaviours deliver "
                f"{food(setup, BEHAVIOURS, arena)} of the food and the hand-coded ones {food(setup, TEACHER, arena)}.",
            )
            yield claim(
                f"{arena}, {setup}: the complete imitation learning system delivers most of the food",
                "4.8, 6.2",
                found.mean(rows(setup, BOTH, arena), DELIVERED),
                Above(MOST),
                PERCENT,
                f"After {last} episodes the learned program with learned behaviours delivers "
                f"{food(setup, BOTH, arena)}, the same program with hand-coded behaviours "
                f"{food(setup, PROGRAM, arena)}.",
            )
        yield claim(
            f"{arena}: variety of the episodes helps the complete system",
            "5.5, 6.2",
            found.difference(rows(ALL, BOTH, arena), rows(ONE, BOTH, arena), DELIVERED),
            Above(0.0),
            FOOD_POINTS,
            f"{food(ALL, BOTH, arena)} after {last} episodes with {ALL}, {food(ONE, BOTH, arena)} after as many with "
            f"{ONE}.",
        )


EXPERIMENT = Experiment(
    "action_level",
    "Action level",
    "4.8, 6.2",
    "Can the behaviours be learned by imitation as well, and can a learner forage with both learned: the complete "
    "imitation learning system?",
    "The thesis's learner has every behaviour that it hears. This learner has none. In training the teacher transmits "
    "its motor commands beside the behaviour: two wheels, arm and jaw. The learner drives these commands; following "
    "(4.5.2) is given as in the thesis and bends its path towards the teacher. It records its own raw data, the "
    "behaviour, and its own motor commands, following included. From these it learns its program as the thesis's "
    "learner does, and for each behaviour a regression from raw data to motors: ten extremely randomised trees of "
    "scikit-learn with default settings, the mean for the wheels, the majority for arm and jaw. Places in the raw data "
    "become distances and bearings from the robot, as 4.3 turns them into distances. A behaviour that was never heard "
    "means to stand still. Nothing else of the hand-coded behaviours is given to the learner. Training has the set-up "
    "of figure 5.1, or start and food at random places in each episode.",
    (ONE, ALL),
    run,
    report,
)
