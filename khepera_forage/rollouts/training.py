"""The training phase as functions (4.5, 5.3): attempts, until an episode is complete."""

import logging
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.envs.training_episode import MAX_ATTEMPTS
from khepera_forage.experience import Experience, ExperienceWriter
from khepera_forage.policies import Listener, Policy, Teacher
from khepera_forage.policies.policy import HEARD
from khepera_forage.rollouts.interrupts import interrupts_held
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.sim.world import LOST
from khepera_forage.task.states import Behaviour, StateVector

ROBOT_LOST = "robot lost"
"""The reason of an attempt in which a real robot, or the camera, was lost."""
_log = logging.getLogger(__name__)

Record = Callable[[StateVector, Behaviour], None]
Watch = Callable[[], object]


class Attempt(NamedTuple):
    """What came of one attempt at a training episode.

    Attributes:
        complete: Whether all robots delivered and left home (5.3).
        rounds: MultiSteps it took.
        separations: Times a learner got separated.
        resumed: Times the learner was put beside the teacher (pause and resume).
        reason: Why it is incomplete; empty for a complete one.
        lost: Which robot was lost and how, or that the camera was; otherwise empty.
    """

    complete: bool
    rounds: int
    separations: int
    resumed: int
    reason: str
    lost: str = ""


class HopelessTraining(RuntimeError):  # noqa: N818 (it is a finding, as much as an error)
    """No attempt at a training episode was complete."""


def attempt(
    env: TrainingEnv,
    seed: int,
    record: Record,
    resume: bool = False,
    watch: Watch | None = None,
    *,
    teacher: Policy | None = None,
    options: Mapping[str, Any] | None = None,
) -> Attempt:
    """One attempt: the teacher forages and shouts, the learner hears, records, and does the same.

    Args:
        env: The paired corridors; with several learners, the first one's experience is recorded.
        seed: Of the attempt.
        record: Gets the first learner's state vector with each behaviour it hears, as it hears it.
        resume: Pause and resume (5.3.1): a learner that is about to be given up is put beside the teacher.
        watch: Called after every round.
        teacher: Who shows and shouts; by default the teacher of section 4.4. It should WAIT for a learner that is
            separated.
        options: Of the environment's reset: other marks than those of figure 5.1.
    """
    listener = Listener()
    teacher = Teacher(env.home_radius) if teacher is None else teacher
    draws = np.random.default_rng((seed, 1))
    try:
        env.reset(seed=seed, options=None if options is None else dict(options))
    except LOST as error:
        return Attempt(False, 0, 0, 0, ROBOT_LOST, str(error))
    last = env.possible_agents[-1]
    resumed = 0
    while not (env.terminations[TEACHER] or env.truncations[TEACHER]):
        for agent in env.possible_agents:
            observation = env.observe(agent)
            policy: Policy = teacher if agent == TEACHER else listener
            if agent == "learner_0" and observation[HEARD] != Behaviour.WAIT:
                record(StateVector(*observation[:5].tolist()), Behaviour(int(observation[HEARD])))
            env.step(int(policy.act(observation, draws)))
            if agent == last and watch is not None:
                watch()
        if resume and not env.truncations[TEACHER]:
            for agent in env.possible_agents[1:]:
                if env.infos[agent]["separated_rounds"] == env.patience - 1:
                    # Where there is no room beside the teacher, the attempt is given up after all.
                    with suppress(ValueError):
                        env.resume_beside(agent)
                        resumed += 1
    complete = env.terminations[TEACHER]
    infos = [env.infos[agent] for agent in env.possible_agents]
    rounds = infos[0]["steps"]
    reason = "" if complete else "separated" if rounds < env.max_cycles else "out of time"
    lost = infos[0].get("robot_lost", "")
    separations = sum(info["separations"] for info in infos)
    return Attempt(complete, rounds, separations, resumed, ROBOT_LOST if lost else reason, lost)


class _CutShort(Exception):  # noqa: N818 (it ends a recording, and nothing more)
    """The recording of an attempt ends before the attempt would have."""


