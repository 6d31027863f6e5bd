"""Experiment 2: attributes that count with different weights (5.4.1.2, 5.5)."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    DELIVERED,
    SCORE,
    STEPS,
    Measure,
    amounts_of,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import ARENAS, Files, imitator, learn, recall_all, training_seeds
from _further_work.pictures import COLOURS, panels
from _further_work.places import ABOUT, FURTHER, NEARER, PLACES, at, places_table
from _further_work.rows import Done, Recalled, Unit
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies import Policy
from khepera_forage.policies.adapters import ClassifierPolicy
from khepera_forage.policies.attribute_weights import WeightedImitator
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import arrays
from khepera_forage.thesis.claims.claim import Above, Claim, Within, judged, points
from khepera_forage.thesis.claims.claim import Unit as Scale
from khepera_forage.thesis.figures import mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
TRIED = ("food ×2", "food ×4", "food ×8", LEARNED)
SAME = 10.0
"""Points of food delivered within which two places count as equal. Our decision."""
_percent = Scale("%", ".1f")
_food = Scale("points of food delivered", "+.1f")


def run(unit: Unit) -> Done:
    """The same lessons for all weights, and the same recalls."""
    env = TrainingEnv()
    taught = list(learn(env, unit, training_seeds(unit).spawn(unit.size.files)))
    env.close()
    files = [experience for experience, _ in taught]
    recalls: list[Recalled] = []
    for arena in ARENAS:
        alone = recall_env(arena)
        for amount in unit.size.amounts:
            for name, policy in _policies(files[:amount], alone.diagonal, unit.replication):
                recalls += recall_all(alone, policy, unit, amount, files[:amount], name)
        alone.close()
    return Done(tuple(lesson for _, lesson in taught), tuple(recalls))


def _policies(files: Files, diagonal: int, seed: int) -> Iterator[tuple[str, Policy]]:
    """One learner for each set of weights."""
    vectors, behaviours = arrays(list(files))
    for name, weights in FIXED.items():
        if name == EQUAL:
            yield name, imitator(files, diagonal)
        else:
            weighted = WeightedImitator(diagonal, weights).fit(vectors, behaviours)
            yield name, ClassifierPolicy(weighted, remember=True)
    # Vectors of one episode are left out together; of a single one nothing would be left, so there each is alone.
    groups = np.repeat(np.arange(len(files)), [len(file) for file in files]) if len(files) > 1 else None
    learned = WeightedImitator(diagonal, random_state=seed).fit(vectors, behaviours, groups)
    yield LEARNED, ClassifierPolicy(learned, remember=True)


def report(done: Done, rng: np.random.Generator) -> Report:
    """Whether area 1 is mended, and what comes of the whole."""
    last = max(amounts_of(done.recalls))
    tables = (
        means_table(
            "recalls",
            "Recall",
            "Noise of the laboratory; the same training files and the same recalls for all weights.",
            "episodes",
            done.recalls,
            (SCORE, DELIVERED, STEPS),
            rng,
        ),
        places_table(done.recalls, last, rng),
    )
    claims = tuple(_claims(done, last, rng))
    return Report(claims, tables, _figure(done.recalls, last, rng), _summary(done.recalls, last, rng))


def _summary(recalls: Sequence[Recalled], last: int, rng: np.random.Generator) -> str:
    def told(name: str, measure: Measure[Recalled], arena: str, place: str = "") -> str:
        rows = pick(recalls, name, last, arena)
        return _percent(mean(at(rows, place) if place else rows, measure, rng).value)

    def out(name: str) -> str:
        return told(name, DELIVERED, "corridor", FURTHER)

    few, some, many = "food ×2", "food ×4", "food ×8"
    return (
        f"After {last} episodes, counting the distance of the food four times changes what is delivered of the "
        f"food that lies further out in the corridor from {out(EQUAL)} to {out(some)} (twice: {out(few)}, eight "
        f"times: {out(many)}), and the score there from {told(EQUAL, SCORE, 'corridor')} to "
        f"{told(some, SCORE, 'corridor')}; in the rectangle it changes the food delivered from "
        f"{told(EQUAL, DELIVERED, 'rectangle')} to {told(some, DELIVERED, 'rectangle')}. Weights learned from "
        f"the files deliver {out(LEARNED)} of the food further out, and {told(LEARNED, DELIVERED, 'rectangle')} "
        "in the rectangle."
    )


def _figure(recalls: Sequence[Recalled], last: int, rng: np.random.Generator) -> "Figure":
    figure, axes = panels(4, "Attribute weights: what counts how much in the distance of 4.6.1")
    for panel, arena in zip(axes, ARENAS, strict=False):
        own = pick(recalls, arena=arena)
        lines = {
            f"{amount} training episode{'s' * (amount > 1)}": pick(own, amount=amount)
            for amount in dict.fromkeys((min(amounts_of(own)), last))
        }
        _curves(panel, lines, SCORE, rng)
        panel.set_title(arena, fontsize=10)
    own = pick(recalls, amount=last)
    _curves(axes[2], {f"food {place}": at(own, place) for place in PLACES}, DELIVERED, rng)
    _curves(axes[3], {"both food objects": pick(own, arena="rectangle")}, DELIVERED, rng)
    for panel, arena in zip(axes[2:], ARENAS, strict=True):
        panel.set_title(f"{arena}, {last} episodes", fontsize=10)
        panel.set_xlabel("weight; bars: 95 % interval over replications")
    return figure


def _curves(
    axes: "Axes",
    lines: Mapping[str, Sequence[Recalled]],
    measure: Measure[Recalled],
    rng: np.random.Generator,
) -> None:
    """For each group of recalls a curve over the weights that are fixed, and a point for those that are learned."""
    for i, (name, rows) in enumerate(lines.items()):
        means = [mean(pick(rows, condition), measure, rng) for condition in CONDITIONS]
        places = [place + 0.14 * (i - (len(lines) - 1) / 2) for place in range(len(means))]
        fixed = slice(len(FIXED))
        axes.plot(places[fixed], [e.value for e in means[fixed]], color=COLOURS[i], lw=1, label=name)
        for place, estimate in zip(places, means, strict=True):
            mark(axes, place, estimate.value, estimate, COLOURS[i])
    axes.set_xticks(range(len(CONDITIONS)), CONDITIONS, fontsize=8)
    axes.set_ylim(-10 if measure is SCORE else -4, 104)
    axes.set_ylabel(measure.name)
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
    axes.legend(fontsize=7)


def _claims(done: Done, last: int, rng: np.random.Generator) -> Iterator[Claim]:
    def rows(name: str, arena: str = "corridor", place: str = "") -> list[Recalled]:
        found = pick(done.recalls, name, last, arena)
        return at(found, place) if place else found

    def food(name: str, place: str) -> str:
        return _percent(mean(rows(name, place=place), DELIVERED, rng).value)

    for name in TRIED:
        yield judged(
            f"corridor, food further out: {name} delivers more than equal weights",
            "5.4.1.2",
            difference(rows(name, place=FURTHER), rows(EQUAL, place=FURTHER), DELIVERED, rng),
            Above(0.0),
            _food,
            "",
            f"After {last} episodes {name} delivers {food(name, FURTHER)} of the food that lies further out, equal "
            f"weights {food(EQUAL, FURTHER)}; of the food nearer home {food(name, NEARER)} and {food(EQUAL, NEARER)}.",
        )
    for name in TRIED:
        yield judged(
            f"corridor: with {name} food further out is delivered as often as where it lay in training",
            "5.4.1.2",
            difference(rows(name, place=FURTHER), rows(name, place=ABOUT), DELIVERED, rng),
            Within(SAME),
            _food,
            "",
            f"{food(name, FURTHER)} against {food(name, ABOUT)}; equal weights {food(EQUAL, FURTHER)} against "
            f"{food(EQUAL, ABOUT)}.",
        )
    for arena in ARENAS:
        for name in TRIED:
            yield judged(
                f"{arena}: {name} scores more than equal weights",
                "5.5",
                difference(rows(name, arena), rows(EQUAL, arena), SCORE, rng),
                Above(0.0),
                points,
                "",
                f"After {last} episodes {_percent(mean(rows(name, arena), SCORE, rng).value)} and "
                f"{_percent(mean(rows(EQUAL, arena), SCORE, rng).value)}; food delivered "
                f"{_percent(mean(rows(name, arena), DELIVERED, rng).value)} and "
                f"{_percent(mean(rows(EQUAL, arena), DELIVERED, rng).value)}.",
            )


EXPERIMENT = Experiment(
    "attribute_weights",
    "Attribute weights",
    "5.4.1.2, 5.5",
    "Does weighting the distance of the food above that of the home mend area 1?",
    "The thesis' prediction: the distance from the food is more significant than that from the home, and weighting "
    "it more would mend the food that is missed in area 1 (here: food further out than in training, where our "
    "learner misses it; both sides are shown, as figure 5.4 does not tell for certain which end is area 1). The "
    "argument for it: in training start, food and home lie on one line, so with equal weights a robot next to food "
    "that lies further out is equally far from all vectors of SEARCH, MOVE SLOWLY and ORIENT; any weight of the "
    "food above that of the home breaks the tie in favour of ORIENT. So the weights are fixed beforehand: the "
    "distance of the food counts twice, four times and eight times, all else once; with, for control, the distance "
    "of the home four times. *Learned*: the weights with the least leave-one-out error on the training files "
    "(`WeightedImitator`), which are of one set-up and know of no other. One set of training files a replication, "
    "and the same recalls for all.",
    ("all",),
    run,
    report,
)
