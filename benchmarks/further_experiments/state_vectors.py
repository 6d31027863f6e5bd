"""Two experiments on what is compared with the records: attribute weights, and a redesigned state vector."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from further_experiments.episodes import (
    ARENAS,
    Files,
    Moment,
    imitator,
    observe,
    recall_all,
    thesis_files,
    training_seeds,
)
from further_experiments.experiment import (
    ABOUT,
    DELIVERED,
    EPISODES,
    FOOD_POINTS,
    FURTHER,
    INTERVALS,
    PLACES,
    SCORE,
    STEPS,
    Analysis,
    Experiment,
    RecallEpisode,
    Report,
    Row,
    Trial,
    at,
    claim,
    curves,
    occurring,
    spent,
    wrong,
)
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Measure, pick
from khepera_forage.figures import COLOURS, MARKERS, SMALL, entry, grid, legend, levels, mark, panels
from khepera_forage.geometry.plane import length
from khepera_forage.policies import (
    ClassifierPolicy,
    NearestNeighbourImitator,
    Observation,
    Policy,
    WeightedImitator,
)
from khepera_forage.robots.khepera import FINGER_TIP
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import arrays
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour, StateVector
from khepera_forage.thesis.claims.claim import Claim, above, points, within
from khepera_forage.vision.scene import MM_PER_PIXEL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SAME = 10.0
"""Points of food delivered, or of score, within which two places or arenas count as equal. Our decision."""
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


def run_weights(trial: Trial) -> list[Row]:
    """The same training files for all weights, and the same recalls."""
    files, trainings = thesis_files(trial)
    rows: list[Row] = [*trainings]
    for arena in ARENAS:
        env = recall_env(arena, limit=trial.size.steps)
        for amount in trial.size.amounts:
            for name, policy in _weighted(files[:amount], env.diagonal, trial.replication):
                rows += recall_all(env, policy, trial, amount, files[:amount], name)
        env.close()
    return rows


def _weighted(files: Files, diagonal: int, seed: int) -> Iterator[tuple[str, Policy]]:
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


def report_weights(found: Analysis) -> Report:
    """Whether weights solve area 1, and their effect on the whole task."""
    last = max(found.amounts)
    note = "Noise of the laboratory; the same training files and the same recalls for all weights."
    tables = (found.recall_table(note, (SCORE, DELIVERED, STEPS)), found.places_table(last))
    return Report(list(_weight_claims(found, last)), tables, _weight_figure(found, last))


def _weight_figure(found: Analysis, last: int) -> "Figure":
    figure, axes = panels(4, "Attribute weights in the distance of 4.6.1")
    for panel, arena in zip(axes, ARENAS, strict=False):
        own = pick(found.recalls, arena=arena)
        lines = {
            f"{amount} training episode{'s' * (amount > 1)}": pick(own, amount=amount)
            for amount in dict.fromkeys((min(found.amounts), last))
        }
        _weight_curves(panel, found, lines, SCORE)
        panel.set_title(arena, fontsize=10)
    own = pick(found.recalls, amount=last)
    _weight_curves(axes[2], found, {f"food {place}": at(own, place) for place in PLACES}, DELIVERED)
    _weight_curves(axes[3], found, {"both food objects": pick(own, arena="rectangle")}, DELIVERED)
    for panel, arena in zip(axes[2:], ARENAS, strict=True):
        panel.set_title(f"{arena}, {last} episodes", fontsize=10)
        panel.set_xlabel(f"weight; {INTERVALS}")
    return figure


def _weight_curves(
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


def _weight_claims(found: Analysis, last: int) -> Iterator[Claim]:
    def rows(name: str, arena: str = "corridor") -> list[RecallEpisode]:
        return pick(found.recalls, condition=name, amount=last, arena=arena)

    for name in TESTED:
        effect = found.difference(at(rows(name), FURTHER), at(rows(EQUAL), FURTHER), DELIVERED)
        statement = f"corridor, food further out: {name} delivers more than equal weights"
        yield claim(statement, effect, above(0.0), FOOD_POINTS)
    for name in TESTED:
        effect = found.difference(at(rows(name), FURTHER), at(rows(name), ABOUT), DELIVERED)
        statement = (
            f"corridor: with {name} food further out is delivered as often as where it lay in training"
        )
        yield claim(statement, effect, within(SAME), FOOD_POINTS)
    for arena in ARENAS:
        for name in TESTED:
            effect = found.difference(rows(name, arena), rows(EQUAL, arena), SCORE)
            yield claim(f"{arena}: {name} scores more than equal weights", effect, above(0.0), points)


ATTRIBUTE_WEIGHTS = Experiment(
    "attribute_weights",
    "Attribute weights",
    "5.4.1.2, 5.5",
    "Does a larger weight of the distance from the food solve area 1?",
    "In training, start, food and home lie on one line. With equal weights, a robot next to food that lies further out "
    "is therefore equally far from all vectors of SEARCH, MOVE SLOWLY and ORIENT; any weight of the food above that of "
    "the home breaks this tie in favour of ORIENT. The distance from the food counts twice, four and eight times; as "
    "a control, the distance from home four times. *Learned*: the weights with the smallest leave-one-out error on "
    "the training files, which contain only one set-up.",
    ("all",),
    run_weights,
    report_weights,
)

OLD, NEW = "the thesis's state vector", "redesigned state vector"
SCALE = 1000
"""The whole range of AtHome and FoodNearness, in integer steps, so that ties are exact."""
REACH = FINGER_TIP / MM_PER_PIXEL
"""Pixels from the robot's centre to its finger tips: the unit of length for nearness."""


