"""Learning to forage by imitation: paired Khepera robots as PettingZoo and Gymnasium environments.

Importing the package registers `khepera_forage/Corridor-v1`, `Rectangle-v1`, `CorridorWheels-v1` and
`RectangleWheels-v1` with Gymnasium, and the same names with `-v0` for the decisions of version 0.1. The names of daily
use are here, too; each is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from khepera_forage.envs.registration import register_all

if TYPE_CHECKING:
    from khepera_forage.experience import Experience
    from khepera_forage.noise import Noise
    from khepera_forage.policies import NearestNeighbourImitator, Teacher, as_policy
    from khepera_forage.rollouts.dagger import dagger
    from khepera_forage.rollouts.recall import recall, recall_env
    from khepera_forage.rollouts.training import train
    from khepera_forage.sim.arena import Arena
    from khepera_forage.sim.arena_file import read_arena
    from khepera_forage.task.decisions import Decisions

__all__ = [
    "Arena",
    "Decisions",
    "Experience",
    "NearestNeighbourImitator",
    "Noise",
    "Teacher",
    "__version__",
    "as_policy",
    "dagger",
    "read_arena",
    "recall",
    "recall_env",
    "train",
]

__version__ = "0.3.0.dev0"

_PLACES = {
    "Arena": "sim.arena",
    "Decisions": "task.decisions",
    "Experience": "experience",
    "NearestNeighbourImitator": "policies",
    "Noise": "noise",
    "Teacher": "policies",
    "as_policy": "policies",
    "dagger": "rollouts.dagger",
    "read_arena": "sim.arena_file",
    "recall": "rollouts.recall",
    "recall_env": "rollouts.recall",
    "train": "rollouts.training",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


register_all()
