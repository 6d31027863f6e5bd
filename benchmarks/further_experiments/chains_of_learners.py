"""Chains: the trained learner teaches the next one, generation after generation (1.2, 6.2)."""

from dataclasses import dataclass

import numpy as np

from further_experiments.analysis import (
    AGREEMENT,
    ATTEMPTS,
    DELIVERED,
    DISTINCT,
    PERCENT,
    ROUNDS,
    TRUE,
    VECTORS,
    Analysis,
    RowT,
    amounts_of,
    claim,
)
from further_experiments.episodes import ARENAS, imitator, recall_all, train_files, training_seeds
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.pictures import INTERVALS, curves
from further_experiments.rows import Row
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Measure, pick
from khepera_forage.experience import Experience
from khepera_forage.figures import legend, panels
from khepera_forage.policies import Observation, Policy
from khepera_forage.policies.policy import SEPARATED, is_training
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.task.states import Behaviour
from khepera_forage.thesis.claims.claim import Claim, Unit, Within

EPISODES = {"1 episode": 1, "5 episodes": 5}
"""Training episodes of a generation."""
KEPT_POINTS, KEPT_SHARE = 10.0, 0.25
"""Our decision on what counts as kept: within this many points, or this share of the first generation's value."""
_POINTS, _COUNT, _MORE = Unit("points", "+.1f"), Unit("", ".0f"), Unit("different vectors", "+.0f")


@dataclass(frozen=True, slots=True)
class SilentWhenSeparated:
    """A policy in the teacher's place: it waits in silence while a learner is separated (4.5).

    Attributes:
        policy: Decides at all other times.
    """

    policy: Policy

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> int:
        """The policy's behaviour, or WAIT."""
        if is_training(observation) and observation[SEPARATED]:
            return Behaviour.WAIT
        return self.policy.act(observation, rng)


def run(trial: Trial) -> list[Row]:
    """One chain: each generation is trained by the one before it, the first by the teacher."""
    env = TrainingEnv(max_cycles=trial.size.rounds)
    recall_envs = {arena: recall_env(arena, limit=trial.size.steps) for arena in ARENAS}
    rows: list[Row] = []
    teacher: Policy | None = None
    episodes = min(EPISODES[trial.condition], trial.size.files)
    seeds = training_seeds(trial).spawn(trial.size.generations)
    try:
        for generation, seed in enumerate(seeds, 1):
            files: list[Experience] = []
            for experience, row in train_files(env, trial, seed.spawn(episodes), generation, teacher):
                files.append(experience)
                rows.append(row)
            for alone in recall_envs.values():
                rows += recall_all(alone, imitator(files, alone.diagonal), trial, generation, files)
            teacher = SilentWhenSeparated(imitator(files, recall_envs["corridor"].diagonal))
    except IncompleteTrainingError:
        pass  # The chain ends: its last generation cannot teach. Later generations have no rows.
    for alone in recall_envs.values():
        alone.close()
    env.close()
    return rows


def report(found: Analysis) -> Report:
    """How much of the first generation's performance the last one has kept."""
    claims = [made for condition in EPISODES for made in _claims(found, condition)]
    note = (
        "Generation 1 was trained by the teacher, generation 2 by generation 1, and so on. Steps as the teacher: steps "
        "in which the learner does what the original teacher would have done. Chains that ended early have no rows for "
        "later generations."
    )
    training_note = "Training episodes of a generation, with the generation before it as the teacher."
    tables = (
        found.recall_table(note, (AGREEMENT, DELIVERED, VECTORS, DISTINCT), "generation"),
        found.training_table(training_note, (ATTEMPTS, ROUNDS, TRUE), "generation"),
    )
    figure, axes = panels(4, "Chains: the trained learner becomes the teacher of the next")
    own = pick(found.recalls, arena="corridor")
    curves(axes[0], found, own, AGREEMENT, "generation", "corridor")
    curves(axes[1], found, own, DELIVERED, "generation", "corridor")
    curves(axes[2], found, own, DISTINCT, "generation", "experience", share=False)
    curves(axes[3], found, found.trainings, TRUE, "generation", "training")
    legend(figure, axes[0], INTERVALS)
    return Report(claims, tables, figure)


def _claims(found: Analysis, condition: str) -> list[Claim]:
    recalls = pick(found.recalls, condition=condition, arena="corridor")
    trainings = pick(found.trainings, condition=condition)
    variety = KEPT_SHARE * found.mean(pick(recalls, amount=1), DISTINCT).value

    def kept(
        name: str, rows: list[RowT], measure: Measure[RowT], margin: float, value: Unit, change: Unit
    ) -> Claim:
        """The last generation against the first."""
        generations = amounts_of(rows)
        of = {generation: pick(rows, amount=generation) for generation in generations}
        last = generations[-1]
        values = ", ".join(value(found.mean(of[g], measure).value).strip() for g in generations)
        chains = [len({row.replication for row in of[g]}) for g in (1, last)]
        return claim(
            f"{condition} a generation: {name}",
            "6.2",
            found.difference(of[last], of[1], measure),
            Within(margin),
            change,
            f"{measure.name[0].upper()}{measure.name[1:]} by generation: {values} ({chains[1]} of {chains[0]} chains "
            f"reached generation {last}).",
        )

    return [
        kept("agreement with the teacher is kept", recalls, AGREEMENT, KEPT_POINTS, PERCENT, _POINTS),
        kept("food delivered is kept", recalls, DELIVERED, KEPT_POINTS, PERCENT, _POINTS),
        kept("variety of the experience is kept", recalls, DISTINCT, variety, _COUNT, _MORE),
        kept("correctness of the vectors is kept", trainings, TRUE, KEPT_POINTS, PERCENT, _POINTS),
    ]


EXPERIMENT = Experiment(
    "chains_of_learners",
    "Chains of learners",
    "1.2, 6.2",
    "When the trained learner teaches the next one, generation after generation: what is kept, and what is lost?",
    "The teacher trains generation 1 in the corridor. Generation 1 trains generation 2, and so on. A learner that "
    "teaches draws its behaviours with their confidence levels, and waits for a separated learner as the teacher does. "
    "Each training episode is repeated until it is complete, so a generation passes on only its successes. Every "
    "generation recalls in both arenas.",
    tuple(EPISODES),
    run,
    report,
)
