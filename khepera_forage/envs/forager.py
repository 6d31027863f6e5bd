"""Robots at their task in a `World`, with the rules of the task called from Python."""

from collections.abc import Sequence
from typing import Any

from khepera_forage.envs.arguments import COMPILED, ArenaPool, Settings, arenas_of, check_backend, food_odds, timing_of
from khepera_forage.envs.layouts import arena_map_of, known_food, paired_copies
from khepera_forage.robots.khepera import Motors, Robot, Senses
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.simulation import Simulation
from khepera_forage.sim.world import Layout, World
from khepera_forage.task.arena_map import ArenaMap
from khepera_forage.task.behaviours import behaviour_of_motors, command, path_home_for
from khepera_forage.task.decisions import DecisionValues
from khepera_forage.task.episode import Episode, ForagerState
from khepera_forage.task.food_tracking import KnownFood, can_explore, share_identified
from khepera_forage.task.perception import Marker, RawData, own_region, perceive
from khepera_forage.task.placement import draw_food_types, food_type_key
from khepera_forage.task.states import Behaviour, State, StateVector, behaviour_for
from khepera_forage.vision.scene import Scene


class Forager(ForagerState):
    """One robot at its task in its own arena, as called from Python.

    Args:
        robot: The body.
        arena: What it knows of its arena.
        holes: Of its marker.
        food: What is known of the food of its arena.
        decisions: Of the task.

    Attributes:
        raw: Raw data.
        tracker: The food tracker of its arena.
        senses: What the robot reported after the last round.
        applied: The motors of the last round, as applied.
    """

    raw: RawData
    vector: StateVector
    state: State

    def __init__(self, robot: Robot, arena: ArenaMap, holes: int, food: KnownFood, decisions: DecisionValues) -> None:
        self.robot, self.arena, self.holes, self.decisions = robot, arena, holes, decisions
        self.food, self.tracker, self.episode = food, food.tracker, Episode()
        self.behaviour = int(Behaviour.WAIT)
        self.senses: Senses = robot.sense()
        self.applied = Motors(0, 0, self.senses.arm, self.senses.jaw)

    @property
    def correct_behaviour(self) -> Behaviour:
        """What the teacher would do now."""
        return behaviour_for(self.state)

    def motors_for(self, behaviour: int) -> Motors:
        """What a behaviour commands now."""
        bearing, path = path_home_for(behaviour, self.raw, self.food, self.arena, self.decisions)
        if (bearing, path) != (self.raw.home_bearing, self.raw.home_path):
            self.raw = self.raw._replace(home_bearing=bearing, home_path=path)
        return command(behaviour, self.raw, self.decisions)

    def decide_on_motors(self, motors: Motors) -> None:
        """Decide on the behaviour that motors amount to."""
        correct = self.motors_for(self.state)
        self.behaviour = behaviour_of_motors(motors, self.state, correct, self.decisions)

    def drive(self, motors: Motors) -> None:
        """Command the motors for the coming round."""
        self.applied = self.robot.drive(motors)

    def perceive(self, scene: Scene) -> None:
        """Perceive what the last round has brought.

        Raises:
            RuntimeError: The scene has no marker of the robot.
        """
        exploring = can_explore(self.senses) and self.applied.left == 0 == self.applied.right
        self.senses = self.robot.sense()
        own = own_region(scene, self.arena, self.holes)
        if own is None:
            raise RuntimeError("the camera's scene has lost all trace of the robot's marker")
        self.own = Marker(own.x, own.y, own.orientation, own.found)
        self.raw, self.vector, self.state = perceive(
            self.food, own, scene.regions, self.senses, exploring, self.arena, self.decisions
        )


def perceive_all(foragers: Sequence[Forager], scene: Scene) -> None:
    """Let the robots of paired arenas perceive what the last round has brought.

    What one identifies, the next ones know at once, and the others a round later.

    Raises:
        RuntimeError: The scene has no marker of a robot.
    """
    for forager in foragers:
        forager.perceive(scene)
        for other in foragers:
            if other is not forager:
                share_identified(forager.food.objects, other.food.objects)


class ForagingWorld:
    """The arenas of an environment, and a world of robots that forage in one of them, or in copies of it.

    Args:
        markers: Holes of each robot's marker.
        settings: From the user.
        world: Another world than a simulated one, with an arena for each robot.
        backend: What simulates the bodies, "pymunk" or "compiled".

    Attributes:
        world: Bodies and camera of the present episode.
        arenas: One for each robot; those of the present episode, and before the first, of the first arena.
        diagonal: The largest of all arenas in which an episode may take place, in pixels.

    Raises:
        ValueError: An argument is not allowed, or the world does not fit.
    """

    world: World
    arenas: tuple[Arena, ...] = ()

    def __init__(self, markers: tuple[int, ...], settings: Settings, world: World | None, backend: str) -> None:
        self._markers, self._settings, self._backend = markers, settings, check_backend(backend)
        if world is not None and not hasattr(world, "robots"):
            raise ValueError(f"world is {world!r}; allowed: a World, such as a laboratory, or None")
        kinds: Any = [settings.model] if world is None else world.robots
        self._odds = food_odds(settings.food_types, all(kind.has_gripper for kind in kinds), settings.arena)
        if world is None:
            self._pool: ArenaPool | None = ArenaPool(settings.arena, settings.decisions)
            self.enter(self._copies(self._pool[0]))
            self.diagonal = self._pool.diagonal
        else:
            self._pool, self.world = None, world
            self.arenas = arenas_of(world, len(markers), settings.decisions)
            self.diagonal = arena_map_of(self.arenas[0]).diagonal

    @property
    def backend(self) -> str:
        """What simulates the bodies: "pymunk", "compiled", or "laboratory" for real or virtual robots."""
        return getattr(self.world, "backend", "laboratory")

    @property
    def arena(self) -> Arena:
        """The arena of the first robot."""
        return self.arenas[0]

    def arenas_of(self, key: int, episode: int) -> tuple[Arena, ...]:
        """The arenas of an episode of this number, one for each robot; the key is from `counter_rng.key_of`."""
        return self.arenas if self._pool is None else self._copies(self._pool[self._pool.number(key, episode)])

    def _copies(self, arena: Arena) -> tuple[Arena, ...]:
        return paired_copies(arena, len(self._markers)) if len(self._markers) > 1 else (arena,)

    def enter(self, arenas: tuple[Arena, ...]) -> None:
        """Let an episode take place in these arenas, in a new world if they are other ones than now."""
        if arenas == self.arenas:
            return
        kind: type[Simulation]
        if self._backend == COMPILED:
            from khepera_forage.sim.compiled.world import CompiledWorld  # needs numba

            kind = CompiledWorld
        else:
            from khepera_forage.sim.pymunk.world import PymunkWorld

            kind = PymunkWorld
        _, noise, _, decisions, model = self._settings
        self.world = kind(arenas, self._markers, noise, timing=timing_of(decisions), model=model)
        self.arenas = arenas

    def foragers(self, layout: Layout, key: int, episode: int) -> list[Forager]:
        """The robots at their task, at the start of an episode in this layout."""
        count = len(layout.foods) // len(self.arenas)
        foragers = []
        for i, robot in enumerate(self.world.robots):
            food = known_food(layout.foods[i * count : (i + 1) * count])
            draw_food_types(food.objects, food_type_key(key, episode), self._odds)
            values, holes = self._settings.decisions.values(robot.has_gripper), self.world.markers[i]
            foragers.append(Forager(robot, arena_map_of(self.arenas[i]), holes, food, values))
        return foragers
