"""Pushing and avoiding: training and recall for each type of food, alone and mixed (5.5, 6.2)."""

from collections.abc import Sequence

from further_experiments.analysis import (
    ATTEMPTS,
    PERCENT,
    POISON_HOME,
    ROUNDS,
    SCORE,
    SETTLED,
    STEPS,
    TRUE,
    Analysis,
    amounts_of,
    claim,
)
from further_experiments.episodes import ARENAS, recall_all, recall_imitators, thesis_files
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.pictures import INTERVALS, curves
from further_experiments.rows import RecallEpisode, Row
from khepera_forage.envs.arguments import FoodOdds
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import MIN_REPLICATIONS, Estimate, combined, percent, pick, replications
from khepera_forage.figures import legend, panels
from khepera_forage.policies.policy import UniformPolicy
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.thesis.claims.claim import Above, AtMost, Claim, percent_change, points

FOOD: dict[str, FoodOdds] = {
    "pickable": "PICKABLE",
    "pushable": "PUSHABLE",
    "poisonous": "POISONOUS",
    "mixed": {"PICKABLE": 1.0, "PUSHABLE": 1.0, "POISONOUS": 1.0},
}
MAX_POISON_HOME = 5.0
"""Percent of the food that a learner may bring home as poison and still count as one that avoids poison."""


def run(trial: Trial) -> list[Row]:
    """Training and recall with one kind of food. The policy with 0 episodes draws behaviours at random."""
    odds = FOOD[trial.condition]
    files, trainings = thesis_files(trial, TrainingEnv(max_cycles=trial.size.rounds, food_types=odds))
    recalls: list[RecallEpisode] = []
    for arena in ARENAS:
        env = recall_env(arena, limit=trial.size.steps, food_types=odds)
        recalls += recall_all(env, UniformPolicy(), trial, 0)
        recalls += recall_imitators(env, trial, files)
        env.close()
    return [*trainings, *recalls]


def report(found: Analysis) -> Report:
    """Whether the thesis's conclusions hold for every kind of food."""
    recalls = found.recalls
    claims = [made for food in FOOD for made in _claims(found, food, pick(recalls, condition=food))]
    note = (
        "Noise of the laboratory. Settled: delivered, or known to be poisonous and not brought home. 0 episodes: every "
        "behaviour drawn at random. A recall ends when all food is settled or was brought home as poison."
    )
    training_note = (
        "Per complete episode. An episode with poison is complete when both robots have left it, arms raised."
    )
    tables = (
        found.recall_table(note, (SCORE, SETTLED, POISON_HOME, STEPS)),
        found.training_table(training_note, (ATTEMPTS, ROUNDS, TRUE)),
    )
    figure, axes = panels(4, "Pushing and avoiding food")
    for i, arena in enumerate(ARENAS):
        own = pick(recalls, arena=arena)
        curves(axes[2 * i], found, [row for row in own if row.amount], SCORE, "training episodes", arena)
        curves(axes[2 * i + 1], found, own, SETTLED, "training episodes", arena)
    legend(figure, axes[0], INTERVALS)
    return Report(claims, tables, figure)


def _claims(found: Analysis, food: str, rows: Sequence[RecallEpisode]) -> list[Claim]:
    amounts = amounts_of(rows)
    first, last = amounts[0], amounts[-1]
    claims = [_improves(found, food, pick(rows, arena=arena), first, last) for arena in ARENAS]
    claims.append(_gain_shrinks(found, food, pick(rows, arena="corridor"), amounts))
    learned, chance = (pick(rows, arena="rectangle", amount=amount) for amount in (last, 0))
    difference = Estimate(*(value / 100 for value in found.difference(learned, chance, SETTLED)))
    claims.append(
        claim(
            f"{food}: trained in the corridor, it forages in the rectangle",
            "5.4.2",
            difference,
            Above(0.0),
            percent_change,
            f"After {last} episodes it settles {found.percent(learned, SETTLED)} of the food there; behaviours drawn "
            f"at random settle {found.percent(chance, SETTLED)}.",
        )
    )
    if food in ("poisonous", "mixed"):
        home = _poison_home(found, pick(rows, amount=last))
        claims.append(
            claim(
                f"{food}: the learner leaves poison alone",
                "5.5",
                home,
                AtMost(MAX_POISON_HOME),
                PERCENT,
                f"After {last} episodes it brings home {PERCENT(home.value)} of all food objects as poison, in both "
                "arenas together.",
            )
        )
    return claims


def _improves(found: Analysis, food: str, rows: Sequence[RecallEpisode], first: int, last: int) -> Claim:
    few, many = pick(rows, amount=first), pick(rows, amount=last)
    return claim(
        f"{food}, {rows[0].arena}: more episodes improve the learner",
        "5.4",
        found.difference(many, few, SCORE),
        Above(0.0),
        points,
        f"Mean score {found.percent(many, SCORE)} after {last} episodes and {found.percent(few, SCORE)} after {first}; "
        f"food settled {found.percent(many, SETTLED)} and {found.percent(few, SETTLED)}.",
    )


def _gain_shrinks(found: Analysis, food: str, rows: Sequence[RecallEpisode], amounts: Sequence[int]) -> Claim:
    first, second, before, last = (*amounts[:2], *amounts[-2:])
    early, late = 1.0 / (second - first), 1.0 / (last - before)
    # The gain of the first episodes minus that of the last ones: positive where the gain shrinks.
    weights = ((early, second), (-early, first), (-late, last), (late, before))
    groups = [(weight, pick(rows, amount=amount)) for weight, amount in weights]

    def gain(start: int, end: int) -> str:
        value = found.difference(pick(rows, amount=end), pick(rows, amount=start), SCORE).value
        return points(value / (end - start))

    return claim(
        f"{food}, corridor: the gain from an episode shrinks",
        "5.4.1.2",
        combined(groups, SCORE, found.rng),
        Above(0.0),
        points,
        f"From {first} to {second} episodes an episode brings {gain(first, second)}, from {before} to {last} "
        f"{gain(before, last)}; the effect is the difference.",
    )


def _poison_home(found: Analysis, rows: Sequence[RecallEpisode]) -> Estimate:
    """The share of poison brought home. Where there was none, resampling would give an interval without width."""
    if any(row.poison_home for row in rows) or len(replications(rows)) < MIN_REPLICATIONS:
        return found.mean(rows, POISON_HOME)
    return percent(0, sum(row.foods for row in rows))


EXPERIMENT = Experiment(
    "push_and_avoid",
    "Pushing and avoiding",
    "5.5, 6.2",
    "Do the thesis's conclusions about picking up hold for pushing and avoiding, too?",
    "Training in the corridor and recall in both arenas: once with each type of food alone, and once with the type of "
    "every object drawn at equal odds (each training file then has the type that was drawn). The conclusions are those "
    "of chapter 5: more episodes improve the learner, with a gain that shrinks, and what was learned in the corridor "
    "works in the rectangle. A training episode with poison is complete when both robots have left it: an episode that "
    "ended as soon as the poison is identified would never show AVOID FOOD.",
    tuple(FOOD),
    run,
    report,
)
