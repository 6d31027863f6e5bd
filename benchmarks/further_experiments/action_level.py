"""Action level: the behaviours are imitated, too, for a complete imitation learning system (4.8, 6.2)."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from further_experiments.arenas_and_food import ALL, ONE, setups
from further_experiments.episodes import ARENAS, Observed, imitator, observe, recall_all, training_seeds
from further_experiments.experiment import (
    ATTEMPTS,
    DELIVERED,
    EPISODES,
    FOOD_POINTS,
    INTERVALS,
    PERCENT,
    ROUNDS,
    SCORE,
    SEPARATIONS,
    STEPS,
    TRUE,
    Analysis,
    Experiment,
    RecallEpisode,
    Report,
    Row,
    Trial,
    claim,
    curves,
    spent,
)
from further_experiments.learned_behaviours import LearnedBehaviours
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import pick
from khepera_forage.figures import legend, panels
from khepera_forage.policies import Teacher
from khepera_forage.robots.khepera import Motors
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.perception import RawData
from khepera_forage.thesis.claims.claim import Claim, above, within

PROGRAM, BEHAVIOURS, BOTH = "learned program", "learned behaviours", "both learned"
TEACHER = "the teacher"
SAME = 10.0
"""Points of food delivered within which two robots count as equal. Our decision."""
MOST = 50.0
"""Percent of the food above which a system counts as foraging. Our decision."""


class CopiedMotorsEnv(TrainingEnv):
    """The paired corridors, where learners drive the teacher's motor commands, bent by following (4.5.2).

    A learner's action is the behaviour that it heard and is only recorded; it executes no behaviour of its own.
    """

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Start an attempt; see `TrainingEnv.reset`."""
        super().reset(seed, options)
        teacher, *learners = self.foragers
        for learner in learners:
            learner.motors_for = teacher.motors_for  # type: ignore[method-assign]


def hand_coded(behaviour: int, raw: RawData) -> Motors:
    """The motor commands of the hand-coded behaviours."""
    return command(behaviour, raw, Decisions().values())


