"""The records of all compiled worlds that forage, or of one block of them."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.aligned import aligned_zeros
from khepera_forage.compilation.decorators import sequence
from khepera_forage.compilation.threads import most_threads_for
from khepera_forage.envs.compiled.records import (
    episode_dtype,
    food_object_dtype,
    link_dtype,
    nearest_wall_dtype,
    place_dtype,
    start_dtype,
    straight_way_dtype,
    task_dtype,
    tracker_dtype,
)
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN
from khepera_forage.sim.compiled.bodies import APART, Bodies, bodies_of, empty_bodies
from khepera_forage.sim.compiled.records import LANES

UNUSED = -1e6
"""mm at which robots stand in lanes that no world uses."""


class Worlds(NamedTuple):
    """Bodies and their task; `worlds_of` gives the records of one block.

    Attributes:
        bodies: Robots, food and tracks.
        tasks: `task_dtype`, shape (blocks,); of one block a record.
        trackers: `tracker_dtype`, shape (blocks, lanes); of one block (lanes,), and so on.
        foods: `food_object_dtype`, shape (blocks, lanes, foods).
        nearest_walls: `nearest_wall_dtype`, shape (blocks, lanes).
        straight_ways: `straight_way_dtype`, shape (blocks, lanes, 1 + foods); this and the next two are the arrays of
            `task.way_finding.KnownWays`.
        to_waypoints: `straight_way_dtype`, shape (blocks, lanes, waypoints).
        food_lengths: Shape (blocks, lanes, foods, waypoints).
        links: `link_dtype`, shape (blocks, lanes, 2 * foods).
        episodes: `episode_dtype`, shape (blocks, lanes).
        starts: `start_dtype`, shape (threads * APART, 1); of one block (1,). It holds nothing between rounds.
        places: `place_dtype`, shape (threads * APART, foods); of one block (foods,). It holds nothing between rounds.
    """

    bodies: Bodies
    tasks: Any
    trackers: Any
    foods: Any
    nearest_walls: Any
    straight_ways: Any
    to_waypoints: Any
    food_lengths: Any
    links: Any
    episodes: Any
    starts: Any
    places: Any


@sequence  # compiled functions cannot return records within a tuple
def worlds_of(worlds: Worlds, block: int, thread: int) -> Worlds:
    """The records of one block, and the scratch records of one thread."""
    return Worlds(
        bodies_of(worlds.bodies, block, thread),
        worlds.tasks[block],
        worlds.trackers[block],
        worlds.foods[block],
        worlds.nearest_walls[block],
        worlds.straight_ways[block],
        worlds.to_waypoints[block],
        worlds.food_lengths[block],
        worlds.links[block],
        worlds.episodes[block],
        worlds.starts[thread * APART],
        worlds.places[thread * APART],
    )


def empty_worlds(blocks: int, foods: int, waypoints: int, lanes: int = LANES, near: Any = ()) -> Worlds:
    """Records for some blocks. Lanes that no world uses hold a robot at rest, far from anything.

    Args:
        blocks: How many.
        foods: Food objects in each world.
        waypoints: Of the arena; the most if there are several.
        lanes: Worlds in a block.
        near: From `near_walls.empty_lists`, if worlds are in different arenas.
    """
    bodies = empty_bodies(blocks, foods, lanes, near)
    robots = bodies.robots
    robots["x"] = robots["y"] = UNUSED
    robots["cos"] = 1.0
    robots["arm"] = robots["arm_target"] = ARM_RAISED
    robots["jaw"] = robots["jaw_target"] = JAW_OPEN
    robots["held"] = -1.0
    bodies.tracks["label"] = -1
    threads = most_threads_for(blocks)
    trackers, links = (
        aligned_zeros((blocks, lanes), tracker_dtype),
        aligned_zeros((blocks, lanes, 2 * foods), link_dtype),
    )
    trackers["held"] = trackers["nearest"] = links["label"] = -1
    return Worlds(
        bodies,
        aligned_zeros(blocks, task_dtype(lanes, bool(near))),
        trackers,
        aligned_zeros((blocks, lanes, foods), food_object_dtype),
        aligned_zeros((blocks, lanes), nearest_wall_dtype),
        *known_ways(blocks, lanes, foods, waypoints),
        links,
        aligned_zeros((blocks, lanes), episode_dtype),
        aligned_zeros((threads * APART, 1), start_dtype),
        aligned_zeros((threads * APART, foods), place_dtype),
    )


def kept(worlds: Worlds) -> tuple[Any, ...]:
    """All arrays that hold something between rounds, but for the lists of near walls, which can be made again."""
    return (*worlds.bodies[:3], *worlds[1:10])


def known_ways(
    blocks: int, lanes: int, foods: int, waypoints: int
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """`straight_ways`, `to_waypoints` and `food_lengths` of robots that know nothing."""
    straight, to_waypoints = (
        aligned_zeros((blocks, lanes, count), straight_way_dtype) for count in (1 + foods, waypoints)
    )
    straight["blocker"] = to_waypoints["blocker"] = -1
    return straight, to_waypoints, aligned_zeros((blocks, lanes, foods, waypoints), np.float64)
