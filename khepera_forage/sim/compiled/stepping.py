"""One round of the bodies: `advance_block`, compiled once for all entrances that call it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.addresses import call_at
from khepera_forage.compilation.decorators import entrance
from khepera_forage.compilation.separate import address_of, compile_for, is_on_disk, meanwhile
from khepera_forage.compilation.threads import share_out
from khepera_forage.compilation.work_queue import take
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.compiled.bodies import Bodies, bodies_of, empty_bodies
from khepera_forage.sim.compiled.broad_phase import (
    find_corner_contacts,
    find_food_contacts,
    find_near,
    find_wall_contacts,
)
from khepera_forage.sim.compiled.camera import expose
from khepera_forage.sim.compiled.contact import move_in_contact
from khepera_forage.sim.compiled.drive import begin_round, move_freely, predict
from khepera_forage.sim.compiled.near_walls import Near, empty_lists, list_walls, near_walls
from khepera_forage.sim.compiled.parameters import Parameters, parameters_of
from khepera_forage.sim.compiled.records import arena_dtype
from khepera_forage.sim.compiled.sensing import cast, end_round, measure
from khepera_forage.sim.compiled.tracking import track
from khepera_forage.sim.world import Timing

_ONE = np.uint64(1)


@entrance
def advance_block(bodies: Bodies, parameters: Parameters) -> None:
    """One round in every world of a block; motor commands and the food's places are given.

    Args:
        bodies: The records of one block, see `bodies_of`.
        parameters: What is the same in all worlds.
    """
    robot, foods, scratch = bodies.robots, bodies.foods, bodies.scratch
    near, constants = bodies.near, parameters.constants
    for i in range(robot.x.shape[0]):
        robot.round[i] += _ONE
    begin_round(robot, foods, scratch, constants)
    list_walls(near, robot, scratch, parameters)
    walls, corners = near_walls(near, parameters)
    find_near(robot, foods, scratch, walls)
    predict(robot, scratch, constants)
    find_wall_contacts(robot, scratch, near, walls)
    find_corner_contacts(robot, scratch, near, corners)
    find_food_contacts(robot, foods, scratch)
    move_freely(robot, scratch, constants)
    move_in_contact(robot, foods, scratch, near, parameters)
    end_round(robot, foods)
    cast(robot, foods, scratch, walls)
    measure(robot, constants)
    expose(robot, foods, near, constants)
    track(robot, foods, bodies.tracks, bodies.detections, constants)


@entrance
def _advance_blocks(
    thread: int, bodies: Bodies, counter: NDArray[np.int64], parameters: Parameters, advance: int
) -> None:
    """One round in every block that no other thread has taken from the counter (see `work_queue`).

    `advance` is the address of `advance_block`.
    """
    block = take(counter)
    while block < bodies.robots.shape[0]:
        call_at(advance, bodies_of(bodies, block, thread), parameters)
        block = take(counter)


def advance_all(bodies: Bodies, parameters: Parameters, threads: int = 1) -> None:
    """One round in all blocks.

    Args:
        bodies: The records of all blocks.
        parameters: What is the same in all worlds.
        threads: How many work on them.
    """
    common = (bodies, np.zeros(1, np.int64), parameters)
    lanes, several = bodies.tracks.shape[1], bool(bodies.near)
    address = advance_address(lanes, _advance_blocks, 0, *common, 0, several=several)
    share_out(_advance_blocks, threads, *common, address)


_addresses: dict[tuple[int, bool], int] = {}
"""Of `advance_block` in this process, by number of lanes, and whether worlds are in several arenas."""


def advance_address(lanes: int, caller: Any, *arguments: Any, several: bool = False) -> int:
    """Address of `advance_block`, which every entrance that advances worlds takes as an argument.

    If it must be compiled first, another process does that while this one compiles the caller.

    Args:
        lanes: Worlds in a block.
        caller: The entrance.
        *arguments: All its arguments, with any number for the address.
        several: Whether worlds are in several arenas.
    """
    kind = lanes, several
    if kind not in _addresses:
        example = _example(*kind)
        if not is_on_disk(advance_block, example):
            with meanwhile(f"from {__name__} import compile_advance; compile_advance{kind}"):
                compile_for(caller, arguments)
        _addresses[kind] = address_of(advance_block, example)
    return _addresses[kind]


def compile_advance(lanes: int, several: bool) -> None:
    """Compile `advance_block`, and keep it on disk.

    Args:
        lanes: Worlds in a block.
        several: Whether worlds are in several arenas.
    """
    compile_for(advance_block, _example(lanes, several))


def _example(lanes: int, several: bool) -> tuple[Bodies, Parameters]:
    """The records of one block, and parameters; only their types matter."""
    walls = Point(0, 0), Point(300, 0), Point(300, 300), Point(0, 300)
    arena = Arena("example", walls, Point(200, 200), 50.0, Pose(50, 50, 0.0), (Point(50, 200),))
    bodies = empty_bodies(1, 1, lanes, empty_lists(1, lanes, 1, 1) if several else ())
    block = Bodies(
        *(bodies.robots[0], bodies.foods[0], bodies.tracks[0], bodies.scratch[0], bodies.detections[0]),
        Near(*(part[0] for part in bodies.near)) if several else (),
    )
    parameters = parameters_of(arena, 1, holes=1, timing=Timing(1.0, 1.0, 1.0))
    return block, parameters._replace(arenas=np.zeros(1, arena_dtype) if several else ())
