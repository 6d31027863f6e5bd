"""Experiment 10: one teacher, several learners at once (4.5)."""

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    ATTEMPTS,
    ROUNDS,
    SEPARATIONS,
    TRUE,
    WAITED,
    Measure,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import learn, training_seeds
from _further_work.pictures import curves, legend, panels
from _further_work.rows import Done, Lesson, Unit
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.thesis.claims.claim import Above, Claim, Rule, judged
from khepera_forage.thesis.claims.claim import Unit as Scale

LEARNERS = (1, 2, 3, 4)
PRICE = Measure[Lesson]("rounds of all attempts, by learners", lambda row: row.all_rounds / row.amount)
_rounds, _attempts = Scale("rounds", ".1f"), Scale("attempts", ".2f")
_MEASURES = (ATTEMPTS, ROUNDS, WAITED, SEPARATIONS, PRICE, TRUE)


def run(unit: Unit) -> Done:
    """Lessons with some number of learners."""
    learners = int(unit.condition)
    unit = unit._replace(condition="one teacher")
    env = TrainingEnv(num_learners=learners)
    lessons = [
        lesson for _, lesson in learn(env, unit, training_seeds(unit).spawn(unit.size.files), amount=learners)
    ]
    env.close()
    return Done(tuple(lessons))


def report(done: Done, rng: np.random.Generator) -> Report:
    """What an episode with several learners costs."""
    note = (
        "Noise of the laboratory. Rounds, waiting and separations are of the complete attempt. The price of "
        "an "
        "experience file is the rounds of all attempts at an episode by the number of learners who take a "
        "file from it."
    )
    table = means_table("lessons", "Training", note, "learners", done.lessons, _MEASURES, rng)
    figure, axes = panels(4, "Several learners at once, one teacher")
    for panel, measure in zip(axes, (WAITED, ROUNDS, ATTEMPTS, PRICE), strict=True):
        curves(panel, done.lessons, measure, "learners", rng, share=False)
        panel.set_ylim(bottom=0)
    legend(figure, axes[0])
    claims = (
        _claim(done, "Waiting for the slowest costs rounds", WAITED, Above(0.0), _rounds, rng),
        _claim(done, "A complete episode takes more rounds", ROUNDS, Above(0.0), _rounds, rng),
        _claim(done, "More attempts are needed", ATTEMPTS, Above(0.0), _attempts, rng),
        _claim(done, "A learner's file costs the teacher more rounds", PRICE, Above(0.0), _rounds, rng),
    )
    return Report(claims, (table,), figure)


def _claim(
    done: Done, name: str, measure: Measure[Lesson], rule: Rule, show: Scale, rng: np.random.Generator
) -> Claim:
    few, most = LEARNERS[0], LEARNERS[-1]
    one, many = pick(done.lessons, amount=few), pick(done.lessons, amount=most)
    by_number = ", ".join(
        f"{show(mean(pick(done.lessons, amount=n), measure, rng).value)} with {n}" for n in LEARNERS
    )
    return judged(
        f"{name} ({most} learners against {few})",
        "4.5",
        difference(many, one, measure, rng),
        rule,
        show,
        "",
        f"{measure.name[0].upper()}{measure.name[1:]}: {by_number}.",
    )


EXPERIMENT = Experiment(
    "company",
    "Several learners at once",
    "4.5, 6.2",
    "Does waiting for the slowest of several learners cost?",
    "One teacher and 1, 2, 3 or 4 learners, each in its own copy of the corridor. The teacher waits, in "
    "silence, while any "
    "of them is separated; an episode is complete when all have delivered and left home, and an attempt "
    "fails when any "
    "stays separated for ten seconds.",
    tuple(map(str, LEARNERS)),
    run,
    report,
)
