"""The info of a compiled world on its own, read from records by number: several times as fast as by name."""

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from khepera_forage.envs.compiled.records import SHOWN, episode_dtype, tracker_dtype
from khepera_forage.envs.recall import episode_info
from khepera_forage.sim.compiled.records import robot_dtype
from khepera_forage.task.scoring import penalty, score

STEPS, REWARD, TERMINATED, TRUNCATED, _CORRECT = map(
    episode_dtype.names.index,  # type: ignore[union-attr]
    ("steps", "reward", "terminated", "truncated", "correct"),
)
"""Where these fields are in their record; likewise below."""
_DELIVERED, _POISON_HOME, _DELIVERABLE = map(
    tracker_dtype.names.index,  # type: ignore[union-attr]
    ("delivered", "poison_home", "deliverable"),
)
_STATE = SHOWN.index("state")
_FIRST_OF_POSE = robot_dtype(1).fields["marker_x"][1] // 8  # type: ignore[index]
POSE = slice(_FIRST_OF_POSE, _FIRST_OF_POSE + 3)
"""Where x, y and orientation of the marker are among the numbers of a robot."""


def info_of(
    task: Sequence[float], episode: Sequence[Any], tracker: Sequence[Any], pose: NDArray[Any]
) -> dict[str, Any]:
    """The info of one round, as `envs.recall.episode_info`.

    Args:
        task: The numbers of the fields `SHOWN`.
        episode: Those of `episode_dtype`.
        tracker: Those of `tracker_dtype`.
        pose: x, y and orientation of the marker; not kept.
    """
    correct, steps, delivered = episode[_CORRECT], episode[STEPS], tracker[_DELIVERED]
    lost = penalty(delivered, tracker[_DELIVERABLE])
    return episode_info(
        int(task[_STATE]),
        pose.copy(),
        score(correct, steps, lost),
        lost,
        correct,
        steps,
        delivered,
        tracker[_POISON_HOME],
    )
