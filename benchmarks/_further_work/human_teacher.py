"""Experiment 8: a person in the teacher's place, late and with wrong keys now and then (6.2)."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    AGREEMENT,
    ATTEMPTS,
    DELIVERED,
    DISTINCT,
    ROUNDS,
    SCORE,
    TRUE,
    VECTORS,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import ARENAS, imitator, learn, recall_all, training_seeds
from _further_work.pictures import curves, legend, panels
from _further_work.rows import Done, Lesson, Recalled, Unit
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.policies import Observation
from khepera_forage.policies.policy import SEPARATED, is_training, state_vector_of
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import HopelessTraining
from khepera_forage.task.states import BEHAVIOURS, Behaviour, behaviour_for, classify
from khepera_forage.thesis.claims.claim import Claim, Within, judged, points
from khepera_forage.thesis.claims.claim import Unit as Scale

DELAYS = (0, 2, 3, 5)
"""Rounds of 0.1 s that a person reacts late: 0.2 to 0.5 s at the robots' own pace. An assumption, not measured."""
WRONG = {"no wrong keys": 0.0, "2 % wrong keys": 0.02, "5 % wrong keys": 0.05}
"""Share of the rounds in which another key is pressed. An assumption, not measured."""
EPISODES = 5
"""Lessons of a learner: about what somebody has patience for."""
MARGIN = 10.0
"""Points within which a score counts as kept, as in the chains. Our decision."""
NONE = next(iter(WRONG))
_percent = Scale("%", ".1f")
_food = Scale("points of food delivered", "+.1f")


@dataclass
class ScriptedPerson:
    """Knows what the teacher knows, but sees it late, and now and then presses a wrong key.

    The program waits for the first key, which is therefore not late; nor is the silence for a separated learner,
    which the program keeps by itself.

    Attributes:
        env: The training; its teacher is this one.
        delay: Rounds that pass before a change is answered; at least 0.
        wrong: Probability of a round with a wrong key, any of the nine others alike.
    """

    env: TrainingEnv
    delay: int
    wrong: float
    _seen: deque[Behaviour] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._seen = deque(maxlen=self.delay + 1)

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
            self._seen.clear()
        self._seen.append(behaviour_for(classify(state_vector_of(observation), self.env.home_radius)))
        if is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        key = self._seen[0]
        if rng.random() < self.wrong:
            others = [behaviour for behaviour in BEHAVIOURS[: Behaviour.WAIT] if behaviour != key]
            return others[int(rng.integers(len(others)))]
        return key


def run(unit: Unit) -> Done:
    """One learner for each delay, all with the same share of wrong keys."""
    env = TrainingEnv()
    alone = {arena: recall_env(arena) for arena in ARENAS}
    lessons: list[Lesson] = []
    recalls: list[Recalled] = []
    for delay in DELAYS:
        person = ScriptedPerson(env, delay, WRONG[unit.condition])
        seeds = training_seeds(unit).spawn(min(EPISODES, unit.size.files))
        try:
            taught = list(learn(env, unit, seeds, delay, person))
        except HopelessTraining:
            continue  # Nobody can be taught like this: the delay has no rows.
        files = [experience for experience, _ in taught]
        lessons += [lesson for _, lesson in taught]
        for there in alone.values():
            recalls += recall_all(there, imitator(files, there.diagonal), unit, delay, files)
    for there in alone.values():
        there.close()
    env.close()
    return Done(tuple(lessons), tuple(recalls))


