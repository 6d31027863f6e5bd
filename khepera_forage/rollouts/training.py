"""The training phase (4.5, 5.3): attempts at a training episode, until one is complete."""

import logging
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo.utils.env import AECEnv

from khepera_forage.envs.arguments import whole_number
from khepera_forage.envs.training import TEACHER, TrainingEnv
from khepera_forage.experience import Experience, ExperienceWriter
from khepera_forage.policies import Listener, Policy, Teacher
from khepera_forage.policies.models import completed
from khepera_forage.policies.policy import HEARD
from khepera_forage.rollouts.recall import Callback, noise_of_world, stopping
from khepera_forage.rollouts.rows import TrainingRow
from khepera_forage.sim.world import LOST
from khepera_forage.task.decisions import decisions_text
from khepera_forage.task.states import Behaviour, StateVector


@contextmanager
def delayed_interrupts() -> Iterator[None]:
    """Raise an interrupt (Ctrl-C) that arrives within the block at the end of the block.

    Python may otherwise raise the interrupt after any call, for example between opening a file and storing the open
    file in a variable, so that nothing can close the file.
    """
    usual_handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual_handler):
        yield  # Python raises interrupts only in the main thread, and only with a callable handler.
        return
    received: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: received.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual_handler)
        if received:
            signal.raise_signal(signal.SIGINT)


_log = logging.getLogger(__name__)


class _Recorder:
    """The experience of one attempt, in memory and, with a writer, in a file that grows with every vector."""

    def __init__(self) -> None:
        self.vectors: list[StateVector] = []
        self.behaviours: list[Behaviour] = []
        self.writer: ExperienceWriter | None = None

    def __call__(self, vector: StateVector, behaviour: Behaviour) -> None:
        self.vectors.append(vector)
        self.behaviours.append(behaviour)
        if self.writer is not None:
            self.writer.append(vector, behaviour)


def _keep(path: Path, number: int) -> Path:
    """Rename the file of an attempt in which a robot was lost: `g1.lost-2.csv` for the second attempt at `g1.csv`."""
    names = (path.with_name(f"{path.stem}.lost-{n}{path.suffix}") for n in count(number))
    return path.rename(next(name for name in names if not name.exists()))


ROBOT_LOST = "robot lost"
"""The reason of an attempt in which a real robot or the camera was lost."""

Record = Callable[[StateVector, Behaviour], None]
"""Receives the learner's state vector and the behaviour that it heard with it."""


class Attempt(NamedTuple):
    """The result of one attempt at a training episode.

    Attributes:
        complete: Whether all robots delivered their food and left home (5.3).
        rounds: Number of MultiSteps.
        separations: How often a learner became separated.
        resumed: How often a learner was placed beside the teacher (pause and resume).
        reason: Why the attempt is incomplete; empty for a complete one.
        lost: Which robot was lost and how, or that the camera was lost; otherwise empty.
    """

    complete: bool
    rounds: int
    separations: int
    resumed: int
    reason: str
    lost: str = ""


class IncompleteTrainingError(RuntimeError):
    """No attempt at a training episode was complete."""


def attempt(
    env: TrainingEnv,
    seed: int,
    record: Record,
    resume: bool = False,
    callback: Callback | None = None,
    *,
    teacher: Policy | None = None,
    options: Mapping[str, Any] | None = None,
) -> Attempt:
    """Make one attempt: the teacher forages and announces its behaviours; the learner records and executes them.

    Args:
        env: The paired corridors; with several learners, the experience of the first one is recorded.
        seed: Of the attempt.
        record: Receives the first learner's state vector and behaviour whenever it hears one.
        resume: Pause and resume (5.3.1): place a learner beside the teacher before it has been separated for too long.
        callback: Called after every round.
        teacher: Policy of the teacher; by default that of section 4.4. It should WAIT while a learner is separated.
        options: For the environment's reset: other marks than those of figure 5.1.
    """
    listener = Listener()
    rng = np.random.default_rng((seed, 1))
    try:
        env.reset(seed=seed, options=None if options is None else dict(options))
    except LOST as error:
        return Attempt(False, 0, 0, 0, ROBOT_LOST, str(error))
    # After the reset, which chooses the arena.
    teacher = completed(Teacher() if teacher is None else teacher, env)
    resumed = 0
    with stopping(env):
        while not (env.terminations[TEACHER] or env.truncations[TEACHER]):
            for agent in env.possible_agents:
                observation = env.observe(agent)
                policy: Policy = teacher if agent == TEACHER else listener
                if agent == "learner_0" and observation[HEARD] != Behaviour.WAIT:
                    record(StateVector(*observation[:5].tolist()), Behaviour(int(observation[HEARD])))
                env.step(int(policy.act(observation, rng)))
            if callback is not None:
                callback()
            if resume and not env.truncations[TEACHER]:
                resumed += _resume_separated(env)
    return _result(env, resumed)


def _resume_separated(env: TrainingEnv) -> int:
    """Place the learners beside the teacher that would end the attempt in the next round; returns their number."""
    resumed = 0
    for agent in env.possible_agents[1:]:
        if env.infos[agent]["separated_rounds"] == env.patience - 1:
            # Without room beside the teacher the learner stays, and the attempt ends.
            with suppress(ValueError):
                env.resume_beside(agent)
                resumed += 1
    return resumed


