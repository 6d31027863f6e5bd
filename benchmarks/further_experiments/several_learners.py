"""Several learners: one teacher trains up to four learners at once (4.5)."""

from further_experiments.analysis import ATTEMPTS, ROUNDS, SEPARATIONS, TRUE, WAITED, Analysis, claim
from further_experiments.episodes import train_files, training_seeds
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.pictures import INTERVALS, curves
from further_experiments.rows import Row, TrainingEpisode
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import Measure, pick
from khepera_forage.figures import legend, panels
from khepera_forage.thesis.claims.claim import Above, Claim, Unit

LEARNERS = (1, 2, 3, 4)
COST = Measure[TrainingEpisode](
    "rounds of all attempts, by learners", lambda row: row.all_rounds / row.amount
)
_ROUNDS, _ATTEMPTS = Unit("rounds", ".1f"), Unit("attempts", ".2f")


def run(trial: Trial) -> list[Row]:
    """Training episodes with some number of learners."""
    learners = int(trial.condition)
    trial = trial._replace(condition="one teacher")
    env = TrainingEnv(num_learners=learners, max_cycles=trial.size.rounds)
    seeds = training_seeds(trial).spawn(trial.size.files)
    rows: list[Row] = [row for _, row in train_files(env, trial, seeds, amount=learners)]
    env.close()
    return rows


def report(found: Analysis) -> Report:
    """What an episode with several learners costs."""
    note = (
        "Noise of the laboratory. Rounds, waiting and separations are those of the complete attempt. The cost of an "
        "experience file is the rounds of all attempts at an episode, divided by the number of learners, each of which "
        "records a file."
    )
    measures = (ATTEMPTS, ROUNDS, WAITED, SEPARATIONS, COST, TRUE)
    figure, axes = panels(4, "Several learners with one teacher")
    cost = COST._replace(name="rounds of all attempts divided by the learners")
    for panel, measure in zip(axes, (WAITED, ROUNDS, ATTEMPTS, cost), strict=True):
        curves(panel, found, found.trainings, measure, "learners", share=False)
    legend(figure, axes[0], INTERVALS)
    claims = (
        _claim(found, "Waiting for the slowest learner costs rounds", WAITED, _ROUNDS),
        _claim(found, "A complete episode takes more rounds", ROUNDS, _ROUNDS),
        _claim(found, "More attempts are needed", ATTEMPTS, _ATTEMPTS),
        _claim(found, "A learner's file costs the teacher more rounds", COST, _ROUNDS),
    )
    return Report(claims, [found.training_table(note, measures, "learners")], figure)


def _claim(found: Analysis, name: str, measure: Measure[TrainingEpisode], unit: Unit) -> Claim:
    few, most = LEARNERS[0], LEARNERS[-1]
    rows = {n: pick(found.trainings, amount=n) for n in LEARNERS}
    by_number = ", ".join(f"{unit(found.mean(rows[n], measure).value)} with {n}" for n in LEARNERS)
    return claim(
        f"{name} ({most} learners against {few})",
        "4.5",
        found.difference(rows[most], rows[few], measure),
        Above(0.0),
        unit,
        f"{measure.name[0].upper()}{measure.name[1:]}: {by_number}.",
    )


EXPERIMENT = Experiment(
    "several_learners",
    "Several learners at once",
    "4.5, 6.2",
    "What does it cost to wait for the slowest of several learners?",
    "One teacher and 1, 2, 3 or 4 learners, each in a copy of the corridor. The teacher waits in silence while any "
    "learner is separated. An episode is complete when all robots have delivered and left home. An attempt fails when "
    "any learner stays separated for ten seconds.",
    tuple(map(str, LEARNERS)),
    run,
    report,
)