def train(
    env: TrainingEnv,
    seed: np.random.SeedSequence,
    noise: str = "laboratory",
    replication: int = 0,
    file: int = 1,
    path: Path | None = None,
    resume: bool = False,
    watch: Watch | None = None,
    *,
    teacher: Policy | None = None,
    options: Mapping[str, Any] | None = None,
    attempts: int = MAX_ATTEMPTS,
) -> tuple[Experience, list[TrainingRow]]:
    """Demonstrate "as if it was the first time" until an episode is complete (5.2); incomplete ones are forgotten.

    An attempt in which a real robot or the camera was lost is incomplete too, but what was recorded is kept beside
    `path`, as `g1.lost-2.csv` for the second attempt at `g1.csv`, without the closing line of a complete file
    (`Experience.load(..., recover=True)` reads it). A warning is logged that says so.

    Args:
        env: The paired corridors.
        seed: Of the training; every attempt gets a seed of its own from it.
        noise: Name of the noise condition, for the rows.
        replication: For the rows.
        file: Number of the experience file, for the rows.
        path: Where to write the experience as it happens; what is forgotten is removed from it again.
        resume: Pause and resume (5.3.1).
        watch: Called after every round.
        teacher: Who shows and shouts; by default the teacher of section 4.4.
        options: Of the environment's reset, in every attempt.
        attempts: After so many incomplete ones it is given up.

    Returns:
        The experience of the complete episode, and one row an attempt.

    Raises:
        HopelessTraining: None of the attempts was complete.
        FileExistsError: There is a file at `path`.
    """
    rows = []
    for number, attempt_seed in enumerate(seed.generate_state(attempts).tolist(), 1):
        vectors: list[StateVector] = []
        behaviours: list[Behaviour] = []
        arena = env.arenas[0].name
        begun = False
        try:
            with suppress(_CutShort), ExitStack() as stack:
                writer = None
                if path is not None:
                    with interrupts_held():
                        writer = stack.enter_context(ExperienceWriter(path, arena, attempt_seed))
                        begun = True

                def record(
                    vector: StateVector,
                    behaviour: Behaviour,
                    made: tuple[list[StateVector], list[Behaviour]] = (vectors, behaviours),
                    writer: ExperienceWriter | None = writer,
                ) -> None:
                    made[0].append(vector)
                    made[1].append(behaviour)
                    if writer is not None:
                        writer.append(vector, behaviour)

                result = attempt(env, attempt_seed, record, resume, watch, teacher=teacher, options=options)
                if result.lost:
                    raise _CutShort
        except BaseException:
            # An operator may give up before anything happens: no file then stands in the way of the next training.
            if begun and path is not None and not vectors:
                path.unlink()
            raise
        rows.append(
            TrainingRow(
                replication=replication,
                file=file,
                attempt=number,
                seed=attempt_seed,
                noise=noise,
                complete=result.complete,
                rounds=result.rounds,
                vectors=len(vectors),
                separations=result.separations,
                reason=result.reason,
            )
        )
        if result.complete:
            return Experience(vectors, behaviours, arena=arena, seed=attempt_seed), rows
        if result.lost:
            _keep(path, number, len(vectors), result.lost)
        elif path is not None:
            path.unlink()
    raise HopelessTraining(f"none of {attempts} attempts at a training episode was complete")


def _keep(path: Path | None, number: int, vectors: int, lost: str) -> None:
    """Put what a cut-short attempt has recorded aside, and say where."""
    where = "not kept: no file was asked for"
    if path is not None:
        names = (path.with_name(f"{path.stem}.lost-{n}{path.suffix}") for n in count(number))
        kept = next(name for name in names if not name.exists())
        path.rename(kept)
        where = f"kept in {kept}"
    _log.warning("attempt %d ended: %s; its %d experience vectors are %s", number, lost, vectors, where)


def arrays(experiences: list[Experience]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """State vectors and behaviours of several files together, such as g135."""
    parts = [experience.arrays() for experience in experiences]
    return np.concatenate([x for x, _ in parts]), np.concatenate([y for _, y in parts])
