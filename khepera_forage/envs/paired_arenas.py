"""The world of a training phase: a copy of one arena for each robot, and how an attempt starts in them (4.5)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

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
from khepera_forage.envs.layouts import arena_map_of, arenas_with_marks, tracker_of, training_layout
from khepera_forage.envs.recalls import Forager
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.robots.model import KHEPERA, model_of
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key


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
            tracker = tracker_of(layout.foods[i * count : (i + 1) * count], self._maps[i])
            draw_food_types(tracker.foods, food_type_key(key, episode), self._odds)
            values = self._decisions.values(robot.has_gripper)
            foragers.append(Forager(robot, arena, self._markers[i], tracker, values))
        return foragers
