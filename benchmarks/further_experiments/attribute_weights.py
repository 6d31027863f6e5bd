"""Attribute weights: the attributes of the state vector count differently in the distance (5.4.1.2, 5.5)."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from further_experiments.analysis import (
    ABOUT,
    DELIVERED,
    FOOD_POINTS,
    FURTHER,
    NEARER,
    PLACES,
    SCORE,
    STEPS,
    Analysis,
    at,
    claim,
)
from further_experiments.episodes import ARENAS, Files, imitator, recall_all, thesis_files
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.rows import RecallEpisode, Row
from khepera_forage.estimates import Measure, pick
from khepera_forage.figures import COLOURS, MARKERS, SMALL, entry, grid, mark, panels
from khepera_forage.policies import Policy
from khepera_forage.policies.adapters import ClassifierPolicy
from khepera_forage.policies.brute_force import WeightedImitator
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import arrays
from khepera_forage.thesis.claims.claim import Above, Claim, Within, points

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
TESTED = ("food ×2", "food ×4", "food ×8", LEARNED)
SAME = 10.0
"""Points of food delivered within which two places count as equal. Our decision."""


def run(trial: Trial) -> list[Row]:
    """The same training files for all weights, and the same recalls."""
    files, trainings = thesis_files(trial)
    rows: list[Row] = [*trainings]
    for arena in ARENAS:
        env = recall_env(arena, limit=trial.size.steps)
        for amount in trial.size.amounts:
            for name, policy in _policies(files[:amount], env.diagonal, trial.replication):
                rows += recall_all(env, policy, trial, amount, files[:amount], name)
        env.close()
    return rows


def _policies(files: Files, diagonal: int, seed: int) -> Iterator[tuple[str, Policy]]:
    """One learner for each set of weights."""
    vectors, behaviours = arrays(list(files))
    for name, weights in FIXED.items():
        if name == EQUAL:
            yield name, imitator(files, diagonal)
        else:
            weighted = WeightedImitator(diagonal, weights).fit(vectors, behaviours)
            yield name, ClassifierPolicy(weighted, remember=True)
    # Cross-validation leaves out whole episodes. Of a single episode nothing would be left, so it leaves out vectors.
    groups = np.repeat(np.arange(len(files)), [len(file) for file in files]) if len(files) > 1 else None
    learned = WeightedImitator(diagonal, random_state=seed).fit(vectors, behaviours, groups)
    yield LEARNED, ClassifierPolicy(learned, remember=True)


def report(found: Analysis) -> Report:
    """Whether weights solve area 1, and their effect on the whole task."""
    last = max(found.amounts)
    note = "Noise of the laboratory; the same training files and the same recalls for all weights."
    tables = (found.recall_table(note, (SCORE, DELIVERED, STEPS)), found.places_table(last))
    return Report(list(_claims(found, last)), tables, _figure(found, last), _summary(found, last))


def _summary(found: Analysis, last: int) -> str:
    def rows(name: str, arena: str = "corridor") -> list[RecallEpisode]:
        return pick(found.recalls, condition=name, amount=last, arena=arena)

    def far(name: str) -> str:
        return found.percent(at(rows(name), FURTHER))

    few, some, many = TESTED[:3]
    return (
        f"After {last} episodes, counting the distance of the food four times changes the delivered share of the food "
        f"that lies further out in the corridor from {far(EQUAL)} to {far(some)} (twice: {far(few)}, eight times: "
        f"{far(many)}), and the score in the corridor from {found.percent(rows(EQUAL), SCORE)} to "
        f"{found.percent(rows(some), SCORE)}. In the rectangle it changes the food delivered from "
        f"{found.percent(rows(EQUAL, 'rectangle'))} to {found.percent(rows(some, 'rectangle'))}. Weights learned from "
        f"the files deliver {far(LEARNED)} of the food further out, and {found.percent(rows(LEARNED, 'rectangle'))} in "
        "the rectangle."
    )


def _figure(found: Analysis, last: int) -> "Figure":
    figure, axes = panels(4, "Attribute weights in the distance of 4.6.1")
    for panel, arena in zip(axes, ARENAS, strict=False):
        own = pick(found.recalls, arena=arena)
        lines = {
            f"{amount} training episode{'s' * (amount > 1)}": pick(own, amount=amount)
            for amount in dict.fromkeys((min(found.amounts), last))
        }
        _curves(panel, found, lines, SCORE)
        panel.set_title(arena, fontsize=10)
    own = pick(found.recalls, amount=last)
    _curves(axes[2], found, {f"food {place}": at(own, place) for place in PLACES}, DELIVERED)
    _curves(axes[3], found, {"both food objects": pick(own, arena="rectangle")}, DELIVERED)
    for panel, arena in zip(axes[2:], ARENAS, strict=True):
        panel.set_title(f"{arena}, {last} episodes", fontsize=10)
        panel.set_xlabel("weight; bars: 95 % interval over replications")
    return figure


def _curves(
    axes: "Axes",
    found: Analysis,
    lines: Mapping[str, Sequence[RecallEpisode]],
    measure: Measure[RecallEpisode],
) -> None:
    """For each group of recalls a curve over the fixed weights, and a point for the learned ones."""
    for i, (name, rows) in enumerate(lines.items()):
        means = [found.mean(pick(rows, condition=condition), measure) for condition in CONDITIONS]
        places = [place + 0.14 * (i - (len(lines) - 1) / 2) for place in range(len(means))]
        fixed = slice(len(FIXED))
        axes.plot(places[fixed], [e.value for e in means[fixed]], color=COLOURS[i], lw=1)
        entry(axes, name, COLOURS[i], MARKERS[i], "-")
        for place, estimate in zip(places, means, strict=True):
            mark(axes, place, estimate.value, estimate, COLOURS[i], marker=MARKERS[i])
    axes.set_xticks(range(len(CONDITIONS)), CONDITIONS, fontsize=SMALL)
    axes.set_ylim(-10 if measure is SCORE else -4, 104)
    axes.set_ylabel(measure.name)
    grid(axes)
    axes.legend(fontsize=SMALL)


def _claims(found: Analysis, last: int) -> Iterator[Claim]:
    def rows(name: str, arena: str = "corridor") -> list[RecallEpisode]:
        return pick(found.recalls, condition=name, amount=last, arena=arena)

    def lying(name: str, place: str) -> list[RecallEpisode]:
        return at(rows(name), place)

    def food(name: str, place: str) -> str:
        return found.percent(lying(name, place))

    for name in TESTED:
        yield claim(
            f"corridor, food further out: {name} delivers more than equal weights",
            "5.4.1.2",
            found.difference(lying(name, FURTHER), lying(EQUAL, FURTHER), DELIVERED),
            Above(0.0),
            FOOD_POINTS,
            f"After {last} episodes {name} delivers {food(name, FURTHER)} of the food that lies further out, equal "
            f"weights {food(EQUAL, FURTHER)}; of the food nearer home {food(name, NEARER)} and {food(EQUAL, NEARER)}.",
        )
    for name in TESTED:
        yield claim(
            f"corridor: with {name} food further out is delivered as often as where it lay in training",
            "5.4.1.2",
            found.difference(lying(name, FURTHER), lying(name, ABOUT), DELIVERED),
            Within(SAME),
            FOOD_POINTS,
            f"{food(name, FURTHER)} against {food(name, ABOUT)}; equal weights {food(EQUAL, FURTHER)} against "
            f"{food(EQUAL, ABOUT)}.",
        )
    for arena in ARENAS:
        for name in TESTED:
            own, equal = rows(name, arena), rows(EQUAL, arena)
            yield claim(
                f"{arena}: {name} scores more than equal weights",
                "5.5",
                found.difference(own, equal, SCORE),
                Above(0.0),
                points,
                f"After {last} episodes {found.percent(own, SCORE)} and {found.percent(equal, SCORE)}; food delivered "
                f"{found.percent(own)} and {found.percent(equal)}.",
            )


EXPERIMENT = Experiment(
    "attribute_weights",
    "Attribute weights",
    "5.4.1.2, 5.5",
    "Does a larger weight of the distance from the food solve area 1?",
    "The thesis predicts that the distance from the food is more significant than the distance from home, and that a "
    "larger weight of it would help with the food that is missed in area 1. (Here: food further out than in training, "
    "where our learner misses it. Both sides are shown, because figure 5.4 does not tell for certain which end is "
    "area 1.) The reason: in training, start, food and home lie on one line. With equal weights, a robot next to food "
    "that lies further out is therefore equally far from all vectors of SEARCH, MOVE SLOWLY and ORIENT. Any weight of "
    "the food above that of the home breaks this tie in favour of ORIENT. So the weights are fixed in advance: the "
    "distance from the food counts twice, four times and eight times, everything else once; as a control, the "
    "distance from home counts four times. *Learned*: the weights with the smallest leave-one-out error on the "
    "training files (`WeightedImitator`), which contain only one set-up. One set of training files a replication, and "
    "the same recalls for all.",
    ("all",),
    run,
    report,
)
