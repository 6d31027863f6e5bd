"""Experiment 6: another body than the teacher's, its program copied or imitated (1.2)."""

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    ATTEMPTS,
    DELIVERED,
    ROUNDS,
    SCORE,
    STEPS,
    TRUE,
    amounts_of,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import ARENAS, imitator, learn, recall_all, training_seeds
from _further_work.pictures import legend, levels, panels
from _further_work.rows import Done, Lesson, Recalled, Unit
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import Teacher
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import HopelessTraining
from khepera_forage.sim.arena import ARENAS as FLOORS
from khepera_forage.sim.arena import CORRIDOR, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.thesis.claims.claim import Above, Claim, judged
from khepera_forage.thesis.claims.claim import Unit as Scale
from khepera_forage.thesis.statistics import UNKNOWN

BODIES = {
    "the teacher's own": RobotParameters(),
    "infra-reds at 30 %": RobotParameters(infra_red_gain=0.3),
    "blind infra-reds": RobotParameters(infra_red_gain=0.0),
    "left wheel 20 % lazy": RobotParameters(left_wheel_error=-0.2),
    "left wheel 30 % lazy": RobotParameters(left_wheel_error=-0.3),
    "fingers of 30 mm": RobotParameters(finger_length=30.0),
    "arm reads 231 when raised": RobotParameters(arm_reading_scale=0.6),
}
_points = Scale("points of food delivered", "+.1f")
_percent = Scale("%", ".1f")


def run(unit: Unit) -> Done:
    """Forage with the teacher's program in this body; take lessons in it, and forage with what they left."""
    body = BODIES[unit.condition]
    env = TrainingEnv(
        world=PymunkWorld(copies(CORRIDOR, 2), (1, 2), robot_parameters=(RobotParameters(), body))
    )
    lessons: list[Lesson] = []
    files: list[Experience] = []
    try:
        for experience, lesson in learn(env, unit, training_seeds(unit).spawn(unit.size.files)):
            files.append(experience)
            lessons.append(lesson)
    except HopelessTraining:
        pass  # A finding: in this body lessons hardly ever succeed.
    env.close()
    recalls: list[Recalled] = []
    for arena in ARENAS:
        alone = recall_env(arena, world=PymunkWorld([FLOORS[arena]], (2,), robot_parameters=(body,)))
        recalls += recall_all(alone, Teacher(alone.home_radius), unit, 0)
        for amount in (n for n in unit.size.amounts if n <= len(files)):
            learner = imitator(files[:amount], alone.diagonal)
            recalls += recall_all(alone, learner, unit, amount, files[:amount])
        alone.close()
    return Done(tuple(lessons), tuple(recalls))


def report(done: Done, rng: np.random.Generator) -> Report:
    """Which body is served better by imitating than by copying."""
    claims = tuple(_claim(done, body, arena, rng) for body in BODIES for arena in ARENAS)
    tables = (
        means_table(
            "recalls",
            "Recall",
            "0 episodes: the teacher's program, copied. The score counts steps in which the robot did what "
            "that program would "
            "have done on the robot's own readings, so a copy is always right; food delivered is what tells.",
            "episodes",
            done.recalls,
            (DELIVERED, SCORE, STEPS),
            rng,
        ),
        means_table(
            "lessons",
            "Training",
            "The teacher has its own body, the learner this one. A learner whose lesson failed a hundred "
            "times in a row gets no "
            "more of them.",
            "files",
            done.lessons,
            (ATTEMPTS, ROUNDS, TRUE),
            rng,
        ),
    )
    last = max(amounts_of(done.recalls), default=0)
    figure, axes = panels(2, "Different bodies: the teacher's program copied, and imitated")
    for panel, arena in zip(axes, ARENAS, strict=True):
        levels(
            panel,
            {
                body: [mean(pick(done.recalls, body, n, arena), DELIVERED, rng) for n in (0, last)]
                for body in BODIES
            },
            ("copied", f"imitated, {last} episodes"),
            f"{DELIVERED.name}, {arena}",
        )
        panel.set_xlim(-4, 104)
    axes[1].set_yticklabels([])
    legend(figure, axes[0])
    return Report(claims, tables, figure)


def _claim(done: Done, body: str, arena: str, rng: np.random.Generator) -> Claim:
    rows = pick(done.recalls, body, arena=arena)
    copied, last = pick(rows, amount=0), max(amounts_of(rows), default=0)
    imitated = pick(rows, amount=last) if last else []
    told = (
        f"the learner, after {last} episodes in it, {_percent(mean(imitated, DELIVERED, rng).value)}"
        if imitated
        else "nobody can be taught in it: lessons were never complete"
    )
    return judged(
        f"{body}, {arena}: imitating delivers more than copying",
        "1.2",
        difference(imitated, copied, DELIVERED, rng) if imitated else UNKNOWN,
        Above(0.0),
        _points,
        "",
        f"The copied program delivers {_percent(mean(copied, DELIVERED, rng).value)} of the food with this "
        f"body; {told}.",
    )


EXPERIMENT = Experiment(
    "bodies",
    "Different bodies",
    "1.2, 6.3",
    "In another body, does imitating the teacher's program serve better than copying it?",
    "The learner's body differs from the teacher's in one way. Copied: the teacher's own tree and rules "
    "forage in that "
    "body. Imitated: the learner is trained in that body, in the set-up of figure 5.1, beside a teacher in "
    "its own, and "
    "recalls in it. The ten behaviours are given in both (4.2.1): what may differ is when each is executed. "
    "Weak or "
    "blind infra-reds, a lazy wheel and short fingers change what behaviours achieve, but neither camera nor "
    "state "
    "vector. An arm that reads 231 when it is raised, where figure 4.2 asks for 225 or less, changes what "
    "the robot "
    "perceives.",
    tuple(BODIES),
    run,
    report,
)
