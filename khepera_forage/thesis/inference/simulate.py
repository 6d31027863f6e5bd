"""Sets of decisions from the prior: which are admissible, and what the thesis's tables would be under them.

A set is admissible if the teacher can do under it what the thesis says of it. Only the teacher and training are looked
at, no learner. Under each admissible set the thesis's whole design is replicated.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib import resources
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs
from numpy.random import Generator
from numpy.typing import NDArray

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.files import replacing
from khepera_forage.option_values import progress
from khepera_forage.rollouts.compiled.recalls import TEACHER, WITHOUT_ORIENTING, Episodes, run_recalls
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.study import Arguments, Job, RowStore, in_processes
from khepera_forage.thesis.compiled_replications import experience_of, recalls_of
from khepera_forage.thesis.design import FOODS, LIMITS, THESIS, files_needed
from khepera_forage.thesis.inference.posterior import Parameter, parameters_of
from khepera_forage.thesis.inference.prior import PRIOR, LabModel, laboratory_from_text, laboratory_text
from khepera_forage.thesis.inference.summary import ALL, CellRecalls, fitted_columns, of_recalls, with_slopes

FEWEST = 32
"""Forages, or attempts at a training episode; twice as many, again and again, while the answer is near a threshold."""
MOST_FORAGES, MOST_TRIES = 4096, 1024
"""Forages of the teacher in each arena; without orienting, and attempts at a training episode."""
SURE = 2.0
"""Standard errors from a threshold that are far enough."""
DELIVERED = 0.98
"""Share of the food that the teacher brings home, at least."""
WITHOUT = 0.01
"""Share of the forages in which food is brought home without orienting, at most."""
FASTEST = {"corridor": 65, "rectangle": 205}
"""Steps of the fastest recalls in tables A.1 to A.7, without lines that contradict themselves: a learner is not faster
than the teacher can be."""
LUCK, CLOSE = 1.1, 1.2
"""How much slower than that the fastest of the forages may be, since these need not include the fastest possible; and
up to where more forages may still be fast enough."""
COMPLETE = 0.5
""""Quite frequent" (5.3.1): share of attempts at a training episode that are complete, at least."""
ATTEMPTS = 40
"""At an episode, after which training is hopeless: with half of them complete, fewer than one in 10^12 gets there."""
CHUNK, QUICK_CHUNK = 100, 4
"""Sets drawn in one unit of work."""
CHUNKS_A_PROCESS = 4
"""Units that a process does before it is seen whether the sets are enough."""
FILE, KEPT = "sets.jsonl.gz", "sets.npz"
"""Rows of a run; what is kept of its admissible sets, also in the package."""


def reason_against(laboratory: LabModel, seed: int) -> str:
    """Why a laboratory is not admissible; empty if it is.

    What costs least is looked at first, until there is a reason. Near a threshold more recalls are simulated.
    """
    rng = np.random.default_rng(seed)
    for arena in FOODS:
        delivered, fastest = _teacher(laboratory, arena, rng)
        if delivered < DELIVERED:
            return f"the teacher fails in the {arena}"
        if fastest > LUCK * FASTEST[arena]:
            return f"too slow in the {arena}"
    for arena in FOODS:
        without = np.zeros(0)
        while _undecided(without, WITHOUT, MOST_TRIES):
            forages = _forages(laboratory, arena, WITHOUT_ORIENTING, len(without) or FEWEST, rng)
            without = np.append(without, forages.delivered > 0)
        if without.mean() > WITHOUT:
            return f"no ORIENT is needed in the {arena}"
    complete = np.zeros(0)
    while _undecided(complete, COMPLETE, MOST_TRIES):
        complete = np.append(complete, _attempts(laboratory, len(complete) or FEWEST, rng))
    return "" if complete.mean() >= COMPLETE else "training is seldom complete"


def _teacher(laboratory: LabModel, arena: str, rng: Generator) -> tuple[float, float]:
    """Share of the food that the teacher brings home, and steps of its fastest forage."""
    delivered, fastest = np.zeros(0), math.inf
    slow = LUCK * FASTEST[arena]
    while _undecided(delivered, DELIVERED, MOST_FORAGES) or (
        slow < fastest <= CLOSE * slow and len(delivered) < MOST_FORAGES
    ):
        forages = _forages(laboratory, arena, TEACHER, len(delivered) or FEWEST, rng)
        delivered = np.append(delivered, forages.delivered / FOODS[arena])
        fastest = min(fastest, float(forages.steps.min()))
    return float(delivered.mean()), fastest


def _undecided(values: NDArray[np.float64], threshold: float, most: int) -> bool:
    """Whether more values are needed to tell on which side of a threshold their mean, a share, lies."""
    count = len(values)
    if not FEWEST <= count < most:
        return count < FEWEST
    share = (values.sum() + 2) / (count + 4)  # an error that is not 0 if all values are alike
    return bool(abs(values.mean() - threshold) <= SURE * math.sqrt(share * (1 - share) / count))


def _forages(laboratory: LabModel, arena: str, policy: int, count: int, rng: Generator) -> Episodes:
    """Forages from random starts, each with a seed of its own."""
    return run_recalls(
        checked_arena(arena, laboratory.decisions),
        None,
        np.full(count, policy),
        int(rng.integers(2**62)),
        foods=FOODS[arena],
        limit=LIMITS[arena],
        noise=laboratory.noise,
        decisions=laboratory.decisions,
    )


def _attempts(laboratory: LabModel, episodes: int, rng: Generator) -> NDArray[np.bool_]:
    """Whether each attempt at some training episodes was complete."""
    decisions, noise = laboratory
    seed = int(rng.integers(2**62))
    try:
        trained = train_learners(episodes, seed=seed, noise=noise, decisions=decisions, attempts=ATTEMPTS)
    except (IncompleteTrainingError, ValueError):  # a mark where robot or food does not fit
        return np.zeros(MOST_TRIES, np.bool_)
    return np.asarray(trained.attempts.complete)


@dataclass(frozen=True, slots=True)
class SetRow:
    """One set of decisions and noise from the prior.

    Attributes:
        reason: Why it is not admissible; empty if it is.
        statistics: Of the experiments under it, one after the other; empty if it is not admissible.
    """

    number: int
    laboratory: str
    reason: str
    statistics: tuple[float, ...]


def simulate(seed: int, number: int, experiments: int) -> SetRow:
    """Draw the set of a number from the prior, check it, and replicate the thesis under it if it is admissible."""
    rng = np.random.default_rng((seed, number))
    laboratory = PRIOR.draw(rng)
    first = int(rng.integers(2**62))
    reason = reason_against(laboratory, first)
    statistics = np.zeros(0) if reason else replicate(laboratory, first + 1, experiments)
    short = statistics.astype(np.float32).astype(str).ravel().tolist()  # the precision of 32-bit floats
    return SetRow(number, laboratory_text(laboratory), reason, tuple(map(float, short)))


def replicate(laboratory: LabModel, seed: int, experiments: int) -> NDArray[np.float64]:
    """The statistics of some experiments of the thesis's size, shape (experiments, statistics)."""
    decisions, noise = laboratory
    training, recalling = np.random.SeedSequence(seed).spawn(2)
    trained = train_learners(
        experiments,
        seed=int(training.generate_state(1)[0]),
        noise=noise,
        episodes=files_needed(THESIS),
        decisions=decisions,
    )
    cells = []
    for cell, seeds in zip(THESIS, recalling.spawn(len(THESIS)), strict=True):
        numbers = seeds.generate_state(experiments * cell.size).astype(np.int64)
        played = recalls_of(cell, experience_of(cell, trained, experiments), numbers, noise, decisions)
        shape = (experiments, len(cell.subsets), cell.recalls)
        own = (getattr(played, name).astype(np.float64).reshape(shape) for name in CellRecalls._fields)
        cells.append(of_recalls(cell, CellRecalls(*own)))
    return with_slopes(cells)


