"""Policies: the teacher, the imitator, other learners, and adapters."""

from khepera_forage.policies.adapters import AgentPolicy, ClassifierPolicy, as_policy
from khepera_forage.policies.attribute_weights import WeightedImitator
from khepera_forage.policies.growing_memory import GrowingMemory
from khepera_forage.policies.imitator import NearestNeighbourImitator
from khepera_forage.policies.k_nearest import KNearestImitator
from khepera_forage.policies.listener import Listener
from khepera_forage.policies.model_policy import ModelPolicy
from khepera_forage.policies.nearest_neighbour.distance import distance
from khepera_forage.policies.nearest_neighbour.neighbours import Neighbours
from khepera_forage.policies.policy import Observation, Policy, state_vector_of
from khepera_forage.policies.teacher import Teacher
from khepera_forage.policies.uniform import UniformPolicy

__all__ = [
    "AgentPolicy",
    "ClassifierPolicy",
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
    "state_vector_of",
]
