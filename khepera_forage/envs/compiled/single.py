"""What both kinds of recall environment share on the backend "compiled", one world at a time."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, Generic

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arena_pool import ArenaPool, Arenas
from khepera_forage.envs.arguments import FoodOdds, checked_decisions, timing_of
from khepera_forage.envs.backends import COMPILED
from khepera_forage.envs.compiled.batch import as_records
from khepera_forage.envs.compiled.forager import CompiledForager
from khepera_forage.envs.compiled.kept_parameters import KeptParameters
from khepera_forage.envs.compiled.one_world import OneWorld
from khepera_forage.envs.compiled.one_world_info import POSE, REWARD, STEPS, TERMINATED, TRUNCATED, info_of
from khepera_forage.envs.compiled.records import SHOWN
from khepera_forage.envs.layouts import given_places, no_room
from khepera_forage.envs.recall import ActionT, Observation, RecallEnv
from khepera_forage.envs.rendering import Screen, View, recall_view
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.compiled.world import CompiledWorld
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour


class CompiledRecallEnv(gym.Env[Observation, ActionT], Generic[ActionT]):
    """A recall environment on compiled bodies: spaces, rewards, ends, infos and errors are those of `RecallEnv`.

    It has the episodes that the world of the same seed has in `make_vec`, to the last bit.

    Args:
        arena: As for `RecallEnv`; so are the others.
        foods: Food objects, 1 to 16.
        limit: Steps after which an episode is truncated.
        noise: The laboratory's troubles by default.
        food_types: One type, or odds by type.
        render_mode: None, "human" or "rgb_array".
        decisions: Ours by default.

    Attributes:
        arena: That of the present episode; before the first reset, the first one.
        diagonal: Of that arena, in pixels.
        largest_diagonal: Of all arenas in which an episode may take place, in pixels.
        home_radius: Of the home in that arena, in pixels.
        layout: Where everything stood at the last reset.
        world: The bodies and the camera as they are now; only the environment resets and advances them.
        confidence: Confidence level of each behaviour, shown beside the picture; a policy's owner may set it.

    Raises:
        ValueError: An argument out of range.
    """

    metadata = RecallEnv.metadata
    backend = COMPILED
    _numbers: int
    """How many numbers an action has in the kernel."""

    def __init__(
        self,
        arena: Arenas = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | str | None = None,
        food_types: FoodOdds = None,
        render_mode: str | None = None,
        decisions: Decisions | None = None,
    ) -> None:
        self.decisions = checked_decisions(decisions)
        self._pool = ArenaPool(arena, self.decisions)
        self.largest_diagonal = self._pool.diagonal
        self.arena = self._pool[0]
        self._noise, self._kept = noise, KeptParameters(foods, limit, noise, food_types, self.decisions)
        bodies, task = self._kept[self.arena]
        self.metadata = self.metadata | {"render_fps": 1 / self.decisions.round_duration}
        self.foods, self.limit = foods, limit
        self.render_mode = render_mode
        self._screen = Screen(render_mode, self.decisions.round_duration)
        like = self._like(arena=arena, foods=foods, limit=limit, decisions=self.decisions)
        self.action_space, self.observation_space = like.action_space, like.observation_space
        self._one_world = OneWorld(bodies, task, self._numbers)
        self._show_arena()
        self._read()
        self._seeded = False
        self._over = True
        self._executed: Behaviour | None = None
        self.layout: Layout
        self.confidence: tuple[float, ...] | None = None

    @property
    def forager(self) -> CompiledForager:
        """The robot at its task, as it is now."""
        self._require_first_reset()
        return CompiledForager(self._one_world, self.arena, self.decisions)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Makes this episode and those that follow repeatable, bit for bit.
            options: `start` and `foods` as for `RecallEnv`.

        Raises:
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room.
        """
        super().reset(seed=seed)
        world = self._one_world
        robot, episodes = world.worlds.bodies.robots, world.worlds.episodes
        key, number = int(robot["key"][0, 0]), int(episodes["number"][0, 0])
        new = seed is not None or not self._seeded
        if new:
            key, number = key_of(int(self.np_random.integers(2**62)) if seed is None else seed), 0
        arena = self._pool[self._pool.number(key, number)]
        world.start[:], world.places[:] = as_records(
            *given_places(arena, self.foods, options or {}), self.foods
        )
        if new:
            robot["key"], robot["round"], episodes["number"] = key, 0, 0
        self._over = True
        self._enter(arena)
        world.begins[0] = True
        world.step()
        world.begins[0] = False
        if not world.has_room[0]:
            raise no_room(self.arena.name, self.foods)
        self.world.show(world.worlds.bodies, world.parameters)
        self._seeded = True
        self._over = False
        self._executed = None
        # The robot has stood still for one round, so it is still where it started.
        self.layout = Layout(self.world.poses(), tuple(Point(x, y) for x, y, _ in self.world.food_places()))
        if self.render_mode == "human":
            self.render()
        task = self._task.tolist()
        return self._observation(task), self._info(task, self._episode.item())

    def step(self, action: ActionT) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One round.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An action that is not in the action space.
        """
        if self._over:
            self._require_reset()
        self._command(action, self._one_world.action)
        self._one_world.step()
        task, episode = self._task.tolist(), self._episode.item()
        terminated, truncated = episode[TERMINATED], episode[TRUNCATED]
        self._over = terminated or truncated
        if self.render_mode == "human":
            self.render()
        return self._observation(task), episode[REWARD], terminated, truncated, self._info(task, episode)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        return self._screen.show(self.view)

    def view(self) -> View:
        """What a picture of the present round shows.

        Raises:
            ResetNeeded: Before the first reset.
        """
        forager, info = self.forager, self._info(self._task.tolist(), self._episode.item())
        return recall_view(self.arena, self.world, forager, info, self.limit, self._executed, self.confidence)

    def close(self) -> None:
        """Close the window."""
        self._screen.close()

    @abstractmethod
    def _like(self, **kwargs: Any) -> RecallEnv[ActionT]:
        """The environment that this is on another backend."""

    @abstractmethod
    def _command(self, action: ActionT, row: NDArray[np.float64]) -> None:
        """Write an action as the kernel takes it."""

    @abstractmethod
    def _observation(self, task: Sequence[float]) -> Observation:
        """The observation, in fresh arrays, from the numbers of the fields `SHOWN` of the task."""

    def _enter(self, arena: Arena) -> None:
        """Let the coming episode take place in an arena."""
        if arena != self.arena:
            self.arena = arena
            self._one_world.enter(*self._kept[arena])
            self._show_arena()

    def _show_arena(self) -> None:
        """Make what is known of the present arena that of the environment."""
        record = self._one_world.task.arena[0]
        self._home = np.array([record[f"map_home_{name}"] for name in ("x", "y", "radius")])
        self.diagonal, self.home_radius = int(record["map_diagonal"]), int(record["map_home_radius"])
        self.world = CompiledWorld(
            self.arena,
            self._noise,
            holes=self.decisions.recall_marker,
            timing=timing_of(self.decisions),
        )

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._read()
        if self._seeded:
            self.world.show(self._one_world.worlds.bodies, self._one_world.parameters)

    def _read(self) -> None:
        """Keep views of the records that every step reads."""
        # With one lane, records of numbers are quickest to read all at once.
        worlds = self._one_world.worlds
        self._episode, self._tracker = worlds.episodes, worlds.trackers
        self._task = worlds.tasks.view(np.float64)[: len(SHOWN)]
        self._robot = worlds.bodies.robots[0]
        self._pose = worlds.bodies.robots.view(np.float64)[POSE]

    def _require_first_reset(self) -> None:
        if not self._seeded:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")

    def _require_reset(self) -> None:
        self._require_first_reset()
        steps = self._episode.item()[STEPS]
        raise ResetNeeded(f"the episode ended after {steps} steps; call reset() to start another")

    def _info(self, task: Sequence[float], episode: Sequence[Any]) -> dict[str, Any]:
        return info_of(task, episode, self._tracker.item(), self._pose)
