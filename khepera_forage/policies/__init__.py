"""Who decides: the teacher, the imitator, and adapters for other learners."""

from khepera_forage.policies.adapters import ClassifierPolicy, ModelPolicy
from khepera_forage.policies.imitator import NearestNeighbourImitator
from khepera_forage.policies.listener import Listener
from khepera_forage.policies.neighbours import Neighbours
from khepera_forage.policies.policy import Observation, Policy, state_vector_of
from khepera_forage.policies.teacher import Teacher
from khepera_forage.policies.uniform import UniformPolicy
from khepera_forage.policies.votes import distance

__all__ = [
    "ClassifierPolicy",
    "Listener",
    "ModelPolicy",
    "NearestNeighbourImitator",
    "Neighbours",
    "Observation",
    "Policy",
    "Teacher",
    "UniformPolicy",
    "distance",
    "state_vector_of",
]
