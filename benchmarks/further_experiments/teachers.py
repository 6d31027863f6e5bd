"""Three experiments on who teaches whom: chains of learners, a person, and several learners at once."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

import further_experiments.common as fw
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.estimates import Measure, pick
from khepera_forage.noise import Noise
from khepera_forage.policies import Observation, Policy
from khepera_forage.policies.policy import SEPARATED, is_training, state_vector_of
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.task.states import BEHAVIOURS, Behaviour, behaviour_for, classify
from khepera_forage.thesis.claims import Claim, Unit, points, within

LENGTHS = {"1 episode": 1, "5 episodes": 5}
"""Training episodes of a generation."""
KEPT_POINTS, KEPT_SHARE = 10.0, 0.25
"""Our decision on what counts as kept: within this many points, or this share of the first generation's value."""


@dataclass(frozen=True, slots=True)
class SilentWhenSeparated:
    """A policy in the teacher's place: it waits in silence while a learner is separated (4.5)."""

    policy: Policy

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The policy's behaviour, or WAIT."""
        if is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        return self.policy.act(observation, rng)


def run_chain(trial: fw.Trial) -> list[fw.Row]:
    """One chain: each generation is trained by the one before it, the first by the teacher.

    A chain ends where the last generation cannot teach.
    """
    env = trial.env()
    rows: list[fw.Row] = []
    teacher: Policy | None = None
    episodes = min(LENGTHS[trial.condition], trial.size.files)
    for generation, seed in enumerate(trial.seeds(trial.size.generations), 1):
        files, trainings = fw.train_files(
            trial, env, seed.spawn(episodes), amount=generation, teacher=teacher, may_fail=True
        )
        rows += trainings
        if len(files) < episodes:
            break
        rows += fw.recall_learners(trial, {generation: files})
        teacher = SilentWhenSeparated(fw.imitator(files, trial.alone("corridor").diagonal))
    return rows


def chain_claims(found: fw.Analysis) -> Iterator[Claim]:
    """How much of the first generation's performance the last one has kept, in the corridor."""
    kept, vectors = within(KEPT_POINTS), Unit("different vectors", "+.0f")
    for condition in LENGTHS:
        recalls = pick(found.recalls, condition=condition, arena="corridor")
        trainings = pick(found.trainings, condition=condition)
        first, last = (pick(recalls, amount=n) for n in (1, max(fw.amounts_of(recalls))))
        variety = within(KEPT_SHARE * found.mean(first, fw.DISTINCT).value)
        name = f"{condition} a generation:"
        yield found.compared(f"{name} agreement with the teacher is kept", last, first, fw.AGREEMENT, kept)
        yield found.compared(f"{name} food delivered is kept", last, first, fw.DELIVERED, kept, points)
        yield found.compared(f"{name} variety of the experience is kept", last, first, fw.DISTINCT, variety, vectors)
        early, late = (pick(trainings, amount=n) for n in (1, max(fw.amounts_of(trainings))))
        yield found.compared(f"{name} correctness of the vectors is kept", late, early, fw.TRUE, kept)


CHAINS_OF_LEARNERS = fw.Experiment(
    "chains_of_learners",
    "Chains of learners",
    "1.2, 6.2",
    "When the trained learner teaches the next one, generation after generation: what is kept, and what is lost?",
    "The teacher trains generation 1 in the corridor, generation 1 trains generation 2, and so on. A learner that "
    "teaches draws its behaviours with their confidence levels, and waits for a separated learner as the teacher does. "
    "Training episodes are repeated until they are complete, so a generation passes on only its successes.",
    conditions=tuple(LENGTHS),
    run=run_chain,
    claims=chain_claims,
    picture=(fw.AGREEMENT, fw.DELIVERED, fw.DISTINCT),
    recalls=(
        "Generation 1 was trained by the teacher, generation 2 by generation 1, and so on. Steps as the teacher: steps "
        "in which the learner does what the original teacher would have done. Chains that ended early have no rows for "
        "later generations.",
        (fw.AGREEMENT, fw.DELIVERED, fw.VECTORS, fw.DISTINCT),
    ),
    trainings=("With the generation before as the teacher.", (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE)),
    amount="generation",
)

