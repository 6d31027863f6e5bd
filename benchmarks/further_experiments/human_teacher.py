"""A human teacher, simulated: it reacts late and presses a wrong key now and then (6.2)."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from further_experiments.analysis import (
    AGREEMENT,
    ATTEMPTS,
    DELIVERED,
    DISTINCT,
    FOOD_POINTS,
    PERCENT,
    ROUNDS,
    SCORE,
    TRUE,
    VECTORS,
    Analysis,
    claim,
)
from further_experiments.episodes import ARENAS, imitator, recall_all, train_files, training_seeds
from further_experiments.experiment import Experiment, Report, Size, Trial
from further_experiments.pictures import INTERVALS, curves
from further_experiments.rows import Row
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.estimates import pick
from khepera_forage.figures import SMALL, legend, panels
from khepera_forage.policies import Observation
from khepera_forage.policies.policy import SEPARATED, is_training, state_vector_of
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DecisionValues
from khepera_forage.task.states import BEHAVIOURS, Behaviour, behaviour_for, classify
from khepera_forage.thesis.claims.claim import Claim, Within, points

DELAYS = (0, 2, 3, 5)
"""Rounds by which a person reacts late. An assumption, not measured."""
_SECONDS = [f"{rounds * DEFAULT_DECISIONS.round_duration:.2g}" for rounds in (DELAYS[1], DELAYS[-1])]
ROUNDS_OF = f"rounds of {DEFAULT_DECISIONS.round_duration:g} s"
WRONG = {"no wrong keys": 0.0, "2 % wrong keys": 0.02, "5 % wrong keys": 0.05}
"""Share of the rounds in which a wrong key is pressed. An assumption, not measured."""
EPISODES = 5
"""Training episodes of a learner: about as many as a person is likely to have patience for."""
MARGIN = 10.0
"""Points within which a score counts as kept, as in the chains of learners. Our decision."""
NO_WRONG_KEYS = next(iter(WRONG))


@dataclass
class SimulatedPerson:
    """The teacher's decisions, late and with wrong keys.

    The program waits for the first key, so the first key is not late. The silence for a separated learner is not late
    either, because the program keeps it without the person.

    Attributes:
        env: The training environment that this policy teaches in.
        delay: Rounds that pass before a change is answered; at least 0.
        wrong: Probability of a round with a wrong key, any of the nine others with equal odds.
    """

    env: TrainingEnv
    delay: int
    wrong: float
    _right_keys: deque[Behaviour] = field(init=False, repr=False)
    _decisions: DecisionValues = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._right_keys = deque(maxlen=self.delay + 1)
        self._decisions = self.env.decisions.values()

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """What the teacher would have done `delay` rounds ago, or a wrong key.

        Args:
            observation: Of the training environment.
            rng: Draws the wrong keys.

        Raises:
            TypeError: `rng` is not a NumPy generator.
        """
        if not isinstance(rng, np.random.Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator, to draw wrong keys from")
        if self.env.infos[TEACHER]["steps"] == 0:
            self._right_keys.clear()
        state = classify(state_vector_of(observation), self.env.home_radius, self._decisions)
        self._right_keys.append(behaviour_for(state))
        if is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        key = self._right_keys[0]
        if rng.random() < self.wrong:
            others = [behaviour for behaviour in BEHAVIOURS[: Behaviour.WAIT] if behaviour != key]
            return others[int(rng.integers(len(others)))]
        return key


def run(trial: Trial) -> list[Row]:
    """One learner for each delay, all with the same share of wrong keys."""
    trial = trial._replace(size=trial.size._replace(attempts=trial.size.patience))
    env = TrainingEnv(max_cycles=trial.size.rounds)
    recall_envs = [recall_env(arena, limit=trial.size.steps) for arena in ARENAS]
    rows: list[Row] = []
    for delay in DELAYS:
        person = SimulatedPerson(env, delay, WRONG[trial.condition])
        seeds = training_seeds(trial).spawn(min(EPISODES, trial.size.files))
        try:
            trained = list(train_files(env, trial, seeds, delay, person))
        except IncompleteTrainingError:
            continue  # No learner can be trained like this: the delay has no rows.
        files = [experience for experience, _ in trained]
        rows += [row for _, row in trained]
        for alone in recall_envs:
            rows += recall_all(alone, imitator(files, alone.diagonal), trial, delay, files)
    for alone in recall_envs:
        alone.close()
    env.close()
    return rows


def report(found: Analysis) -> Report:
    """What a learner loses through its teacher's faults."""
    wrong = list(WRONG)[1:]
    claims = [
        *(_claim(found, f"a delay of {delay} rounds", NO_WRONG_KEYS, delay) for delay in DELAYS[1:]),
        *(_claim(found, f"{keys} without delay", keys, 0) for keys in wrong),
        *(_claim(found, f"a delay of {DELAYS[2]} rounds and {keys}", keys, DELAYS[2]) for keys in wrong),
    ]
    note = (
        f"Learners of {EPISODES} training episodes in the corridor. Delay: {ROUNDS_OF} by which the simulated "
        "person reacts late. Delay 0 without wrong keys is the hand-coded teacher. "
    )
    tables = (
        found.recall_table(
            note + "The places are the same for every line of an arena.",
            (SCORE, AGREEMENT, DELIVERED, VECTORS, DISTINCT),
            "delay",
        ),
        found.training_table(
            note + "The last column refers to the learner's own state vectors.",
            (ATTEMPTS, ROUNDS, TRUE),
            "delay",
        ),
    )
    figure, axes = panels(4, "A simulated person as the teacher: late, and with wrong keys")
    corridor, rectangle = (pick(found.recalls, arena=arena) for arena in ARENAS)
    label = f"delay ({ROUNDS_OF})"
    curves(axes[0], found, corridor, SCORE, label, "corridor", amounts=DELAYS)
    curves(axes[1], found, corridor, DELIVERED, label, "corridor", amounts=DELAYS)
    curves(axes[2], found, rectangle, DELIVERED, label, "rectangle", amounts=DELAYS)
    curves(axes[3], found, found.trainings, TRUE, label, "training", amounts=DELAYS)
    for panel in axes:
        for place, delay in enumerate(DELAYS):
            if not pick(found.trainings, amount=delay):
                panel.text(place, 50, "no complete\ntraining", ha="center", va="center", fontsize=SMALL)
    legend(figure, axes[0], INTERVALS)
    return Report(claims, tables, figure, _summary(found))


