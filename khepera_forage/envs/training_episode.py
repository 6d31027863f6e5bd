"""One attempt at a training episode, round by round: what `TrainingEnv` wraps in PettingZoo's form (4.5, 5.3)."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.envs.arena_pool import ArenaPool, Arenas
from khepera_forage.envs.arguments import (
    PYMUNK,
    FoodOdds,
    arenas_of,
    check_backend,
    check_round_duration,
    food_odds,
    have_grippers,
    timing_of,
)
from khepera_forage.envs.layouts import arena_map_of, arenas_with_marks, known_food, training_layout
from khepera_forage.envs.recalls import Forager, perceive_all
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, Motors
from khepera_forage.robots.model import KHEPERA, model_of
from khepera_forage.sim.arena import Arena, Pose, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.episode import begin_episode, end_step, has_done_its_part
from khepera_forage.task.pairing import (
    Pairing,
    attempt_ends,
    is_complete,
    lead,
    rounds_since_done,
    update_pairing,
)
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key
from khepera_forage.task.states import Behaviour, FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL, Scene

HEARD = 5
"""Where the behaviour heard is in an observation; whether the robot is separated follows it."""


def observation_box(diagonal: int) -> spaces.Box:
    """The space of what `TrainingEpisode.observe` returns.

    Args:
        diagonal: Of the arena, in pixels.
    """
    low = np.array((0, 0, 0, ARM_RAISED, 0, 0, 0))
    high = np.array((1, diagonal, len(FoodType) - 1, ARM_DOWN, diagonal, Behaviour.WAIT, 1))
    return spaces.Box(low, high, (7,), np.int64)


class TrainingEpisode:
    """Robots side by side in copies of one arena, the teacher first, and the account of what they do.

    Args:
        world: Already reset.
        foragers: Each in its own copy of the arena; they perceive the world's first frame here.
        limit: Rounds after which the attempt is out of time.
        patience: Rounds of separation after which it is given up.
        decisions: Of the task.

    Attributes:
        foragers: As given.
        pairings: Each robot and its teacher; the teacher's own means nothing.
        motors: What each robot commands itself; None where its behaviour commands the motors.
        steps: Rounds that are over.
    """

    def __init__(
        self, world: World, foragers: Sequence[Forager], limit: int, patience: int, decisions: Decisions
    ) -> None:
        self._world = world
        self._limit, self._patience, self._decisions = limit, patience, decisions.values()
        self.foragers = list(foragers)
        self.pairings = [Pairing() for _ in self.foragers]
        self.motors: list[Motors | None] = [None] * len(self.foragers)
        self.steps = 0
        self._since_done = 0
        self._perceive(world.camera.look())
        for forager in self.foragers:
            begin_episode(forager.episode, forager.tracker)

    @property
    def any_separated(self) -> bool:
        """Whether any learner is separated from the teacher."""
        return any(pairing.separated for pairing in self.pairings)

    @property
    def complete(self) -> bool:
        """Whether every robot has done its part, and the operator has ended the episode (5.3)."""
        return is_complete(self._since_done, self._decisions)

    def over(self, complete: bool) -> bool:
        """Whether the attempt has ended, complete or not."""
        longest = max(pairing.separated_rounds for pairing in self.pairings)
        return attempt_ends(complete, self.steps, self._limit, longest, self._patience)

    def observe(self, i: int) -> NDArray[np.int64]:
        """What a robot perceives: its state vector, what it hears, whether it is separated; a fresh array."""
        heard = self.foragers[0].behaviour if i else Behaviour.WAIT
        separated = self.pairings[i].separated if i else self.any_separated
        return np.array((*self.foragers[i].vector, heard, separated), np.int64)

    def round(self) -> list[float]:
        """Carry out one round: all commands take effect together.

        Returns:
            The reward of each robot.
        """
        self.steps += 1
        correct = [forager.behaviour == forager.state for forager in self.foragers]
        try:
            for i, forager in enumerate(self.foragers):
                forager.drive(self._motors_of(i, forager))
            self._world.advance()
            self._perceive(self._world.camera.look())
        finally:  # A round in which a robot is lost counts too.
            for i, forager in enumerate(self.foragers):
                end_step(forager.episode, forager.tracker, correct[i], self._limit)
        done = all(
            has_done_its_part(f.tracker, f.food.objects, f.vector, f.arena.home_radius, f.decisions)
            for f in self.foragers
        )
        self._since_done = rounds_since_done(self._since_done, done)
        return [forager.episode.reward for forager in self.foragers]

    def place_beside_teacher(self, i: int) -> None:
        """Put a learner where the teacher is, in its own arena.

        Raises:
            ValueError: There is no room.
        """
        pairing = self.pairings[i]
        x, y, degrees = pairing.teacher_x, pairing.teacher_y, pairing.teacher_orientation
        self._world.place(i, Pose(x * MM_PER_PIXEL, y * MM_PER_PIXEL, math.radians(degrees)))
        pairing.separated_rounds = 0

    def command(self, i: int, motors: Motors) -> None:
        """Let a robot command its own motors in this round."""
        self.foragers[i].decide_on_motors(motors)
        self.motors[i] = motors

    def info(self, i: int, complete: bool = False) -> dict[str, Any]:
        """A robot's info, in plain numbers."""
        forager, pairing = self.foragers[i], self.pairings[i]
        raw, state, tracker, episode = forager.raw, int(forager.state), forager.tracker, forager.episode
        return {
            "state": state,
            "correct_behaviour": state,
            "x": raw.x,
            "y": raw.y,
            "orientation": raw.orientation,
            "pose": (raw.x, raw.y, raw.orientation),
            "score": episode.score,
            "correct": episode.correct,
            "steps": episode.steps,
            "delivered": tracker.delivered,
            "poison_home": tracker.poison_home,
            "complete": int(complete),
            "separated_rounds": pairing.separated_rounds,
            "separations": pairing.separations,
        }

    def _perceive(self, scene: Scene) -> None:
        """Let every robot perceive, and update the pairs."""
        perceive_all(self.foragers, scene)
        teacher = self.foragers[0]
        for pairing, forager in zip(self.pairings[1:], self.foragers[1:], strict=True):
            update_pairing(pairing, forager.raw, forager.arena, teacher.raw, teacher.arena, self._decisions)

    def _motors_of(self, i: int, forager: Forager) -> Motors:
        behaviour, motors = forager.behaviour, self.motors[i]
        if motors is None:
            motors = forager.motors_for(behaviour)
        elif i > 0:
            behaviour = self.foragers[0].behaviour  # what it hears decides how it is led
        if i == 0:
            return motors
        return lead(self.pairings[i], motors, behaviour, forager.raw, forager.decisions)


