"""Rounds and the start of episodes in blocks of worlds."""

from typing import Any

from khepera_forage.compilation.addresses import call_at
from khepera_forage.compilation.decorators import entrance, inline, kernel, sequence
from khepera_forage.compilation.work_queue import take
from khepera_forage.envs.compiled.arena_maps import arena_maps, enter_map, floor_in, map_in
from khepera_forage.envs.compiled.commands import drive_actions, drive_behaviours
from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.envs.compiled.perception import perceive_block, remember_senses, track_food
from khepera_forage.envs.compiled.results import Results
from khepera_forage.envs.compiled.worlds import Worlds, worlds_of
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.sim.compiled.start import stand
from khepera_forage.task.episode import begin_episode, end_step
from khepera_forage.task.food_tracking import NOWHERE
from khepera_forage.task.placement import draw_food_types, draw_layout, food_type_key, layout_key
from khepera_forage.task.scoring import penalty, score
from khepera_forage.vision.scene import MM_PER_PIXEL


@inline
def put_down(worlds: Worlds, i: int, parameters: Parameters) -> None:
    """Put robot and food of one world where `starts` and `places` say, and forget what was known of the food."""
    start, places = worlds.starts[0], worlds.places
    stand(worlds.bodies, i, start.x, start.y, start.heading, parameters)
    tracker = worlds.trackers[i]
    tracker.held = tracker.nearest = -1
    tracker.type_in_gripper = tracker.delivered = tracker.poison_home = 0
    tracker.deliverable = places.shape[0]
    tracker.last_distance = -1.0
    for k in range(places.shape[0]):
        body, known = worlds.bodies.foods[k], worlds.foods[i, k]
        body.x[i], body.y[i] = places[k].x, places[k].y
        known.x, known.y = places[k].x / MM_PER_PIXEL, places[k].y / MM_PER_PIXEL
        known.lengths_x = known.lengths_y = NOWHERE
        known.known = 0
        known.delivered = known.carried = False
    for k in range(worlds.links.shape[1]):
        worlds.links[i, k].label = -1
    worlds.nearest_walls[i].room_of_four = 0.0
    for k in range(worlds.straight_ways.shape[1]):
        way = worlds.straight_ways[i, k]
        way.room, way.blocker, way.waypoint = 0.0, -1, 0
    for k in range(worlds.to_waypoints.shape[1]):
        worlds.to_waypoints[i, k].room, worlds.to_waypoints[i, k].blocker = 0.0, -1


@kernel
def begin_world(
    worlds: Worlds, i: int, parameters: Parameters, task: TaskParameters, given: Any, given_places: Any
) -> bool:
    """Begin an episode in one world; its first frame is taken in the coming round.

    Args:
        worlds: The records of one block.
        i: The lane.
        parameters: Of the bodies.
        task: Of the task.
        given: `start_dtype`, shape (1,): where the robot starts; not a number for a random start.
        given_places: `place_dtype`, shape (foods,): where food lies; not a number for a random place.

    Returns:
        Whether there was room.
    """
    episode, key = worlds.episodes[i], worlds.bodies.robots.key[i]
    start, places, arena = worlds.starts[0], worlds.places, task.arena[0]
    has_start, has_places = given[0].x == given[0].x, given_places[0].x == given_places[0].x
    if has_start:
        start.x, start.y, start.heading = given[0].x, given[0].y, given[0].heading
    if has_places:
        for k in range(places.shape[0]):
            places[k].x, places[k].y = given_places[k].x, given_places[k].y
    drawn_key, values = layout_key(key, episode.number), task.decisions[0]
    near = worlds.bodies.near
    enter_map(near, worlds.tasks, i, task)
    ground, arena_map = floor_in(near, task, i), map_in(arena_maps(near, task), worlds.tasks, i)
    free = draw_layout(start, places, drawn_key, ground, arena_map, values, has_start, has_places)
    put_down(worlds, i, parameters)
    draw_food_types(worlds.foods[i], food_type_key(key, episode.number), arena.odds)
    episode.number += 1
    return bool(free)


@sequence
def carry_out(worlds: Worlds, parameters: Parameters, task: TaskParameters, advance: int) -> None:
    """One round of bodies and task in every world of a block, once the motors are commanded; and what it is worth.

    `advance` is the address of `advance_block`.
    """
    robot = worlds.bodies.robots
    remember_senses(robot, worlds.tasks)
    for i in range(robot.x.shape[0]):
        worlds.tasks.begins[i] = robot.first_frame[i]
    call_at(advance, worlds.bodies, parameters)
    track_food(worlds, task)
    perceive_block(worlds, task)
    end_steps(worlds, task)