DELAYS = (0, 2, 3, 5)
"""Rounds by which a person reacts late. An assumption, not measured."""
ROUNDS_OF = f"rounds of {DEFAULT_DECISIONS.round_duration:g} s"
WRONG = {"no wrong keys": 0.0, "2 % wrong keys": 0.02, "5 % wrong keys": 0.05}
"""Share of the rounds in which a wrong key is pressed. An assumption, not measured."""
NO_WRONG_KEYS, *WRONG_KEYS = WRONG
LESSONS = 5
"""Training episodes of a learner: about as many as a person is likely to have patience for."""
MARGIN = 10.0
"""Points within which a score counts as kept, as in the chains of learners. Our decision."""


class SimulatedPerson:
    """The teacher's decisions, late and with wrong keys.

    The program waits for the first key, so the first key is not late. The silence for a separated learner is not late
    either, because the program keeps it without the person.

    Args:
        env: The training environment that this policy teaches in.
        delay: Rounds that pass before a change is answered; at least 0.
        wrong: Probability of a round with a wrong key, any of the nine others with equal odds.
    """

    def __init__(self, env: TrainingEnv, delay: int, wrong: float) -> None:
        self._env, self._wrong = env, wrong
        self._right_keys = deque[Behaviour](maxlen=delay + 1)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """What the teacher would have done `delay` rounds ago, or a wrong key, which `rng` draws."""
        assert rng is not None
        env = self._env
        if env.infos[TEACHER]["steps"] == 0:
            self._right_keys.clear()
        state = classify(state_vector_of(observation), env.home_radius, env.decisions.values())
        self._right_keys.append(behaviour_for(state))
        if is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        key = self._right_keys[0]
        if rng.random() < self._wrong:
            others = [behaviour for behaviour in BEHAVIOURS[: Behaviour.WAIT] if behaviour != key]
            return others[int(rng.integers(len(others)))]
        return key


def run_person(trial: fw.Trial) -> list[fw.Row]:
    """One learner for each delay, all with the same share of wrong keys.

    A delay with which a training episode was never complete has no rows.
    """
    trial = trial._replace(size=trial.size._replace(attempts=trial.size.patience))
    env = trial.env()
    rows: list[fw.Row] = []
    for delay in DELAYS:
        person = SimulatedPerson(env, delay, WRONG[trial.condition])
        seeds = trial.seeds(min(LESSONS, trial.size.files))
        files, trainings = fw.train_files(trial, env, seeds, amount=delay, teacher=person, may_fail=True)
        if len(files) == len(seeds):
            rows += [*trainings, *fw.recall_learners(trial, {delay: files})]
    return rows


def person_claims(found: fw.Analysis) -> Iterator[Claim]:
    """The learner of a faulty teacher against that of the hand-coded one, in the corridor."""
    corridor = pick(found.recalls, arena="corridor")
    usual = pick(corridor, condition=NO_WRONG_KEYS, amount=0)
    for faults, condition, delay in (
        *((f"a delay of {delay} rounds", NO_WRONG_KEYS, delay) for delay in DELAYS[1:]),
        *((f"{keys} without delay", keys, 0) for keys in WRONG_KEYS),
        *((f"a delay of {DELAYS[2]} rounds and {keys}", keys, DELAYS[2]) for keys in WRONG_KEYS),
    ):
        own = pick(corridor, condition=condition, amount=delay)
        yield found.compared(f"{faults}: the learner is as good", own, usual, fw.SCORE, within(MARGIN))