def food_nearness(raw: RawData) -> float:
    """Nearness of the food: 1 in the gripper, one half at the finger tips, 0 if there is none."""
    if raw.object_presence:
        return 1.0
    return REACH / (REACH + length(raw.x - raw.food_x, raw.y - raw.food_y)) if raw.food_seen else 0.0


def redesigned(raw: RawData) -> StateVector:
    """ObjectPresence, AtHome, FoodType, ArmsHeight and FoodNearness, in the places of the five attributes of 4.3.

    With `SCALE` as the diagonal, the distances of 4.6.1 are: 1 each if ObjectPresence, AtHome or FoodType differ, the
    difference of ArmsHeight divided by 55, and the difference of FoodNearness.
    """
    at_home = length(raw.x - raw.home_x, raw.y - raw.home_y) <= raw.home_radius
    return StateVector(
        1 if raw.object_presence else 0,
        SCALE * at_home,
        raw.food_type,
        raw.arm,
        round(SCALE * food_nearness(raw)),
    )


@dataclass(frozen=True, slots=True)
class RedesignedImitator:
    """The thesis's learner with the redesigned state vector.

    Attributes:
        imitator: Trained with redesigned vectors.
        env: Where it forages.
    """

    imitator: NearestNeighbourImitator
    env: BehavioursEnv

    @classmethod
    def trained(cls, moments: Sequence[Moment], env: BehavioursEnv) -> Self:
        """The learner of some training episodes."""
        vectors = np.array([redesigned(moment.raw) for moment in moments])
        heard = np.array([int(moment.heard) for moment in moments])
        return cls(NearestNeighbourImitator(diagonal=SCALE).fit(vectors, heard), env)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A behaviour, drawn with its confidence level; the thesis's state vector is not used."""
        return self.imitator.act(redesigned(self.env.forager.raw), rng)