@kernel
def compare_decisions(task: Any) -> None:
    """Note in every world of a block whether the teacher would have decided the same."""
    for i in range(task.state.shape[0]):
        task.correct[i] = 1.0 if task.behaviour[i] == task.state[i] else 0.0


@kernel
def end_steps(worlds: Worlds, task: TaskParameters) -> None:
    """Account for the decision, and for what the round has brought, in every world of a block."""
    limit, decided = task.arena[0].limit, worlds.tasks
    for i in range(worlds.bodies.robots.x.shape[0]):
        if decided.begins[i] != 0.0:
            begin_episode(worlds.episodes[i], worlds.trackers[i])
        else:
            end_step(worlds.episodes[i], worlds.trackers[i], decided.correct[i] != 0.0, limit)


@kernel
def step_block(
    worlds: Worlds,
    parameters: Parameters,
    task: TaskParameters,
    actions: Any,
    waiting: Any,
    given: Any,
    given_places: Any,
    advance: int,
) -> bool:
    """One round in a block by given actions; worlds that wait begin an episode instead.

    Args:
        worlds: The records of one block.
        parameters: Of the bodies.
        task: Of the task.
        actions: One behaviour a lane, shape (lanes, 1), or four numbers in -1..1, shape (lanes, 4).
        waiting: Whether each world begins a new episode.
        given: As for `begin_world`.
        given_places: As for `begin_world`.
        advance: Address of `advance_block`.

    Returns:
        Whether all new episodes had room.
    """
    robot = worlds.bodies.robots
    free = True
    for i in range(robot.x.shape[0]):
        if waiting[i]:
            free = begin_world(worlds, i, parameters, task, given, given_places) and free
    if actions.shape[1] == 1:
        for i in range(robot.x.shape[0]):
            worlds.tasks.behaviour[i] = actions[i, 0]
        drive_behaviours(worlds, task)
    else:
        drive_actions(worlds, actions, task)
    compare_decisions(worlds.tasks)
    carry_out(worlds, parameters, task, advance)
    return free


@kernel
def write_results(results: Any, worlds: Worlds, block: int) -> None:
    """Write the results of one block, while its records are in the cache.

    Args:
        results: `Results` of all worlds.
        worlds: The records of the block.
        block: Its number.
    """
    robot, task = worlds.bodies.robots, worlds.tasks
    lanes = robot.x.shape[0]
    first = block * lanes
    for i in range(min(lanes, results.reward.shape[0] - first)):
        world, episode, tracker = first + i, worlds.episodes[i], worlds.trackers[i]
        results.reward[world] = episode.reward
        results.terminated[world], results.truncated[world] = episode.terminated, episode.truncated
        lost = penalty(tracker.delivered, tracker.deliverable)
        results.score[world], results.penalty[world] = score(episode.correct, episode.steps, lost), lost
        results.correct[world], results.steps[world] = episode.correct, episode.steps
        results.delivered[world], results.poison_home[world] = tracker.delivered, tracker.poison_home
        results.state[world] = int(task.state[i])
        results.pose[world, 0], results.pose[world, 1] = robot.marker_x[i], robot.marker_y[i]
        results.pose[world, 2] = robot.marker_heading[i]
        results.object_presence[world] = int(task.object_presence[i])
        results.robot_home_distance[world] = int(task.robot_home_distance[i])
        results.food_type[world] = int(task.vector_food_type[i])
        results.arms_height[world] = int(task.arms_height[i])
        results.robot_food_distance[world] = int(task.robot_food_distance[i])


@entrance
def step_all(
    thread: int,
    worlds: Worlds,
    taken: Any,
    free: Any,
    parameters: Parameters,
    task: TaskParameters,
    actions: Any,
    waiting: Any,
    given: Any,
    given_places: Any,
    results: Results,
    advance: int,
) -> None:
    """One round in every block that no other thread has taken, and its results; see `step_block`.

    `free[0]` becomes False where a new episode had no room.
    """
    lanes = worlds.trackers.shape[1]
    block = take(taken)
    while block < worlds.tasks.shape[0]:
        some, part = worlds_of(worlds, block, thread), slice(block * lanes, (block + 1) * lanes)
        if not step_block(some, parameters, task, actions[part], waiting[part], given, given_places, advance):
            free[0] = False
        write_results(results, some, block)
        block = take(taken)


@entrance
def read_results(results: Results, worlds: Worlds) -> None:
    """Write the results of all blocks, without a step."""
    for block in range(worlds.tasks.shape[0]):
        write_results(results, worlds_of(worlds, block, 0), block)
