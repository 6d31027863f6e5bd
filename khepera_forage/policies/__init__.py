"""Policies: the teacher, the imitator, other learners, and adapters.

`Policy.act` is the contract of every `act`: what it takes, returns and raises.

What needs scikit-learn is imported when it is first used, because scikit-learn takes about a second to import.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from khepera_forage.policies.classifiers import ClassifierPolicy, ContiguousLabels
from khepera_forage.policies.distance import distance
from khepera_forage.policies.models import AgentPolicy, ModelPolicy, as_policy
from khepera_forage.policies.policy import Listener, Neighbours, Observation, Policy, UniformPolicy, state_vector_of
from khepera_forage.policies.teacher import Teacher

if TYPE_CHECKING:
    from khepera_forage.policies.growing_memory import GrowingMemory
    from khepera_forage.policies.imitator import KNearestImitator, NearestNeighbourImitator, WeightedImitator
    from khepera_forage.policies.learner_registry import register_learner

__all__ = [
    "AgentPolicy",
    "ClassifierPolicy",
    "ContiguousLabels",
    "GrowingMemory",
    "KNearestImitator",
    "Listener",
    "ModelPolicy",
    "NearestNeighbourImitator",
    "Neighbours",
    "Observation",
    "Policy",
    "Teacher",
    "UniformPolicy",
    "WeightedImitator",
    "as_policy",
    "distance",
    "register_learner",
    "state_vector_of",
]

LATER = {
    "GrowingMemory": "growing_memory",
    "KNearestImitator": "imitator",
    "NearestNeighbourImitator": "imitator",
    "WeightedImitator": "imitator",
    "register_learner": "learner_registry",
}
"""The module of each name that needs scikit-learn."""


def __getattr__(name: str) -> Any:
    if name not in LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{LATER[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *LATER})