HUMAN_TEACHER = fw.Experiment(
    "human_teacher",
    "A human teacher",
    "1.2, 6.2",
    "Can a person be the teacher? How good is a learner whose teacher reacts late and sometimes presses a wrong key?",
    "**No person has been measured.** A simulated person has the decisions of the hand-coded teacher and two faults: "
    "the key is the right one of some rounds ago, and in some rounds any of the nine other keys is pressed. Delays and "
    "shares of wrong keys are assumptions without a source. A person who has less information than the teacher, or "
    "who judges distances by eye, is not simulated.",
    conditions=tuple(WRONG),
    run=run_person,
    claims=person_claims,
    picture=(fw.SCORE, fw.DELIVERED),
    recalls=(
        f"Learners of {LESSONS} training episodes in the corridor. Delay: {ROUNDS_OF} by which the simulated person "
        "reacts late. Delay 0 without wrong keys is the hand-coded teacher. Teachers with whom some episode is never "
        "complete have no rows.",
        (fw.SCORE, fw.AGREEMENT, fw.DELIVERED, fw.VECTORS, fw.DISTINCT),
    ),
    trainings=("The last column refers to the learner's own state vectors.", (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE)),
    amount="delay (rounds)",
)

LEARNERS = (1, 2, 3, 4)
_USUAL = Noise.laboratory()
NOISES = {
    "noise of the laboratory": _USUAL,
    "long losses": replace(
        _USUAL,
        loss_rate_one_hole=10 * _USUAL.loss_rate_one_hole,
        loss_rate_two_holes=10 * _USUAL.loss_rate_two_holes,
        loss_rounds=10 * _USUAL.loss_rounds,
    ),
}
"""Robots separate under the second one only (5.3.1): it loses markers ten times as often, and ten times as long."""
MOST_ATTEMPTS = 1000
"""At an episode: with four learners and long losses one attempt in fourteen is complete."""
COST = Measure[fw.EpisodeRow]("rounds of all attempts, by learners", lambda row: row.all_rounds / row.amount)


def run_together(trial: fw.Trial) -> list[fw.Row]:
    """Training episodes with some number of learners."""
    number, noise = trial.condition.split(maxsplit=1)
    learners = int(number)
    trial = trial._replace(condition=noise, size=trial.size._replace(attempts=MOST_ATTEMPTS))
    env = trial.env(num_learners=learners, noise=NOISES[noise])
    return [*fw.train_files(trial, env, amount=learners)[1]]


def together_claims(found: fw.Analysis) -> Iterator[Claim]:
    """What an episode with most learners costs more than one with a single learner."""
    rounds, attempts = Unit("rounds", ".1f"), Unit("attempts", ".2f")
    for noise in NOISES:
        few, most = (pick(found.trainings, condition=noise, amount=n) for n in (LEARNERS[0], LEARNERS[-1]))
        for name, measure, unit in (
            ("waiting for the slowest learner costs rounds", fw.WAITED, rounds),
            ("a complete episode takes more rounds", fw.ROUNDS, rounds),
            ("more attempts are needed", fw.ATTEMPTS, attempts),
            ("a learner's file costs the teacher more rounds", COST, rounds),
        ):
            name = f"{noise}: {name} ({LEARNERS[-1]} learners against {LEARNERS[0]})"
            yield found.compared(name, most, few, measure, unit=unit)


SEVERAL_LEARNERS = fw.Experiment(
    "several_learners",
    "Several learners at once",
    "4.5, 6.2",
    "What does it cost to wait for the slowest of several learners?",
    "One teacher and 1, 2, 3 or 4 learners, each in a copy of the corridor. The teacher waits in silence while any "
    "learner is separated. An episode is complete when all robots have delivered and left home.",
    conditions=tuple(f"{number} {noise}" for noise in NOISES for number in LEARNERS),
    run=run_together,
    claims=together_claims,
    picture=(fw.WAITED, fw.ROUNDS, fw.ATTEMPTS, COST),
    trainings=(
        "Rounds, waiting and separations are those of the complete attempt. The cost of an experience file is the "
        "rounds of all attempts at an episode, divided by the number of learners. Long losses: markers are lost ten "
        "times as often as in the laboratory, and ten times as long.",
        (fw.ATTEMPTS, fw.ROUNDS, fw.WAITED, fw.SEPARATIONS, COST, fw.TRUE),
    ),
    amount="learners",
)
