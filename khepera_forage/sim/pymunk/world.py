"""`PymunkWorld`: robots that touch something are moved by pymunk's rigid bodies."""

from typing import Any

from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.camera import forget_tracks
from khepera_forage.sim.driving import begin_round, glide, put_down
from khepera_forage.sim.pymunk.bodies import Bodies
from khepera_forage.sim.records import Enclosure, FoodDetection, FoodState, RobotState
from khepera_forage.sim.simulation import Simulation, observe, sense_all
from khepera_forage.vision.association import Track


class PymunkWorld(Simulation):
    """A `Simulation` in which pymunk moves the robots that touch something."""

    def _empty(self, arena: Arena, robots: int, foods: int) -> Enclosure:
        return Enclosure(
            [RobotState() for _ in range(robots)],
            [FoodState() for _ in range(foods)],
            [Track() for _ in range(2 * foods)],
            [FoodDetection() for _ in range(foods)],
            arena.wall_records,
            [Point(x, y) for x, y, _, _ in arena.corners],
        )

    def _begin(self, enclosure: Enclosure) -> None:
        self._bodies: dict[int, Bodies] = {}
        for robot in enclosure.robots:
            put_down(robot, robot.x, robot.y, robot.heading, self.constants)
        forget_tracks(enclosure.foods, enclosure.tracks)

    def _sense(self, enclosure: Enclosure) -> None:
        sense_all(enclosure, self.constants)

    def _advance(self, number: int, enclosure: Enclosure) -> None:
        robots, foods, _, _, walls, corners = enclosure
        for i in range(len(robots)):
            begin_round(robots, i, foods, self.constants)
        touching = [
            i for i in range(len(robots)) if not glide(robots, i, foods, walls, corners, self.constants)
        ]
        if touching:
            if number not in self._bodies:
                self._bodies[number] = Bodies(enclosure)
            self._bodies[number].advance(touching, self.constants)
        observe(enclosure, *self._anchor, self.constants)

    def __getstate__(self) -> dict[str, Any]:
        # A copy continues like its original, bit for bit: both make their bodies anew.
        self._bodies = {}
        return super().__getstate__()
