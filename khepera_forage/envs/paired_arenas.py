"""The world of a training phase: a copy of one arena for each robot, and how an attempt starts in them (4.5)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from khepera_forage.envs.arguments import (
    FoodOdds,
    arenas_of,
    check_round_duration,
    checked_arena,
    food_odds,
    timing_of,
)
from khepera_forage.envs.forager import Forager, arena_map_of
from khepera_forage.envs.layouts import arenas_with_marks, tracker_of, training_layout
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key


class PairedArenas:
    """A world of paired arenas, and the start of each attempt in it.

    Args:
        robots: The teacher and its learners.
        arena: The teacher's, or its name.
        noise: Of the devices, and of the operator who puts robots and food on their marks.
        food_types: Odds of the types of food; corresponding food of all arenas is of one type.
        world: Another world than the simulated one, with an arena for each robot; its arenas are then used.
        decisions: Of the task.

    Attributes:
        world: As given, or simulated.
        arenas: One for each robot, the teacher's first.
        home_radius: Of every home, in pixels.
        diagonal: Of every arena, in pixels.

    Raises:
        ValueError: An argument is not allowed, or the world does not fit.
    """

    def __init__(
        self,
        robots: int,
        arena: Arena | str,
        noise: Noise | str | None,
        food_types: FoodOdds,
        world: World | None,
        decisions: Decisions,
    ) -> None:
        if world is None:
            world = PymunkWorld(
                copies(checked_arena(arena, decisions), robots),
                (1,) + (2,) * (robots - 1),
                noise,
                timing=timing_of(decisions),
            )
        else:
            check_round_duration(world, decisions)
        self.world: World = world
        self.arenas = arenas_of(world, robots)
        self._maps = [arena_map_of(a) for a in self.arenas]
        self.home_radius, self.diagonal = self._maps[0].home_radius, self._maps[0].diagonal
        self._markers = tuple(world.markers)
        self._noise = checked_noise(noise)
        self._odds = food_odds(food_types)
        self._values = decisions.values()

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
        marked = arenas_with_marks(self.arenas, options)
        layout = training_layout(marked, self._noise, layout_key(key, episode))
        self.world.reset(rng.spawn(1)[0], layout)
        count = len(marked[0].foods)
        foragers = []
        for i, (robot, arena) in enumerate(zip(self.world.robots, self._maps, strict=True)):
            tracker = tracker_of(layout.foods[i * count : (i + 1) * count], self._maps[i])
            draw_food_types(tracker.foods, food_type_key(key, episode), self._odds)
            foragers.append(Forager(robot, arena, self._markers[i], tracker, self._values))
        return foragers