def _result(env: TrainingEnv, resumed: int) -> Attempt:
    """The result of an attempt that has ended."""
    infos = [env.infos[agent] for agent in env.possible_agents]
    complete = env.terminations[TEACHER]
    rounds = infos[0]["steps"]
    lost = infos[0].get("robot_lost", "")
    if lost:
        reason = ROBOT_LOST
    elif complete:
        reason = ""
    else:
        reason = "separated" if rounds < env.max_cycles else "out of time"
    separations = sum(info["separations"] for info in infos)
    return Attempt(complete, rounds, separations, resumed, reason, lost)


def train(
    env: AECEnv[str, Any, Any],
    seed: int | np.random.SeedSequence,
    noise: str | None = None,
    replication: int = 0,
    file: int = 1,
    path: Path | None = None,
    resume: bool = False,
    callback: Callback | None = None,
    *,
    teacher: Policy | None = None,
    options: Mapping[str, Any] | None = None,
    attempts: int | None = None,
    on_attempt: Callable[[TrainingRow], object] | None = None,
) -> tuple[Experience, list[TrainingRow]]:
    """Repeat a training episode "as if it was the first time" until it is complete; discard incomplete ones (5.2).

    An attempt in which a real robot or the camera was lost is incomplete, but its experience is kept beside `path`: the
    file of the second attempt at `g1.csv` is `g1.lost-2.csv`. That file has no closing line, so that only
    `Experience.load(..., recover=True)` reads it. A warning is logged.

    Args:
        env: The paired corridors, as `TrainingEnv` or in PettingZoo's wrappers, which are left out.
        seed: Of the training, a whole number or a seed sequence; every attempt has its own seed, derived from it.
        noise: Name of the noise condition, for the rows; by default that of the environment (`noise_of_world`).
        replication: For the rows.
        file: Number of the experience file, for the rows.
        path: File to which the experience is written while it is recorded; discarded attempts leave no file.
        resume: Pause and resume (5.3.1).
        callback: Called after every round.
        teacher: Policy of the teacher; by default that of section 4.4.
        options: For the environment's reset in every attempt.
        attempts: Largest number of attempts; by default that of the environment's decisions.
        on_attempt: Called with the row of every attempt, as soon as that has ended.

    Returns:
        The experience of the complete episode, and one row for each attempt.

    Raises:
        IncompleteTrainingError: None of the attempts was complete.
        FileExistsError: There is a file at `path`.
        ValueError: The seed or the number of attempts is out of range.
    """
    own = getattr(env, "unwrapped", env)
    if not isinstance(own, TrainingEnv) or not isinstance(own.action_space(TEACHER), spaces.Discrete):
        raise TypeError(f"env is {env}; allowed: a TrainingEnv of behaviours, such as paired_corridors_v1.env()")
    env, rows = own, []
    attempts = env.decisions.most_attempts if attempts is None else whole_number("attempts", attempts, 1)
    if not isinstance(seed, np.random.SeedSequence):
        seed = np.random.SeedSequence(whole_number("seed", seed, 0))
    for number, attempt_seed in enumerate(seed.generate_state(attempts).tolist(), 1):
        recorder, arena = _Recorder(), env.arena_of(attempt_seed).name
        try:
            if path is not None:
                with delayed_interrupts():
                    recorder.writer = ExperienceWriter(path, arena, attempt_seed, decisions=env.decisions)
            result = attempt(env, attempt_seed, recorder, resume, callback, teacher=teacher, options=options)
            rows.append(
                TrainingRow(
                    replication=replication,
                    file=file,
                    attempt=number,
                    seed=attempt_seed,
                    noise=noise_of_world(env.world) if noise is None else noise,
                    complete=result.complete,
                    rounds=result.rounds,
                    vectors=len(recorder.vectors),
                    separations=result.separations,
                    reason=result.reason,
                    decisions=decisions_text(env.decisions),
                )
            )
            # Before the closing line: a complete file without its row would never get one.
            if on_attempt is not None:
                on_attempt(rows[-1])
            # Without the closing line unless complete: discarding the file may fail, or the process be killed before.
            if recorder.writer is not None:
                recorder.writer.close(complete=result.complete)
        except BaseException:
            if recorder.writer is not None:
                recorder.writer.close(complete=False)
                if not recorder.vectors:  # an empty file would prevent the next training at this path
                    recorder.writer.path.unlink()
            raise
        if result.complete:
            experience = Experience(recorder.vectors, recorder.behaviours, arena, attempt_seed, decisions=env.decisions)
            return experience, rows
        if result.lost:
            where = f"kept in {_keep(path, number)}" if path else "not kept: training has no experience file"
            vectors = len(recorder.vectors)
            _log.warning("attempt %d ended: %s; its %d experience vectors are %s", number, result.lost, vectors, where)
        elif path is not None:
            path.unlink()
    raise IncompleteTrainingError(f"none of {attempts} attempts at a training episode was complete")


def arrays(experiences: list[Experience]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """State vectors and behaviours of several experience files together, such as g135.

    Raises:
        ExperienceError: The files are of different decisions.
    """
    for experience in experiences[1:]:
        experience.require_decisions(experiences[0].decisions)
    parts = [experience.arrays() for experience in experiences]
    return np.concatenate([x for x, _ in parts]), np.concatenate([y for _, y in parts])
