"""Recalls one after another in a `World`, with the rules of the task called from Python; and what environments show."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arena_pool import ArenaPool, Arenas
from khepera_forage.envs.arguments import (
    FoodOdds,
    arenas_of,
    check_round_duration,
    food_odds,
    have_grippers,
    timing_of,
)
from khepera_forage.envs.layouts import arena_map_of, given_layout, tracker_of
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors, Robot, Senses
from khepera_forage.robots.model import KHEPERA, model_of
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.simulation import Simulation
from khepera_forage.sim.world import Layout, World
from khepera_forage.task.arena_map import ArenaMap
from khepera_forage.task.behaviours import command, decode_motors, same_motors, uses_path_home
from khepera_forage.task.decisions import Decisions, DecisionValues
from khepera_forage.task.episode import Episode, begin_episode, end_step, penalty, score
from khepera_forage.task.food_tracking import FoodTracker, can_explore, share_identified
from khepera_forage.task.perception import RawData, look_up_path_home, own_region, perceive
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key
from khepera_forage.task.states import Behaviour, State, StateVector, behaviour_for, classify
from khepera_forage.vision.scene import Region, Scene


class Forager:
    """Perception and motors of one robot in its own arena.

    Args:
        robot: The body.
        arena: What it knows of its arena.
        holes: Of its marker.
        tracker: The food tracker of its arena.
        decisions: Of the task.

    Attributes:
        own: Its marker's region.
        raw: Raw data of the last round.
        vector: State vector of the last round.
        state: What the teacher would classify it as.
    """

    def __init__(
        self, robot: Robot, arena: ArenaMap, holes: int, tracker: FoodTracker, decisions: DecisionValues
    ) -> None:
        self.robot = robot
        self.arena = arena
        self.tracker = tracker
        self.holes = holes
        self.decisions = decisions
        self.own: Region
        self.raw: RawData
        self.vector: StateVector
        self.state: State
        self.senses: Senses = robot.sense()
        self.applied = Motors(0, 0, self.senses.arm, self.senses.jaw)

    @property
    def correct_behaviour(self) -> Behaviour:
        """What the teacher would do now."""
        return behaviour_for(self.state)

    def motors_for(self, behaviour: int) -> Motors:
        """What a behaviour commands now. The way home is looked up only where the behaviour uses it."""
        tracker, raw = self.tracker, self.raw
        if uses_path_home(behaviour, raw, tracker.foods, self.arena, self.decisions):
            bearing, path = look_up_path_home(raw, tracker, tracker.foods, tracker.chosen, self.arena)
            self.raw = raw._replace(home_bearing=bearing, home_path=path)
        return command(behaviour, self.raw, self.decisions)

    def drive(self, motors: Motors) -> None:
        """Command the motors for the coming round."""
        self.applied = self.robot.drive(motors)

    def perceive(self, scene: Scene) -> None:
        """Perceive what the last round has brought.

        Raises:
            RuntimeError: The scene has no marker of the robot.
        """
        could_explore = can_explore(self.senses)
        self.senses = self.robot.sense()
        own = own_region(scene, self.arena, self.holes)
        if own is None:
            raise RuntimeError("the camera's scene has lost all trace of the robot's marker")
        self.own = own
        tracker = self.tracker
        self.raw, self.vector = perceive(
            tracker,
            tracker.foods,
            tracker.chosen,
            tracker.links,
            scene.regions,
            could_explore,
            self.senses,
            self.applied,
            own.x,
            own.y,
            own.orientation,
            own.found,
            self.arena,
            self.decisions,
        )
        self.state = classify(self.vector, self.arena.home_radius, self.decisions)


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
                share_identified(forager.tracker.foods, other.tracker.foods)


class Shown(NamedTuple):
    """What environments show of a world after a round: the account of its episode, the state vector, and raw data.

    The attributes are those of `task.episode.Episode`, of the info, of `StateVector` and of `RawData`;
    `type_in_gripper` is the food type of the raw data. No distance of the state vector is longer than the diagonal.
    """

    reward: float
    terminated: bool
    truncated: bool
    score: float
    penalty: float
    correct: int
    steps: int
    delivered: int
    poison_home: int
    state: int
    x: float
    y: float
    orientation: float
    object_presence: int
    robot_home_distance: int
    food_type: int
    arms_height: int
    robot_food_distance: int
    arm: int
    jaw: int
    tracked: int
    food_seen: int
    food_x: float
    food_y: float
    type_in_gripper: int
    home_x: float
    home_y: float
    home_radius: float
    wall_distance: float
    wall_bearing: float
    diagonal: int
    proximity: tuple[int, int, int, int, int, int]


class WorldRecalls:
    """Recalls one after another in a `World`.

    Args:
        arena: As for the environments; so are the next five.
        foods: Food objects.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles by default.
        food_types: One type, or odds by type.
        decisions: Of the task.
        world: In which everything takes place; by default simulated on pymunk.
        robot: Kind of the simulated robot.

    Attributes:
        arena: That of the present episode; before the first, the first one.
        world: Bodies and camera of the present episode.
        layout: Where everything stood when the episode began.
        largest_diagonal: Of all arenas in which an episode may take place, in pixels.

    Raises:
        ValueError: An argument out of range, or a world that does not fit.
    """

    layout: Layout

    def __init__(
        self,
        arena: Arenas,
        foods: int,
        limit: int,
        noise: Noise | str | None,
        food_types: FoodOdds,
        decisions: Decisions,
        world: World | None = None,
        robot: str = KHEPERA.name,
    ) -> None:
        self._model = model_of(robot)
        self._foods, self._limit, self._noise, self._decisions = foods, limit, noise, decisions
        gripper = self._model.has_gripper if world is None else have_grippers(world)
        self._odds, self._values = food_odds(food_types, gripper), decisions.values()
        self.world: World
        if world is None:
            self._pool: ArenaPool | None = ArenaPool(arena, decisions)
            self._enter(self._pool[0])
            self.largest_diagonal = self._pool.diagonal
        else:
            check_round_duration(world, decisions)
            self._pool, self.world = None, world
            (self.arena,) = arenas_of(world, 1)
            self.largest_diagonal = arena_map_of(self.arena).diagonal
        self._key, self._episodes, self._fresh = 0, 0, True
        self._episode = Episode()
        self._forager: Forager | None = None

    @property
    def backend(self) -> str:
        """What simulates the bodies: "pymunk", or "laboratory" for real or virtual robots."""
        return "pymunk" if isinstance(self.world, PymunkWorld) else "laboratory"

    @property
    def forager(self) -> Forager:
        """The robot at its task, once an episode has begun."""
        assert self._forager is not None
        return self._forager

    def seed(self, seed: int) -> None:
        """Make the episodes that follow repeatable, bit for bit."""
        self._key, self._episodes, self._fresh = key_of(seed), 0, True

    def begin(self, rng: np.random.Generator, options: Mapping[str, Any] | None = None) -> Shown:
        """Begin the next episode.

        Args:
            rng: Spawned for a world that draws random numbers of its own.
            options: `start` and `foods` as for the environments; what is left out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor.
        """
        key, number = self._key, self._episodes
        arena = self.arena if self._pool is None else self._pool[self._pool.number(key, number)]
        layout = given_layout(arena, self._foods, options or {}, layout_key(key, number), self._values)
        # Noise goes on from episode to episode, as in compiled worlds.
        rounds = 0 if self._fresh or not isinstance(self.world, Simulation) else self.world.rounds
        if arena is not self.arena:
            self._enter(arena)
        self.layout, self._episodes, self._fresh = layout, number + 1, False
        if isinstance(self.world, Simulation):
            self.world.begin(key, rounds, layout)
        else:
            self.world.reset(rng.spawn(1)[0], layout)
        arena_map = arena_map_of(self.arena)
        tracker = tracker_of(layout.foods, arena_map)
        draw_food_types(tracker.foods, food_type_key(key, number), self._odds)
        robot = self.world.robots[0]
        values = self._decisions.values(robot.has_gripper)
        self._forager = Forager(robot, arena_map, self.world.markers[0], tracker, values)
        self._forager.perceive(self.world.camera.look())
        begin_episode(self._episode, tracker)
        return self.shown()

    def step(self, action: Sequence[float]) -> Shown:
        """One round.

        Args:
            action: The number of a behaviour, or four numbers in -1..1.

        Raises:
            RobotLost: A real robot is gone, and with `CameraLost`, the camera. The round counts.
        """
        forager = self.forager
        right = forager.correct_behaviour
        if len(action) == 1:
            motors = forager.motors_for(int(action[0]))
            correct = int(action[0]) == right
        else:
            motors = decode_motors(*action)
            correct = same_motors(motors, forager.motors_for(right), forager.decisions)
        try:
            forager.drive(motors)
            self.world.advance()
            forager.perceive(self.world.camera.look())
        finally:
            end_step(self._episode, forager.tracker, correct, self._limit)
        return self.shown()

    def shown(self) -> Shown:
        """What environments show of the last round."""
        return shown_of(self.forager, self._episode)

    def _enter(self, arena: Arena) -> None:
        """Let the coming episode take place in an arena, in a world of its own."""
        self.arena = arena
        markers = (self._decisions.recall_marker,)
        self.world = PymunkWorld(
            [arena], markers, self._noise, timing=timing_of(self._decisions), model=self._model
        )


def shown_of(forager: Forager, episode: Episode) -> Shown:
    """What environments show of a robot at its task.

    Args:
        forager: The robot.
        episode: The account of its episode.
    """
    raw, tracker, diagonal = forager.raw, forager.tracker, forager.arena.diagonal
    presence, home, food_type, arm, food = forager.vector
    lost = penalty(tracker.delivered, tracker.deliverable)
    account = episode.reward, episode.terminated, episode.truncated
    info = score(episode.correct, episode.steps, lost), lost, episode.correct, episode.steps
    vector = presence, min(home, diagonal), food_type, arm, min(food, diagonal)
    return Shown._make(
        (
            *account,
            *info,
            *(tracker.delivered, tracker.poison_home, int(forager.state)),
            *(raw.x, raw.y, float(raw.orientation)),
            *vector,
            *(raw.arm, raw.jaw, int(raw.tracked), int(raw.food_seen), raw.food_x, raw.food_y),
            *(int(raw.food_type), raw.home_x, raw.home_y, float(raw.home_radius)),
            *(raw.wall_distance, raw.wall_bearing, diagonal, raw.proximity),
        )
    )
