"""`CompiledWorld`: robots, food and a camera in compiled functions. Needs numba (extra `fast`)."""

from typing import Any

import numpy as np

import khepera_forage.sim.compiled.rules  # noqa: F401 (registers the rules)
from khepera_forage.compilation import entry, rule
from khepera_forage.geometry.walls import Wall
from khepera_forage.records import array_of, dtype_of
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.camera import forget_tracks
from khepera_forage.sim.compiled.contact import move_in_contact
from khepera_forage.sim.driving import begin_round, glide, put_down
from khepera_forage.sim.records import Constants, Enclosure, FoodDetection, FoodState, RobotState
from khepera_forage.sim.simulation import Simulation, observe, sense_all
from khepera_forage.vision.association import Track

robot_dtype, food_dtype, detection_dtype, constants_dtype, track_dtype, wall_dtype = map(
    dtype_of, (RobotState, FoodState, FoodDetection, Constants, Track, Wall)
)
corner_dtype = np.dtype([("x", "f8"), ("y", "f8")])
"""A corner of walls that points into the floor."""


class CompiledWorld(Simulation):
    """A `Simulation` in compiled functions, in which `contact` moves the robots that touch something."""

    def _empty(self, arena: Arena, robots: int, foods: int) -> Enclosure:
        return Enclosure(
            np.zeros(robots, robot_dtype),
            np.zeros(foods, food_dtype),
            np.zeros(2 * foods, track_dtype),
            np.zeros(foods, detection_dtype),
            np.array(list(map(tuple, arena.wall_records)), wall_dtype),
            np.array([(x, y) for x, y, _, _ in arena.corners], corner_dtype),
        )

    def show_only(self, robots: Any, foods: Any, tracks: Any) -> None:
        """Be the world of these records, which others change: those of its only arena."""
        empty = self._empty(self.arenas[0], 0, len(foods))
        enclosure = empty._replace(robots=robots, foods=foods, tracks=tracks)
        self._show([enclosure], [0] * len(robots), [0] * len(foods))

    def _begin(self, enclosure: Enclosure) -> None:
        _begin(*enclosure[:3], array_of(self.constants))

    def _sense(self, enclosure: Enclosure) -> None:
        _sense(*enclosure, array_of(self.constants))

    def _advance(self, number: int, enclosure: Enclosure) -> None:
        _advance(*enclosure, *self._anchor, array_of(self.constants))


@rule
def advance(enclosure: Enclosure, anchor_x: float, anchor_y: float, constants: Any) -> None:
    """One round in an arena: everything moves, robots sense, and the camera takes a frame.

    Args:
        enclosure: Everything in the arena; motor commands are given.
        anchor_x: The point from which the robots' cables hang, mm.
        anchor_y: Likewise.
        constants: `Constants`.
    """
    robots, foods, walls, corners = enclosure.robots, enclosure.foods, enclosure.walls, enclosure.corners
    for i in range(len(robots)):
        begin_round(robots, i, foods, constants)
    for i in range(len(robots)):
        if not glide(robots, i, foods, walls, corners, constants):
            move_in_contact(robots, i, foods, walls, corners, constants)
    observe(enclosure, anchor_x, anchor_y, constants)


@entry
def _begin(robots: Any, foods: Any, tracks: Any, constants: Any) -> None:
    for i in range(len(robots)):
        put_down(robots[i], robots[i].x, robots[i].y, robots[i].heading, constants[0])
    forget_tracks(foods, tracks)


@entry
def _advance(
    robots: Any,
    foods: Any,
    tracks: Any,
    detections: Any,
    walls: Any,
    corners: Any,
    anchor_x: float,
    anchor_y: float,
    constants: Any,
) -> None:
    enclosure = Enclosure(robots, foods, tracks, detections, walls, corners)
    advance(enclosure, anchor_x, anchor_y, constants[0])


@entry
def _sense(
    robots: Any, foods: Any, tracks: Any, detections: Any, walls: Any, corners: Any, constants: Any
) -> None:
    sense_all(Enclosure(robots, foods, tracks, detections, walls, corners), constants[0])
