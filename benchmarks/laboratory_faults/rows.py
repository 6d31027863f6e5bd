"""The rows of the campaign: faults, and the trainings in which they happened."""

from dataclasses import dataclass

RECOVERED, ATTEMPT_LOST, STOPPED = "recovered", "attempt lost", "stopped"
"""Outcomes: the attempt went on; it ended, and another began; the command ended with an error, and was continued."""


@dataclass(frozen=True, slots=True)
class FaultRow:
    """One fault.

    Attributes:
        part: Of the laboratory: robot, camera or disk.
        kind: Name of the kind of fault; `unexpected` for a loss without a fault.
        series: Number of the series of trainings.
        training: Number of the training in the series, from 0.
        seed: Of the attempt.
        round: Of the attempt, in which the fault began.
        outcome: `RECOVERED`, `ATTEMPT_LOST` or `STOPPED`.
        seconds: From the beginning of the fault until it had passed, or until the training noticed a loss.
        unattended: Longest time in seconds that a wheel within reach of its line turned since the last round.
        moving: Robots within reach that moved after the attempt had ended.
        out_of_reach: Robots that moved, and that no program can reach.
        notices: Messages: warnings, and the error with which the command ended.
        named: Notices that name the device or file, and the cause.
        requests: Requests to the operator to repair something.
        intact: Whether all that was on disk before the fault was still there at the end of the training.
        before: Experience vectors that the learner perceived in the attempt before the fault.
        perceived: Those from the fault until it was over.
        stored: Those among them that are on disk.
        missing: Those that are not, unless the attempt was discarded later (5.2).
        altered: Vectors in the file of the attempt that the learner did not perceive like this.
        wrong: Stored vectors that differ from what is true, on the camera's newest scene.
        outdated: Stored vectors perceived while the camera's scene was not that of the round.
        continued: Whether a round of training followed.
        text: The first notice.
    """

    part: str
    kind: str
    series: int
    training: int
    seed: int
    round: int
    outcome: str
    seconds: float
    unattended: float
    moving: int
    out_of_reach: int
    notices: int
    named: int
    requests: int
    intact: bool
    before: int
    perceived: int
    stored: int
    missing: int
    altered: int
    wrong: int
    outdated: int
    continued: bool
    text: str


@dataclass(frozen=True, slots=True)
class TrainingResult:
    """One whole training.

    Attributes:
        series: Number of the series of trainings.
        training: Number of the training in the series, from 0.
        faults: Faults in it.
        rounds: Of all attempts.
        attempts: Begun ones.
        planned: Complete episodes planned.
        complete: Complete experience files, each with the row of its complete attempt in `attempts.csv`.
        foreign: Complete files that hold other vectors than a complete attempt's.
        stuck: How often `train --continue` refused to go on before a file was deleted by hand.
        seconds: Of the whole training.
    """

    series: int
    training: int
    faults: int
    rounds: int
    attempts: int
    planned: int
    complete: int
    foreign: int
    stuck: int
    seconds: float