def run_vectors(trial: Trial) -> list[Row]:
    """The same training episodes for both state vectors, and the same recalls."""
    env = TrainingEnv(max_cycles=trial.size.rounds)
    trained = observe(env, trial, training_seeds(trial).spawn(trial.size.files))
    env.close()
    rows: list[Row] = [episode.row for episode in trained]
    for arena in ARENAS:
        alone = recall_env(arena, limit=trial.size.steps)
        for amount in trial.size.amounts:
            files = [episode.experience for episode in trained[:amount]]
            rows += recall_all(alone, imitator(files, alone.diagonal), trial, amount, files, OLD)
            moments = [moment for episode in trained[:amount] for moment in episode.moments]
            learner = RedesignedImitator.trained(moments, alone)
            rows += recall_all(alone, learner, trial, amount, files, NEW)
        alone.close()
    return rows


def report_vectors(found: Analysis) -> Report:
    """Which failures the redesign removes, and which it does not."""
    last = max(found.amounts)
    own = {
        arena: [(name, pick(found.recalls, condition=name, amount=last, arena=arena)) for name in (OLD, NEW)]
        for arena in ARENAS
    }
    tables = (
        found.recall_table(
            "Noise of the laboratory; the same training episodes and the same recalls for both.",
            (SCORE, DELIVERED, STEPS),
        ),
        found.places_table(last),
        found.states_table(
            f"By the state that the teacher would classify, after {last} episodes: share of all steps, and of wrong "
            "steps in the state.",
            list(own.items()),
            (spent, wrong),
        ),
    )
    figure, axes = panels(6, "The thesis's state vector, and a redesigned one")
    for i, arena in enumerate(ARENAS):
        rows = pick(found.recalls, arena=arena)
        curves(axes[i], found, rows, SCORE, EPISODES, arena)
        curves(axes[2 + i], found, rows, DELIVERED, EPISODES, arena)
        shown = {
            state.name.replace("_", " ").lower(): [found.mean(some, wrong(state)) for _, some in own[arena]]
            for state in occurring(pick(rows, amount=last))
        }
        levels(axes[4 + i], shown, f"wrong steps (%), {arena}", (OLD, NEW))
        axes[4 + i].set_xlim(-4, 104)
    axes[5].set_yticklabels([])
    legend(figure, axes[0], INTERVALS)
    return Report(
        list(_vector_claims(found, {arena: dict(rows) for arena, rows in own.items()})), tables, figure
    )


def _vector_claims(found: Analysis, own: Mapping[str, Mapping[str, list[RecallEpisode]]]) -> Iterator[Claim]:
    for arena in ARENAS:
        new, old = own[arena][NEW], own[arena][OLD]
        effect = found.difference(new, old, SCORE)
        yield claim(f"{arena}: the redesigned vector scores more", effect, above(0.0), points)
        effect = found.difference(new, old, DELIVERED)
        yield claim(f"{arena}: the redesigned vector delivers more", effect, above(0.0), FOOD_POINTS)
    far = {name: at(own["corridor"][name], FURTHER) for name in (NEW, OLD)}
    effect = found.difference(far[NEW], far[OLD], DELIVERED)
    name = "corridor: the redesigned vector delivers more of the food that lies further out"
    yield claim(name, effect, above(0.0), FOOD_POINTS)
    effect = found.difference(own["rectangle"][NEW], own["corridor"][NEW], SCORE)
    yield claim(
        "what is solved in the training arena is solved in the rectangle", effect, within(SAME), points
    )


STATE_VECTOR = Experiment(
    "state_vector",
    "Another state vector",
    "5.4.1.2, 5.5",
    "Does a state vector that is redesigned to avoid the failures of the thesis's own remove them?",
    "The new vector keeps ObjectPresence, FoodType and ArmsHeight. RobotHomeDistance becomes *AtHome*: whether the "
    "robot is within the radius of its home. RobotFoodDistance becomes *FoodNearness*: 1 with something in the "
    "gripper, 0 with no food in sight, otherwise r / (r + distance), where r is the reach of the robot's fingers, "
    "75 mm. The distance of 4.6.1, votes and draws stay. The vector was fixed before it was tried, and no other was "
    "tried. The effects of its two changes are not separated.",
    ("all",),
    run_vectors,
    report_vectors,
)