class PairedArenas:
    """A world of paired arenas, and the start of each attempt in it.

    Args:
        robots: The teacher and its learners.
        arena: The teacher's, or its name, or a sequence of both: each attempt then takes place in one of them.
        noise: Of the devices, and of the operator who puts robots and food on their marks.
        food_types: Odds of the types of food; corresponding food of all arenas is of one type.
        world: Another world than the simulated one, with an arena for each robot; its arenas are then used.
        decisions: Of the task.
        backend: What simulates the bodies, "pymunk" or "compiled".

    Attributes:
        world: As given, or simulated; with several arenas, that of the present attempt.
        arenas: One for each robot, the teacher's first.
        home_radius: Of every home, in pixels.
        diagonal: Of every arena, in pixels; with several arenas, the largest.

    Raises:
        ValueError: An argument is not allowed, or the world does not fit.
    """

    def __init__(
        self,
        robots: int,
        arena: Arenas,
        noise: Noise | str | None,
        food_types: FoodOdds,
        world: World | None,
        decisions: Decisions,
        backend: str = PYMUNK,
        robot: str = KHEPERA.name,
    ) -> None:
        self._model = model_of(robot)
        self._backend = check_backend(backend)
        self._robots, self._decisions = robots, decisions
        self._noise = checked_noise(noise)
        self._odds = food_odds(food_types, self._model.has_gripper if world is None else have_grippers(world))
        self._pool: ArenaPool | None = None
        self._number = 0
        if world is None:
            self._pool = ArenaPool(arena, decisions)
            self._enter(self._simulated(self._pool[0]))
            self.diagonal = self._pool.diagonal
        else:
            check_round_duration(world, decisions)
            self._enter(world)
            self.diagonal = self._maps[0].diagonal

    @property
    def backend(self) -> str:
        """What simulates the bodies: "pymunk", "compiled", or "laboratory" for real or virtual robots."""
        return "laboratory" if self._pool is None else self._backend

    def _simulated(self, arena: Arena) -> World:
        """A world with a copy of an arena for each robot, the teacher with the marker of one hole."""
        markers = (1,) + (2,) * (self._robots - 1)
        arenas, timing = copies(arena, self._robots), timing_of(self._decisions)
        if self._backend == PYMUNK:
            return PymunkWorld(arenas, markers, self._noise, timing=timing, model=self._model)
        from khepera_forage.sim.compiled.world import CompiledWorld  # needs numba

        return CompiledWorld(arenas, markers, self._noise, timing=timing, model=self._model)

    def _enter(self, world: World) -> None:
        self.world: World = world
        self.arenas = arenas_of(world, self._robots)
        self._maps = [arena_map_of(a) for a in self.arenas]
        self.home_radius = self._maps[0].home_radius
        self._markers = tuple(world.markers)

    def arena_of(self, key: int, episode: int) -> Arena:
        """The teacher's arena in an attempt.

        Args:
            key: From `counter_rng.key_of`.
            episode: Number of the attempt.
        """
        return self.arenas[0] if self._pool is None else self._pool[self._pool.number(key, episode)]

    def start(
        self, rng: np.random.Generator, key: int, episode: int, options: Mapping[str, Any]
    ) -> list[Forager]:
        """Put every robot and food object on its mark.

        Args:
            rng: Gives the world a generator of its own.
            key: From `counter_rng.key_of`; layouts and food types follow from key and episode.
            episode: Number of the attempt.
            options: `start` and `foods`, as of `TrainingEnv.reset`.

        Returns:
            The robots at their task, the teacher first.

        Raises:
            ValueError: Options that are unknown or place something off the free floor.
        """
        if self._pool is not None:
            number = self._pool.number(key, episode)
            if number != self._number:
                self._enter(self._simulated(self._pool[number]))
                self._number = number
        marked = arenas_with_marks(self.arenas, options)
        layout = training_layout(marked, self._noise, layout_key(key, episode))
        self.world.reset(rng.spawn(1)[0], layout)
        count = len(marked[0].foods)
        foragers = []
        for i, (robot, arena) in enumerate(zip(self.world.robots, self._maps, strict=True)):
            food = known_food(layout.foods[i * count : (i + 1) * count])
            draw_food_types(food.objects, food_type_key(key, episode), self._odds)
            values = self._decisions.values(robot.has_gripper)
            foragers.append(Forager(robot, arena, self._markers[i], food, values))
        return foragers
