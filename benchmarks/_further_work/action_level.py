"""Experiment 5: the motors behind the behaviours are imitated too, a complete imitation learning system (4.8, 6.2)."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from _further_work.by_state import spent, states_table
from _further_work.copying import CopyingEnv, OwnBehavioursEnv
from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    ATTEMPTS,
    DELIVERED,
    ROUNDS,
    SCORE,
    SEPARATIONS,
    STEPS,
    TRUE,
    Measure,
    amounts_of,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import ARENAS, imitator, recall_all, training_seeds
from _further_work.pictures import curves, legend, panels
from _further_work.rows import Done, Recalled, Unit
from _further_work.variety import ALL, ONE, setups
from _further_work.witness import Taught, witnessed
from khepera_forage.policies import Teacher
from khepera_forage.policies.learned_behaviours import LearnedBehaviours
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.task.behaviours import command
from khepera_forage.thesis.claims.claim import Above, Claim, Within, judged
from khepera_forage.thesis.claims.claim import Unit as Scale

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PROGRAM, ACTIONS, BOTH = "learned program", "learned behaviours", "both learned"
NEITHER = "the teacher"
SAME = 10.0
"""Points of food delivered within which two foragers count as equal. Our decision."""
MOST = 50.0
"""Percent of the food above which somebody forages. Our decision."""
_percent = Scale("%", ".1f")
_food = Scale("points of food delivered", "+.1f")


def name_of(setup: str, what: str) -> str:
    """How a forager is called: what was shown to it, and what of it is learned."""
    return f"{setup}: {what}"


def run(unit: Unit) -> Done:
    """Lessons in copied motors, and recalls with a program and behaviours of which either, or both, were learned."""
    seeds, places = training_seeds(unit).spawn(2)
    env = CopyingEnv()
    marks = setups(unit.condition, np.random.default_rng(places))
    taught = witnessed(env, unit, seeds.spawn(unit.size.files), marks)
    env.close()
    files = [lesson.experience for lesson in taught]
    behaviours = {amount: learned(taught[:amount], unit.replication) for amount in unit.size.amounts}
    recalls: list[Recalled] = []
    for arena in ARENAS:
        given = recall_env(arena)
        own = OwnBehavioursEnv(command, arena=arena, foods=given.foods, limit=given.limit)
        teacher = Teacher(given.home_radius)
        recalls += recall_all(given, teacher, unit, 0, condition=name_of(unit.condition, NEITHER))
        for amount, actions in behaviours.items():
            own.command = actions.command
            program = imitator(files[:amount], given.diagonal)
            for what, there, policy in (
                (PROGRAM, given, program),
                (ACTIONS, own, teacher),
                (BOTH, own, program),
            ):
                name = name_of(unit.condition, what)
                recalls += recall_all(there, policy, unit, amount, files[:amount], name)
        given.close()
        own.close()
    return Done(tuple(lesson.lesson for lesson in taught), tuple(recalls))


def learned(lessons: Sequence[Taught], seed: int) -> LearnedBehaviours:
    """What the behaviours command, learned from what the learner perceived, heard and drove."""
    raws, heard, motors = zip(*(moment for lesson in lessons for moment in lesson.moments), strict=True)
    return LearnedBehaviours(random_state=seed).fit(raws, heard, motors)


def report(done: Done, rng: np.random.Generator) -> Report:
    """Which part of the system can be learned, and from what."""
    last = max(amounts_of(done.recalls))
    tables = (
        means_table(
            "recalls",
            "Recall",
            "Noise of the laboratory, random places, the same for every line of an arena. 0 episodes: the teacher's "
            "program and the hand-coded behaviours. The score counts steps in which the program chose as the teacher "
            "would have; what the behaviours are worth is told by the food.",
            "episodes",
            done.recalls,
            (DELIVERED, SCORE, STEPS),
            rng,
        ),
        means_table(
            "lessons",
            "Training",
            "The learner drives the motors that it hears, bent by following.",
            "files",
            done.lessons,
            (ATTEMPTS, ROUNDS, SEPARATIONS, TRUE),
            rng,
        ),
        states_table(
            "Where learned behaviours get stuck",
            f"Under the teacher's program, which is never wrong, after {last} episodes: share of all steps by the "
            "state that they were taken in.",
            [(arena, _under_the_teacher(done.recalls, last, arena)) for arena in ARENAS],
            (spent,),
            rng,
        ),
    )
    claims = tuple(_claims(done, last, rng))
    return Report(claims, tables, _figure(done.recalls, rng), _summary(done.recalls, last, rng))


def _under_the_teacher(
    recalls: Sequence[Recalled], last: int, arena: str
) -> list[tuple[str, Sequence[Recalled]]]:
    """Recalls of its program with hand-coded behaviours, and with those learned from one set-up and from several."""
    shown = ((ONE, NEITHER, 0), (ONE, ACTIONS, last), (ALL, ACTIONS, last))
    return [
        (
            NEITHER if what == NEITHER else name_of(setup, what),
            pick(recalls, name_of(setup, what), amount, arena),
        )
        for setup, what, amount in shown
    ]


def _summary(recalls: Sequence[Recalled], last: int, rng: np.random.Generator) -> str:
    def told(setup: str) -> str:
        return "; ".join(
            f"{what} {' and '.join(_percent(mean(rows, DELIVERED, rng).value) for rows in both)}"
            for what in (PROGRAM, ACTIONS, BOTH)
            if (both := [pick(recalls, name_of(setup, what), last, arena) for arena in ARENAS])
        )

    return (
        f"Food delivered in corridor and rectangle after {last} episodes with {ALL}: {told(ALL)}. After as many from "
        f"{ONE}: {told(ONE)}."
    )


def _figure(recalls: Sequence[Recalled], rng: np.random.Generator) -> "Figure":
    figure, axes = panels(
        4, "Action level: food delivered with a learned program, learned behaviours, and both"
    )
    for i, setup in enumerate((ONE, ALL)):
        for j, arena in enumerate(ARENAS):
            own = [
                replace(row, condition=what)
                for what in (PROGRAM, ACTIONS, BOTH)
                for row in pick(recalls, name_of(setup, what), arena=arena)
            ]
            curves(axes[2 * i + j], own, DELIVERED, "training episodes", rng, f"{arena}, taught with {setup}")
    legend(figure, axes[0])
    return figure


def _claims(done: Done, last: int, rng: np.random.Generator) -> Iterator[Claim]:
    def rows(setup: str, what: str, arena: str) -> list[Recalled]:
        return pick(done.recalls, name_of(setup, what), 0 if what == NEITHER else last, arena)

    def told(setup: str, what: str, arena: str, measure: Measure[Recalled] = DELIVERED) -> str:
        return _percent(mean(rows(setup, what, arena), measure, rng).value)

    for arena in ARENAS:
        for setup in (ONE, ALL):
            yield judged(
                f"{arena}, {setup}: learned behaviours are as good as hand-coded ones",
                "4.8",
                difference(rows(setup, ACTIONS, arena), rows(setup, NEITHER, arena), DELIVERED, rng),
                Within(SAME),
                _food,
                "",
                f"Under the teacher's program, after {last} episodes, {told(setup, ACTIONS, arena)} of the food is "
                f"delivered with learned behaviours and {told(setup, NEITHER, arena)} with the hand-coded ones.",
            )
            yield judged(
                f"{arena}, {setup}: the complete imitation learning system brings most of the food home",
                "4.8, 6.2",
                mean(rows(setup, BOTH, arena), DELIVERED, rng),
                Above(MOST),
                _percent,
                "",
                f"After {last} episodes program and behaviours, both learned, deliver {told(setup, BOTH, arena)}; the "
                f"same program with hand-coded behaviours {told(setup, PROGRAM, arena)}.",
            )
        yield judged(
            f"{arena}: variety of the episodes helps the complete system",
            "5.5, 6.2",
            difference(rows(ALL, BOTH, arena), rows(ONE, BOTH, arena), DELIVERED, rng),
            Above(0.0),
            _food,
            "",
            f"{told(ALL, BOTH, arena)} after {last} episodes with {ALL}, {told(ONE, BOTH, arena)} after as many from "
            f"{ONE}.",
        )


EXPERIMENT = Experiment(
    "action_level",
    "Action level",
    "4.8, 6.2",
    "Can the behaviours be learned by imitation as well, and does the learner forage with both: the complete "
    "imitation learning system?",
    "The thesis' learner executes the behaviour that it hears, so it has it already. This one has none. In training"
    " the teacher transmits, beside its word, what it tells its motors: two wheels, arm and jaw. The learner drives"
    " just those; following (4.5.2), which is given as in the thesis, bends its way towards the teacher. It records"
    " its own raw data, the word, and what its own motors were told, following included. From these it learns its "
    "program as the thesis' learner does, and for each word a regression from raw data to motors: ten extremely "
    "randomised trees of scikit-learn with their default settings, the mean for the wheels, the majority for arm "
    "and jaw. Places in the raw data are taken as distances and bearings from the robot, as 4.3 takes them as "
    "distances. A behaviour never heard is to stand still. Nothing else of the hand-coded behaviours is known to "
    "the learner. The episodes are those of the set-up of figure 5.1, or with start and food at random places in "
    "each.",
    (ONE, ALL),
    run,
    report,
)