class LearnedBehavioursEnv(BehavioursEnv):
    """Recall with learned behaviours in place of the hand-coded ones.

    The score is that of equation 5.1: a step is correct if the teacher would have chosen the same behaviour.

    Args:
        command: From a behaviour and raw data to motors; may be replaced between episodes.
        **kwargs: Of `BehavioursEnv`.
    """

    def __init__(self, command: Callable[[int, RawData], Motors] = hand_coded, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.command = command

    def reset(self, **kwargs: Any) -> Any:
        """Start an episode, in which the robot has the learned behaviours."""
        begun = super().reset(**kwargs)
        setattr(self.forager, "motors_for", self._command)  # noqa: B010 (a method of this robot alone)
        return begun

    def _command(self, behaviour: int) -> Motors:
        return self.command(behaviour, self.forager.raw)


def condition_of(setup: str, learned: str) -> str:
    """The name of a system: the set-up of its training, and which part of it is learned."""
    return f"{setup}: {learned}"


def run(trial: Trial) -> list[Row]:
    """Training with copied motors; recalls with a program and behaviours of which either, or both, are learned."""
    seeds, places = training_seeds(trial).spawn(2)
    env = CopiedMotorsEnv(max_cycles=trial.size.rounds)
    marks = setups(trial.condition, np.random.default_rng(places))
    trained = observe(env, trial, seeds.spawn(trial.size.files), marks)
    env.close()
    files = [episode.experience for episode in trained]
    behaviours = {amount: _learned(trained[:amount], trial.replication) for amount in trial.size.amounts}
    rows: list[Row] = [episode.row for episode in trained]
    for arena in ARENAS:
        given = recall_env(arena, limit=trial.size.steps)
        own = LearnedBehavioursEnv(arena=arena, foods=given.foods, limit=given.limit)
        teacher = Teacher.of(given)
        rows += recall_all(given, teacher, trial, 0, condition=condition_of(trial.condition, TEACHER))
        for amount, learned_behaviours in behaviours.items():
            own.command = learned_behaviours.command
            program = imitator(files[:amount], given.diagonal)
            for what, alone, policy in (
                (PROGRAM, given, program),
                (BEHAVIOURS, own, teacher),
                (BOTH, own, program),
            ):
                condition = condition_of(trial.condition, what)
                rows += recall_all(alone, policy, trial, amount, files[:amount], condition)
        given.close()
        own.close()
    return rows


def _learned(episodes: list[Observed], seed: int) -> LearnedBehaviours:
    """Behaviours learned from what the learner perceived, heard and drove."""
    raws, heard, motors = zip(*(moment for episode in episodes for moment in episode.moments), strict=True)
    return LearnedBehaviours(random_state=seed).fit(raws, heard, motors)


def report(found: Analysis) -> Report:
    """Which part of the system can be learned, and from which set-ups."""
    last = max(found.amounts)

    def rows(setup: str, what: str, arena: str) -> list[RecallEpisode]:
        amount = 0 if what == TEACHER else last
        return pick(found.recalls, condition=condition_of(setup, what), amount=amount, arena=arena)

    tables = (
        found.recall_table(
            "Noise of the laboratory; random places, the same for every line of an arena. 0 episodes: the teacher's "
            "program and the hand-coded behaviours. The score tells how good the program is, the food how good the "
            "behaviours are.",
            (DELIVERED, SCORE, STEPS),
        ),
        found.training_table(
            "The learner drives the motor commands that it receives, bent by following.",
            (ATTEMPTS, ROUNDS, SEPARATIONS, TRUE),
        ),
        found.states_table(
            f"With the teacher's program, which is never wrong, after {last} episodes: share of all steps.",
            [
                (
                    arena,
                    [
                        (TEACHER, rows(ONE, TEACHER, arena)),
                        *((condition_of(s, BEHAVIOURS), rows(s, BEHAVIOURS, arena)) for s in (ONE, ALL)),
                    ],
                )
                for arena in ARENAS
            ],
            (spent,),
        ),
    )
    figure, axes = panels(
        4, "Action level: food delivered with a learned program, learned behaviours, and both"
    )
    for i, setup in enumerate((ONE, ALL)):
        for j, arena in enumerate(ARENAS):
            own = [
                replace(row, condition=what)
                for what in (PROGRAM, BEHAVIOURS, BOTH)
                for row in pick(found.recalls, condition=condition_of(setup, what), arena=arena)
            ]
            curves(axes[2 * i + j], found, own, DELIVERED, EPISODES, f"{arena}, training with {setup}")
    legend(figure, axes[0], INTERVALS)
    return Report(list(_claims(found, rows)), tables, figure)


def _claims(found: Analysis, rows: Callable[[str, str, str], list[RecallEpisode]]) -> Iterator[Claim]:
    for arena in ARENAS:
        for setup in (ONE, ALL):
            effect = found.difference(rows(setup, BEHAVIOURS, arena), rows(setup, TEACHER, arena), DELIVERED)
            name = f"{arena}, {setup}: learned behaviours are as good as hand-coded ones"
            yield claim(name, effect, within(SAME), FOOD_POINTS)
            effect = found.mean(rows(setup, BOTH, arena), DELIVERED)
            name = f"{arena}, {setup}: the complete imitation learning system delivers most of the food"
            yield claim(name, effect, above(MOST), PERCENT)
        effect = found.difference(rows(ALL, BOTH, arena), rows(ONE, BOTH, arena), DELIVERED)
        name = f"{arena}: variety of the episodes helps the complete system"
        yield claim(name, effect, above(0.0), FOOD_POINTS)


ACTION_LEVEL = Experiment(
    "action_level",
    "Action level",
    "4.8, 6.2",
    "Can the behaviours be learned by imitation as well, and can a learner forage with both learned: the complete "
    "imitation learning system?",
    "The thesis's learner has every behaviour that it hears; this learner has none. In training the teacher transmits "
    "its motor commands beside the behaviour, and the learner drives them, bent by following (4.5.2). It records its "
    "own raw data, the behaviour, and its own motors. From these it learns its program as the thesis's learner does, "
    "and for each behaviour a regression from raw data to motors: ten extremely randomised trees. A behaviour that was "
    "never heard means to stand still. Training has the set-up of figure 5.1, or random places in each episode.",
    (ONE, ALL),
    run,
    report,
)
