"""Experiment 1: training and recall for food to be pushed and food to be avoided, alone and mixed (5.5, 6.2)."""

from collections.abc import Sequence

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    ATTEMPTS,
    POISON_HOME,
    ROUNDS,
    SCORE,
    SETTLED,
    STEPS,
    TRUE,
    amounts_of,
    combined,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import ARENAS, imitator, learn, recall_all, training_seeds
from _further_work.pictures import curves, legend, panels
from _further_work.rows import Done, Recalled, Unit
from khepera_forage.envs.arguments import FoodOdds
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies.uniform import UniformPolicy
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.thesis.claims.claim import (
    Above,
    AtMost,
    Claim,
    judged,
    percent_change,
    points,
)
from khepera_forage.thesis.claims.claim import Unit as Scale
from khepera_forage.thesis.statistics import FEWEST, Estimate, replications, wilson

FOOD: dict[str, FoodOdds] = {
    "pickable": "PICKABLE",
    "pushable": "PUSHABLE",
    "poisonous": "POISONOUS",
    "mixed": {"PICKABLE": 1.0, "PUSHABLE": 1.0, "POISONOUS": 1.0},
}
FEW = 5.0
"""Percent of the poison that may be brought home by a learner that has learned to avoid it."""
_share = Scale("%", ".1f")


def run(unit: Unit) -> Done:
    """Lessons and recalls with one kind of food; after 0 episodes behaviours are drawn at random."""
    odds = FOOD[unit.condition]
    env = TrainingEnv(food_types=odds)
    taught = list(learn(env, unit, training_seeds(unit).spawn(unit.size.files)))
    env.close()
    files = [experience for experience, _ in taught]
    recalls: list[Recalled] = []
    for arena in ARENAS:
        alone = recall_env(arena, food_types=odds)
        recalls += recall_all(alone, UniformPolicy(), unit, 0)
        for amount in unit.size.amounts:
            learner = imitator(files[:amount], alone.diagonal)
            recalls += recall_all(alone, learner, unit, amount, files[:amount])
        alone.close()
    return Done(tuple(lesson for _, lesson in taught), tuple(recalls))


def report(done: Done, rng: np.random.Generator) -> Report:
    """Whether the thesis' conclusions hold for every kind of food."""
    claims = [claim for food in FOOD for claim in _claims(food, pick(done.recalls, food), rng)]
    note = (
        "Noise of the laboratory. Settled: delivered, or known to be poisonous and not brought home. 0 "
        "episodes: every "
        "behaviour drawn at random. A recall ends when all food is settled or was poison brought home."
    )
    tables = (
        means_table(
            "recalls", "Recall", note, "episodes", done.recalls, (SCORE, SETTLED, POISON_HOME, STEPS), rng
        ),
        means_table(
            "lessons",
            "Training",
            "Until an episode is complete. With poison that is when both robots have left it, their arms up "
            "again.",
            "files",
            done.lessons,
            (ATTEMPTS, ROUNDS, TRUE),
            rng,
        ),
    )
    figure, axes = panels(4, "Push and avoid: the same conclusions?")
    for i, arena in enumerate(ARENAS):
        trained = [row for row in done.recalls if row.arena == arena]
        curves(axes[2 * i], [row for row in trained if row.amount], SCORE, "training episodes", rng, arena)
        curves(axes[2 * i + 1], trained, SETTLED, "training episodes", rng, arena)
    legend(figure, axes[0])
    return Report(tuple(claims), tables, figure)


def _claims(food: str, rows: Sequence[Recalled], rng: np.random.Generator) -> list[Claim]:
    amounts = amounts_of(rows)
    first, second, last = amounts[0], amounts[1], amounts[-1]
    claims = []
    for arena in ARENAS:
        own = pick(rows, arena=arena)
        few, many = pick(own, amount=first), pick(own, amount=last)
        claims.append(
            judged(
                f"{food}, {arena}: more episodes improve the learner",
                "5.4",
                difference(many, few, SCORE, rng),
                Above(0.0),
                points,
                "",
                f"Mean score {_told(mean(many, SCORE, rng))} after {last} episodes and "
                f"{_told(mean(few, SCORE, rng))} after {first}; food settled "
                f"{_told(mean(many, SETTLED, rng))} and "
                f"{_told(mean(few, SETTLED, rng))}.",
            )
        )
    own = pick(rows, arena="corridor")
    before = amounts[-2]
    early, late = 1.0 / (second - first), 1.0 / (last - before)
    # The gain early on less the gain later: positive where the gain shrinks.
    groups = [
        (early, pick(own, amount=second)),
        (-early, pick(own, amount=first)),
        (-late, pick(own, amount=last)),
        (late, pick(own, amount=before)),
    ]
    claims.append(
        judged(
            f"{food}, corridor: the gain from an episode shrinks",
            "5.4.1.2",
            combined(groups, SCORE, rng),
            Above(0.0),
            points,
            "",
            f"From {first} to {second} episodes an episode brings {_gain(own, first, second, rng)}, from "
            f"{before} to {last} "
            f"{_gain(own, before, last, rng)}; the effect is the difference.",
        )
    )
    far = pick(rows, arena="rectangle")
    learned, chance = pick(far, amount=last), pick(far, amount=0)
    apart = difference(learned, chance, SETTLED, rng)
    claims.append(
        judged(
            f"{food}: trained in the corridor, it forages in the rectangle",
            "5.4.2",
            Estimate(*(value / 100 for value in apart)),
            Above(0.0),
            percent_change,
            "",
            f"After {last} episodes it settles {_told(mean(learned, SETTLED, rng))} of the food there; "
            "behaviours drawn at "
            f"random settle {_told(mean(chance, SETTLED, rng))}.",
        )
    )
    if food in ("poisonous", "mixed"):
        home = _poison_home(pick(rows, amount=last), rng)
        claims.append(
            judged(
                f"{food}: the learner leaves poison alone",
                "5.5",
                home,
                AtMost(FEW),
                _share,
                "",
                f"After {last} episodes it brings home {_told(home)} of all food objects as poison, both "
                "arenas together.",
            )
        )
    return claims


def _poison_home(rows: Sequence[Recalled], rng: np.random.Generator) -> Estimate:
    """The share of poison brought home; of none at all, resampling would make an interval without width."""
    if any(row.poison_home for row in rows) or len(replications(rows)) < FEWEST:
        return mean(rows, POISON_HOME, rng)
    return Estimate(*(100 * value for value in wilson(0, sum(row.foods for row in rows))))


def _gain(rows: Sequence[Recalled], before: int, after: int, rng: np.random.Generator) -> str:
    gain = difference(pick(rows, amount=after), pick(rows, amount=before), SCORE, rng).value
    return points(gain / (after - before))


def _told(estimate: Estimate) -> str:
    return _share(estimate.value)


EXPERIMENT = Experiment(
    "push_avoid",
    "Push and avoid",
    "5.5, 6.2",
    "Do the thesis' conclusions about picking up hold for pushing and avoiding too?",
    "Training in the corridor and recall in both arenas, once with each type of food alone and once with "
    "every object of "
    "a type drawn at equal odds (its training files are then of one type each, as drawn). The conclusions "
    "are those of "
    "chapter 5: more episodes improve the learner, ever less, and what was learned in the corridor serves in "
    "the "
    "rectangle. A training episode with poison is complete when both robots have left it: one that ended "
    "with the "
    "knowledge would never show AVOID FOOD.",
    tuple(FOOD),
    run,
    report,
)
