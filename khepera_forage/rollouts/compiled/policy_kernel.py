"""The policy kernel: the decision in every world of a block, by the teacher, by imitators, or uniformly at random."""

from typing import Any

import numpy as np

from khepera_forage.compilation.decorators import kernel
from khepera_forage.counter_rng import random_bits
from khepera_forage.envs.compiled.arena_maps import arena_maps, map_in
from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.policies.nearest_neighbour.memories import BEHAVIOURS, Memories, plane_key
from khepera_forage.rollouts.compiled.nearest_neighbour import clear, draw_label, nearest_votes
from khepera_forage.sim.compiled.numbers import DRAW_POLICY, DRAWS, upper
from khepera_forage.task.episode import count_decision
from khepera_forage.task.states import Behaviour, State

TEACHER, UNIFORM, WITHOUT_ORIENTING = -1, -2, -3
"""Policies that need no memory: the teacher; every behaviour equally likely; and the teacher with SEARCH FOR FOOD in
the place of ORIENT WITH FOOD. From 0 on: imitators."""

_BEYOND = 1 << 16  # pixels
_NEXT_TO_FOOD, _SEARCH_FOR_FOOD = State.NEXT_TO_FOOD.value, Behaviour.SEARCH_FOR_FOOD.value
_DRAWS, _POLICY = np.uint64(DRAWS), np.uint64(DRAW_POLICY)


@kernel
def decide(worlds: Worlds, task: TaskParameters, memories: Memories, decisions: Any) -> None:
    """Decide on a behaviour in every world of a block, and count the decision.

    Args:
        worlds: The records of one block.
        task: Of the task. No distance seems longer than the arena's diagonal to an imitator, as in `BehavioursEnv`.
        memories: Of all imitators.
        decisions: `decision_dtype`, one a lane; changed in place.
    """
    robot, known, values = worlds.bodies.robots, worlds.tasks, task.decisions[0]
    maps = arena_maps(worlds.bodies.near, task)
    for i in range(robot.x.shape[0]):
        # States and behaviours correspond one to one (4.4.1).
        known.behaviour[i] = known.state[i]
        decision = decisions[i]
        if robot.first_frame[i] != 0.0:  # nothing is perceived yet
            continue
        if decision.policy != TEACHER:
            chance = upper(random_bits(robot.key[i], robot.round[i] * _DRAWS + _POLICY))
            if decision.policy == UNIFORM:
                known.behaviour[i] = int(chance * BEHAVIOURS)
            elif decision.policy == WITHOUT_ORIENTING:
                known.behaviour[i] = _SEARCH_FOR_FOOD if known.state[i] == _NEXT_TO_FOOD else known.state[i]
            else:
                diagonal = map_in(maps, known, i).diagonal
                known.behaviour[i] = _imitate(
                    known, i, diagonal, memories, decision, chance, values.distance_arithmetic
                )
        count_decision(
            decision, int(known.state[i]), int(known.behaviour[i]), known.robot_food_distance[i], values
        )


@kernel
def _imitate(
    known: Any, i: int, diagonal: int, memories: Memories, decision: Any, chance: float, arithmetic: float
) -> int:
    """The behaviour of an imitator in one lane. A state vector that stays is not searched for again."""
    vector = (
        int(known.object_presence[i]),
        min(int(known.robot_home_distance[i]), diagonal),
        int(known.vector_food_type[i]),
        int(known.arms_height[i]),
        min(int(known.robot_food_distance[i]), diagonal),
    )
    presence, home, food_type, arm, food = vector
    query = (plane_key(presence, food_type, arm) * _BEYOND + home) * _BEYOND + food
    votes = decision.votes
    if decision.query != query:
        clear(votes)
        _, decision.total = nearest_votes(memories, decision.policy, vector, diagonal, votes, arithmetic)
        decision.query = query
    behaviour = draw_label(votes, decision.total, chance)
    decision.ties += 1 if decision.total > 1 else 0
    decision.conflicts += 1 if votes[behaviour] < decision.total else 0
    return int(behaviour)
