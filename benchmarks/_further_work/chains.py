"""Experiment 7: the trained learner teaches the next, generation after generation (1.2, 6.2)."""

from dataclasses import dataclass

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    AGREEMENT,
    ATTEMPTS,
    DELIVERED,
    DISTINCT,
    ROUNDS,
    TRUE,
    VECTORS,
    Measure,
    RowT,
    amounts_of,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import ARENAS, imitator, learn, recall_all, training_seeds
from _further_work.pictures import curves, legend, panels
from _further_work.rows import Done, Lesson, Recalled, Unit
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experience import Experience
from khepera_forage.policies import Observation, Policy
from khepera_forage.policies.policy import SEPARATED, is_training
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import HopelessTraining
from khepera_forage.task.states import Behaviour
from khepera_forage.thesis.claims.claim import Claim, Rule, Within, judged
from khepera_forage.thesis.claims.claim import Unit as Scale

EPISODES = {"1 episode": 1, "5 episodes": 5}
"""A generation's lessons."""
KEPT_POINTS, KEPT_SHARE = 10.0, 0.25
"""What counts as kept: within so many points, or such a share of what the first generation had. Our decision."""
_percent, _points = Scale("%", ".1f"), Scale("points", "+.1f")
_count, _more = Scale("", ".0f"), Scale("different vectors", "+.0f")


@dataclass(frozen=True, slots=True)
class Demonstrator:
    """A policy in the teacher's place: it waits, in silence, for a learner that got separated (4.5).

    Attributes:
        policy: Who decides otherwise.
    """

    policy: Policy

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The policy's behaviour, or WAIT."""
        if is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        return self.policy.act(observation, rng)


def run(unit: Unit) -> Done:
    """One chain: each generation is taught by the one before it, the first by the teacher."""
    env = TrainingEnv()
    alone = {arena: recall_env(arena) for arena in ARENAS}
    lessons: list[Lesson] = []
    recalls: list[Recalled] = []
    teacher: Policy | None = None
    episodes = min(EPISODES[unit.condition], unit.size.files)
    seeds = training_seeds(unit).spawn(unit.size.generations)
    try:
        for generation, seed in enumerate(seeds, 1):
            files: list[Experience] = []
            for experience, lesson in learn(env, unit, seed.spawn(episodes), generation, teacher):
                files.append(experience)
                lessons.append(lesson)
            for there in alone.values():
                recalls += recall_all(there, imitator(files, there.diagonal), unit, generation, files)
            teacher = Demonstrator(imitator(files, alone["corridor"].diagonal))
    except HopelessTraining:
        pass  # The chain ends: its last generation cannot teach. Later ones have no rows.
    for there in alone.values():
        there.close()
    env.close()
    return Done(tuple(lessons), tuple(recalls))


def report(done: Done, rng: np.random.Generator) -> Report:
    """What the last generation has kept of the first."""
    claims = tuple(claim for condition in EPISODES for claim in _claims(done, condition, rng))
    note = (
        "Generation 1 was taught by the teacher, 2 by generation 1, and so on. Agreement: steps in which the "
        "learner does "
        "what the original teacher would have done. Chains that ended early have no rows for later "
        "generations."
    )
    tables = (
        means_table(
            "recalls",
            "Recall",
            note,
            "generation",
            done.recalls,
            (AGREEMENT, DELIVERED, VECTORS, DISTINCT),
            rng,
        ),
        means_table(
            "lessons",
            "Training",
            "Lessons that the generation took, from the one before it.",
            "generation",
            done.lessons,
            (ATTEMPTS, ROUNDS, TRUE),
            rng,
        ),
    )
    figure, axes = panels(4, "Chains: the trained learner becomes the teacher of the next")
    own = pick(done.recalls, arena="corridor")
    curves(axes[0], own, AGREEMENT, "generation", rng, "corridor")
    curves(axes[1], own, DELIVERED, "generation", rng, "corridor")
    curves(axes[2], own, DISTINCT, "generation", rng, "experience", share=False)
    axes[2].set_ylim(bottom=0)
    curves(axes[3], done.lessons, TRUE, "generation", rng, "lessons")
    legend(figure, axes[0])
    return Report(claims, tables, figure)


def _claims(done: Done, condition: str, rng: np.random.Generator) -> list[Claim]:
    recalls, lessons = pick(done.recalls, condition, arena="corridor"), pick(done.lessons, condition)
    first = mean(pick(recalls, amount=1), DISTINCT, rng).value
    return [
        _claim(
            condition,
            "agreement with the teacher is kept",
            recalls,
            AGREEMENT,
            KEPT_POINTS,
            (_percent, _points),
            rng,
        ),
        _claim(
            condition, "food delivered is kept", recalls, DELIVERED, KEPT_POINTS, (_percent, _points), rng
        ),
        _claim(
            condition,
            "the variety of experience is kept",
            recalls,
            DISTINCT,
            KEPT_SHARE * first,
            (_count, _more),
            rng,
        ),
        _claim(
            condition, "what is shouted is kept true", lessons, TRUE, KEPT_POINTS, (_percent, _points), rng
        ),
    ]


def _claim(
    condition: str,
    name: str,
    rows: list[RowT],
    measure: Measure[RowT],
    margin: float,
    shown: tuple[Scale, Scale],
    rng: np.random.Generator,
) -> Claim:
    """The last generation against the first."""
    generations = amounts_of(rows)
    last = generations[-1]
    rule: Rule = Within(margin)
    by_generation = ", ".join(
        shown[0](mean(pick(rows, amount=g), measure, rng).value).strip() for g in generations
    )
    chains = [len({row.replication for row in pick(rows, amount=g)}) for g in (1, last)]
    return judged(
        f"{condition} a generation: {name}",
        "6.2",
        difference(pick(rows, amount=last), pick(rows, amount=1), measure, rng),
        rule,
        shown[1],
        "",
        f"{measure.name[0].upper()}{measure.name[1:]}, generation by generation: {by_generation} "
        f"({chains[1]} of {chains[0]} chains reached generation {last}).",
    )


EXPERIMENT = Experiment(
    "chains",
    "Chains",
    "1.2, 6.2",
    "When the trained learner teaches the next, generation after generation: what is kept, and what drifts?",
    "The teacher trains generation 1 in the corridor; generation 1, drawing its behaviours with their "
    "confidence levels and "
    "waiting for a separated learner as the teacher does, trains generation 2; and so on. Each lesson is "
    "repeated until an "
    "episode is complete, so what a generation passes on are its successes alone. Recalls are of every "
    "generation.",
    tuple(EPISODES),
    run,
    report,
)