def _summary(found: Analysis) -> str:
    """Food in the corridor with either fault, and with both, at their largest."""
    delay, wrong = DELAYS[-1], list(WRONG)[-1]
    parts = []
    for teacher, condition, rounds in (
        ("the hand-coded teacher", NO_WRONG_KEYS, 0),
        (f"a person with a delay of {delay} rounds", NO_WRONG_KEYS, delay),
        (f"a person with {wrong}", wrong, 0),
        ("a person with both faults", wrong, delay),
    ):
        rows = pick(found.recalls, condition=condition, amount=rounds, arena="corridor")
        delivered = (
            PERCENT.estimate(found.mean(rows, DELIVERED)) if rows else "nothing, as no training is complete,"
        )
        parts.append(f"{delivered} after {teacher}")
    return f"Food that the learner delivers in the corridor: {', '.join(parts)}. No person has been measured."


def _claim(found: Analysis, faults: str, condition: str, delay: int) -> Claim:
    """The learner of a faulty teacher against that of the hand-coded one, in the corridor."""
    rows = pick(found.recalls, condition=condition, amount=delay, arena="corridor")
    others = pick(found.recalls, condition=NO_WRONG_KEYS, amount=0, arena="corridor")
    food = FOOD_POINTS.estimate(found.difference(rows, others, DELIVERED))
    measured = (
        f"Mean score {found.percent(rows, SCORE)}, and {found.percent(others, SCORE)} after the hand-coded teacher; "
        f"food delivered {found.percent(rows)} and {found.percent(others)}, {food}."
        if rows
        else "There is no such learner: in each replication, "
        f"all attempts at some training episode failed ({Size().patience} without --quick)."
    )
    return claim(
        f"{faults}: the learner is as good",
        "6.2",
        found.difference(rows, others, SCORE),
        Within(MARGIN),
        points,
        measured,
    )


EXPERIMENT = Experiment(
    "human_teacher",
    "A human teacher",
    "1.2, 6.2",
    "Can a person be the teacher? How good is a learner whose teacher reacts late and sometimes presses a wrong key?",
    "`khepera-forage teach` puts a person in the teacher's place: it opens a window and waits for keys, and the "
    "learner records. **No person has been measured.** This experiment simulates a person with the decisions of the "
    "hand-coded teacher and two human faults: the key is the right one of some rounds ago, and in some rounds a wrong "
    f"key is pressed, any of the nine others with equal odds. Delays of {_SECONDS[0]} to {_SECONDS[1]} s and 2 to 5 % "
    "of wrong keys are assumptions without a source. In the window, a held key runs 5 rounds a second by default, "
    "slower than the robots' pace, so that the same reaction time costs fewer rounds. Nothing moves before a key is "
    "pressed, so a person who taps round by round has no delay at all. The simulation does not include a person who "
    "has less information than the teacher, or who judges distances by eye.",
    tuple(WRONG),
    run,
    report,
)