class Sets(NamedTuple):
    """Admissible sets among the draws, and the experiments under them.

    Attributes:
        statistics: The fitted ones, shape (sets, experiments, statistics); they may be missing.
    """

    parameters: list[Parameter]
    statistics: NDArray[np.float32]
    draws: int

    def save(self, path: Path) -> None:
        """Write a small file, as the package keeps one for `load`."""
        with replacing(path) as partial, partial.open("wb") as file:
            np.savez_compressed(
                file,
                prior=PRIOR.text,
                values=np.stack([one.values for one in self.parameters], axis=1).astype(np.float32),
                statistics=self.statistics,
                draws=self.draws,
            )

    @staticmethod
    def load() -> "Sets":
        """The sets of the package."""
        with resources.files(__package__).joinpath(KEPT).open("rb") as kept, np.load(kept, allow_pickle=False) as file:
            known = zip(parameters_of(PRIOR, []), file["values"].astype(np.float64).T, strict=True)
            parameters = [replace(one, values=column) for one, column in known]
            return Sets(parameters, file["statistics"], int(file["draws"]))


class Drawn(NamedTuple):
    """Sets in the order in which they were drawn, up to the last admissible one that was wanted.

    Attributes:
        reasons: Why each set is not admissible; empty if it is.
        laboratories: The admissible sets.
        statistics: Of these, shape (sets, experiments, statistics).
    """

    reasons: list[str]
    laboratories: list[LabModel]
    statistics: NDArray[np.float32]

    @property
    def sets(self) -> Sets:
        """What the inference learns from."""
        fitted = self.statistics[:, :, fitted_columns()]
        return Sets(parameters_of(PRIOR, self.laboratories), fitted, len(self.reasons))


def draw(given: Arguments, wanted: int, experiments: int) -> Drawn:
    """Draw sets until as many as wanted are admissible; a run that was killed continues.

    Raises:
        SystemExit: The folder holds sets of another run.
    """
    settings = {**given.settings, "experiments": str(experiments), "prior": PRIOR.text}
    settings["statistics"] = " ".join(ALL)
    try:
        store = RowStore(given.out, {SetRow: "sets"}, settings, given.fresh, FILE)
    except ValueError as error:
        given.refuse(str(error))
    rows: list[SetRow] = []
    admissible: list[SetRow] = []
    with progress(total=wanted, desc="admissible sets") as bar:
        for row in _endless(given, store, experiments):
            rows.append(row)
            if not row.reason:
                admissible.append(row)
                bar.update()
                if len(admissible) == wanted:
                    break
    return Drawn(
        [row.reason for row in rows],
        [laboratory_from_text(row.laboratory) for row in admissible],
        np.array([row.statistics for row in admissible], np.float32).reshape(wanted, experiments, len(ALL)),
    )


def _endless(given: Arguments, store: RowStore, experiments: int) -> Iterator[SetRow]:
    """All sets in their order; those that are not in the store are drawn some chunks at a time."""
    size = QUICK_CHUNK if given.quick else CHUNK
    for number in count():
        if str(number) not in store.finished:
            missing = [
                Job(str(k), _chunk, (given.seed, range(k * size, (k + 1) * size), experiments))
                for k in range(number, number + effective_n_jobs(given.jobs) * CHUNKS_A_PROCESS)
                if str(k) not in store.finished
            ]
            for key, made in in_processes(given.jobs)(missing):
                store.add(key, made)
        yield from store.finished[str(number)]


def _chunk(seed: int, numbers: range, experiments: int) -> list[SetRow]:
    return [simulate(seed, number, experiments) for number in numbers]