def report(done: Done, rng: np.random.Generator) -> Report:
    """What a learner loses to its teacher's faults."""
    slips = list(WRONG)[1:]
    claims = tuple(
        _claim(done, what, condition, delay, rng)
        for what, condition, delay in (
            *((f"a reaction of {delay} rounds", NONE, delay) for delay in DELAYS[1:]),
            *((f"{slip} at once", slip, 0) for slip in slips),
            *((f"a reaction of {DELAYS[2]} rounds and {slip}", slip, DELAYS[2]) for slip in slips),
        )
    )
    note = (
        f"Learners of {EPISODES} lessons in the corridor. Delay: rounds of 0.1 s that the scripted person reacts late. "
        "Delay 0 and no wrong keys is the hand-coded teacher. "
    )
    tables = (
        means_table(
            "recalls",
            "Recall",
            note + "The places are the same for every line of an arena.",
            "delay",
            done.recalls,
            (SCORE, AGREEMENT, DELIVERED, VECTORS, DISTINCT),
            rng,
        ),
        means_table(
            "lessons",
            "Training",
            note + "The last column is of the learner's own state vectors.",
            "delay",
            done.lessons,
            (ATTEMPTS, ROUNDS, TRUE),
            rng,
        ),
    )
    figure, axes = panels(4, "A scripted person as the teacher: late, and with wrong keys")
    own = pick(done.recalls, arena="corridor")
    label = "delay (rounds of 0.1 s)"
    curves(axes[0], own, SCORE, label, rng, "corridor")
    curves(axes[1], own, DELIVERED, label, rng, "corridor")
    curves(axes[2], pick(done.recalls, arena="rectangle"), DELIVERED, label, rng, "rectangle")
    curves(axes[3], done.lessons, TRUE, label, rng, "lessons")
    legend(figure, axes[0])
    return Report(claims, tables, figure, _summary(done, rng))


def _summary(done: Done, rng: np.random.Generator) -> str:
    """The two faults and both together, at their worst, by what is brought home in the corridor."""
    worst, most = DELAYS[-1], list(WRONG)[-1]
    parts = []
    for whom, condition, delay in (
        ("the hand-coded teacher", NONE, 0),
        (f"a person {worst} rounds late", NONE, worst),
        (f"one with {most}", most, 0),
        ("one with both faults", most, worst),
    ):
        food = mean(pick(done.recalls, condition, delay, "corridor"), DELIVERED, rng)
        parts.append(f"{_percent.estimate(food)} after {whom}")
    return (
        f"Food brought home by the learner in the corridor: {', '.join(parts)}. No person has been measured."
    )


def _claim(done: Done, what: str, condition: str, delay: int, rng: np.random.Generator) -> Claim:
    """The learner of a faulty teacher against that of the hand-coded one, in the corridor."""
    rows = pick(done.recalls, condition, delay, "corridor")
    others = pick(done.recalls, NONE, 0, "corridor")
    food = _food.estimate(difference(rows, others, DELIVERED, rng))
    return judged(
        f"{what}: the learner is as good",
        "6.2",
        difference(rows, others, SCORE, rng),
        Within(MARGIN),
        points,
        "",
        f"Mean score {_percent(mean(rows, SCORE, rng).value)}, and {_percent(mean(others, SCORE, rng).value)} after "
        f"the hand-coded teacher; food delivered {_percent(mean(rows, DELIVERED, rng).value)} and "
        f"{_percent(mean(others, DELIVERED, rng).value)}, {food}.",
    )


EXPERIMENT = Experiment(
    "human_teacher",
    "A human teacher",
    "1.2, 6.2",
    "Can a person be the teacher: how does a learner fare whose teacher reacts late and presses a wrong key now and "
    "then?",
    "`khepera-forage teach` puts a person in the teacher's place: it opens a window, waits for keys, and the learner "
    "records. **No person has been measured.** What is measured here is a scripted person, who knows what the "
    "hand-coded teacher knows and has two human faults: what is shouted is what was right some rounds ago, and in some "
    "rounds a wrong key is pressed, any of the nine others alike. Delays of 0.2 to 0.5 s and 2 to 5 % of wrong keys "
    "are assumptions, not taken from a source. In the window a held key makes 5 rounds a second by default, half the "
    "robots' own pace, so that the same reaction costs half as many rounds; and since nothing moves before a key is "
    "pressed, a person who taps round by round has no delay at all. A person who knows less than the teacher, or "
    "judges distances by eye, is not in this model.",
    tuple(WRONG),
    run,
    report,
)
