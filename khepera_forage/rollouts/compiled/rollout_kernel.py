"""The rollout kernel: whole recalls, without Python in between.

A lane starts the next recall of all as soon as it has ended one, so that no thread waits for another.
"""

from typing import Any, NamedTuple

from khepera_forage.compilation.decorators import entrance, inline, kernel, sequence
from khepera_forage.compilation.work_queue import take
from khepera_forage.envs.compiled.commands import drive_behaviours
from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.envs.compiled.rounds import begin_world, carry_out, compare_decisions
from khepera_forage.envs.compiled.worlds import Worlds, worlds_of
from khepera_forage.policies.nearest_neighbour.memories import Memories
from khepera_forage.rollouts.compiled.policy_kernel import TEACHER, decide
from khepera_forage.sim.compiled.near_walls import enter
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.task.food_tracking import is_collected
from khepera_forage.task.scoring import penalty, score


class Plan(NamedTuple):
    """The recalls to run.

    Attributes:
        keys: Of the world of each recall.
        policies: Of each recall: `TEACHER`, `UNIFORM`, or the number of a memory.
        arenas: Of each recall, if worlds are in different arenas; otherwise an empty tuple.
        taken: A single number: how many all threads have started.
        start: `start_dtype`, shape (1,): not a number, since starts are random.
        places: `place_dtype`, shape (foods,): not a number, since places are random.
    """

    keys: Any
    policies: Any
    arenas: Any
    taken: Any
    start: Any
    places: Any


class Outcomes(NamedTuple):
    """What became of the recalls.

    Attributes:
        recalls: `outcome_dtype`, one record a recall.
        foods: Where each food object lay, mm; shape (recalls, foods, 2).
        collected: Whether each food object was brought home and is not poisonous; shape (recalls, foods).
        free: A single flag: whether every recall had room.
    """

    recalls: Any
    foods: Any
    collected: Any
    free: Any


@sequence
def _run(
    worlds: Worlds,
    parameters: Parameters,
    task: TaskParameters,
    memories: Memories,
    plan: Plan,
    decisions: Any,
    outcomes: Outcomes,
    advance: int,
) -> None:
    """Run recalls in one block, until no thread finds another."""
    lanes = worlds.bodies.robots.x.shape[0]
    running = 0
    for i in range(lanes):
        running += _start_next(worlds, i, parameters, task, plan, decisions[i], outcomes)
    while running > 0:
        decide(worlds, task, memories, decisions)
        compare_decisions(worlds.tasks)
        drive_behaviours(worlds, task)
        carry_out(worlds, parameters, task, advance)
        for i in range(lanes):
            if worlds.episodes[i].terminated or worlds.episodes[i].truncated:
                if decisions[i].recall >= 0:
                    _record(worlds, i, decisions[i], outcomes)
                    running -= 1
                running += _start_next(worlds, i, parameters, task, plan, decisions[i], outcomes)


@kernel
def _start_next(
    worlds: Worlds,
    i: int,
    parameters: Parameters,
    task: TaskParameters,
    plan: Plan,
    decision: Any,
    outcomes: Outcomes,
) -> int:
    """Start a recall in a lane, one that does not count if none is left; returns how many start that count."""
    robot, last = worlds.bodies.robots, plan.keys.shape[0] - 1
    recall = take(plan.taken)
    counts = recall <= last
    robot.key[i] = plan.keys[min(recall, last)]
    robot.round[i] = 0
    enter(worlds.bodies.near, i, plan.arenas, min(recall, last))
    worlds.episodes[i].number = 0
    worlds.episodes[i].terminated = worlds.episodes[i].truncated = False
    if not begin_world(worlds, i, parameters, task, plan.start, plan.places):
        outcomes.free[0] = False
    decision.recall = recall if counts else -1
    decision.policy = plan.policies[recall] if counts else TEACHER
    decision.query = -1
    decision.ties = decision.conflicts = decision.orient_without_food = 0
    for state in range(decision.by_state.shape[0]):
        decision.by_state[state] = decision.wrong_by_state[state] = 0
    if counts:
        start = outcomes.recalls[recall].start
        start[0], start[1], start[2] = robot.x[i], robot.y[i], robot.heading[i]
        for k in range(worlds.bodies.foods.shape[0]):
            outcomes.foods[recall, k, 0] = worlds.bodies.foods[k].x[i]
            outcomes.foods[recall, k, 1] = worlds.bodies.foods[k].y[i]
    return 1 if counts else 0


@inline
def _record(worlds: Worlds, i: int, decision: Any, outcomes: Outcomes) -> None:
    """Write down what became of the recall in a lane."""
    outcome, episode, tracker = outcomes.recalls[decision.recall], worlds.episodes[i], worlds.trackers[i]
    outcome.steps, outcome.correct = episode.steps, episode.correct
    outcome.penalty = penalty(tracker.delivered, tracker.deliverable)
    outcome.score = score(episode.correct, episode.steps, outcome.penalty)
    outcome.delivered, outcome.poison_home = tracker.delivered, tracker.poison_home
    outcome.deliverable = tracker.deliverable
    outcome.ties, outcome.conflicts = decision.ties, decision.conflicts
    outcome.orient_without_food = decision.orient_without_food
    for state in range(decision.by_state.shape[0]):
        outcome.by_state[state] = decision.by_state[state]
        outcome.wrong_by_state[state] = decision.wrong_by_state[state]
    for k in range(worlds.foods.shape[1]):
        outcomes.collected[decision.recall, k] = is_collected(worlds.foods[i, k])


@entrance
def run_all(
    thread: int,
    worlds: Worlds,
    parameters: Parameters,
    task: TaskParameters,
    memories: Memories,
    plan: Plan,
    decisions: Any,
    outcomes: Outcomes,
    advance: int,
) -> None:
    """Run recalls in the block of one thread, until all are taken."""
    mine = worlds_of(worlds, thread, thread)
    _run(mine, parameters, task, memories, plan, decisions[thread], outcomes, advance)
