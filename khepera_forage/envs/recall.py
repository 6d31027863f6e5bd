"""The recall phase: one robot forages alone (sections 4.6 and 5.4). What its two kinds of environment share."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, SupportsFloat, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import COMPILED, PYMUNK, Arenas, FoodOdds, Settings, check_backend, whole_number
from khepera_forage.envs.forager import Forager, ForagingWorld
from khepera_forage.envs.layouts import random_layout
from khepera_forage.envs.rendering import RENDER_MODES, Screen, View, recall_view
from khepera_forage.noise import Noise
from khepera_forage.robots.model import KHEPERA
from khepera_forage.sim.arena import MOST_FOODS, Arena
from khepera_forage.sim.simulation import Simulation
from khepera_forage.sim.world import LOST, Layout, World
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.behaviours import decode_motors
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.task.episode import ForagerState, begin_episode, end_step
from khepera_forage.task.perception import RawData
from khepera_forage.task.placement import layout_key
from khepera_forage.task.states import BEHAVIOURS, Behaviour

if TYPE_CHECKING:
    from khepera_forage.envs.compiled.batch import CompiledRecalls

Observation = dict[str, Any]
ActionT = TypeVar("ActionT")


def episode_info(forager: Any) -> dict[str, Any]:
    """The info of recall environments.

    Args:
        forager: A `ForagerState` record; or an array of them: every value then has one element or row a world.
    """
    episode, own = forager.episode, forager.own
    state = int(forager.state) if isinstance(forager, ForagerState) else forager.state
    return {
        "state": state,
        "correct_behaviour": state,
        "pose": np.array((own.x, own.y, own.orientation)).T,
        "score": episode.score,
        "penalty": episode.penalty,
        "correct": episode.correct,
        "steps": episode.steps,
        "delivered": episode.delivered,
        "poison_home": episode.poison_home,
    }


class WorldRecalls(ForagingWorld):
    """Recalls one after another in a `World`.

    Args:
        settings: From the user.
        foods: Food objects.
        limit: Steps after which an episode ends.
        world: As for `ForagingWorld`.

    Attributes:
        layout: Where everything stood when the episode began.
    """

    layout: Layout

    def __init__(self, settings: Settings, foods: int, limit: int, world: World | None = None) -> None:
        super().__init__((settings.decisions.recall_marker,), settings, world, PYMUNK)
        self._foods, self._limit, self._values = foods, limit, settings.decisions.values()
        self._key, self._episodes, self._fresh = 0, 0, True
        self._forager: Forager | None = None

    @property
    def forager(self) -> Forager:
        """The robot at its task, once an episode has begun."""
        assert self._forager is not None
        return self._forager

    @property
    def raw(self) -> RawData:
        """What the robot perceives now."""
        return self.forager.raw

    def seed(self, seed: int) -> None:
        """Make the episodes that follow repeatable, bit for bit."""
        self._key, self._episodes, self._fresh = key_of(seed), 0, True

    def begin(self, rng: np.random.Generator, options: Mapping[str, Any] | None = None) -> Forager:
        """Begin the next episode.

        Args:
            rng: Spawned for a world that draws random numbers of its own.
            options: `start` and `foods` as for the environments; what is left out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room; the
                present episode then goes on.
        """
        key, number = self._key, self._episodes
        arenas = self.arenas_of(key, number)
        layout = random_layout(arenas[0], self._foods, layout_key(key, number), self._values, options)
        # Noise goes on from episode to episode, as in compiled worlds.
        rounds = 0 if self._fresh or not isinstance(self.world, Simulation) else self.world.rounds
        self.enter(arenas)
        if isinstance(self.world, Simulation):
            self.world.begin(key, rounds, layout)
        else:
            self.world.reset(rng.spawn(1)[0], layout)
        self.layout, self._episodes, self._fresh = layout, number + 1, False
        (self._forager,) = self.foragers(layout, key, number)
        self._forager.perceive(self.world.camera.look())
        begin_episode(self._forager.episode, self._forager.tracker)
        return self._forager

    def step(self, action: Sequence[float]) -> Forager:
        """One round.

        Args:
            action: The number of a behaviour, or four numbers in -1..1.

        Raises:
            RobotLost: A real robot is gone, and with `CameraLost`, the camera. The round counts.
        """
        forager = self.forager
        if len(action) == 1:
            forager.behaviour = int(action[0])
            motors = forager.motors_for(forager.behaviour)
        else:
            motors = decode_motors(*action)
            forager.decide_on_motors(motors)
        correct = forager.behaviour == forager.state
        try:
            forager.drive(motors)
            self.world.advance()
            forager.perceive(self.world.camera.look())
        finally:
            end_step(forager.episode, forager.tracker, correct, self._limit)
        return forager


class RecallEnv(gym.Env[Observation, ActionT], Generic[ActionT]):
    """What both kinds of recall environment share: the episode, its score and its pictures."""

    metadata = {  # noqa: RUF012 (Gymnasium's own form)
        "render_modes": list(RENDER_MODES),
        "render_fps": 1 / DEFAULT_DECISIONS.round_duration,
    }

    _recalls: "WorldRecalls | CompiledRecalls"

    def __init__(
        self,
        arena: Arenas = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | str | None = "laboratory",
        food_types: FoodOdds = None,
        render_mode: str | None = None,
        world: World | None = None,
        decisions: Decisions | None = None,
        backend: str = PYMUNK,
        robot: str = KHEPERA.name,
    ) -> None:
        settings = Settings.of(arena, noise, food_types, decisions, robot)
        self.decisions = settings.decisions
        self.metadata = self.metadata | {"render_fps": 1 / self.decisions.round_duration}
        self.foods = whole_number("foods", foods, 1, MOST_FOODS)
        self.limit = whole_number("limit", limit, 1)
        if check_backend(backend) == PYMUNK:
            self._recalls = WorldRecalls(settings, foods, limit, world)
        elif world is not None:
            raise ValueError(f"world is {world!r}; allowed with backend={COMPILED!r}: None")
        else:
            from khepera_forage.envs.compiled.batch import CompiledRecalls  # needs numba

            self._recalls = CompiledRecalls(settings, foods, limit)
        self.largest_diagonal = self._recalls.diagonal
        """Of all arenas in which an episode may take place, in pixels."""
        self.render_mode = render_mode
        self._screen = Screen(render_mode, self.decisions.round_duration)
        self._seeded, self._over = False, True
        self._generator: np.random.Generator | None = None
        """The `np_random` that the episodes follow from."""
        self._executed: Behaviour | None = None
        self._correct: Behaviour | None = None
        self._state = 0
        self.confidence: tuple[float, ...] | None = None
        """Confidence level of each behaviour, shown beside the picture; a policy's owner may set it."""

    @property
    def backend(self) -> str:
        """What simulates the bodies: "pymunk", "compiled", or "laboratory" for real or virtual robots."""
        return self._recalls.backend

    @property
    def arena(self) -> Arena:
        """That of the present episode; before the first reset, the first one."""
        return self._recalls.arena

    @property
    def world(self) -> World:
        """The bodies and the camera as they are now; only the environment resets and advances them."""
        return self._recalls.world

    @property
    def layout(self) -> Layout:
        """Where everything stood at the last reset."""
        self._require_first_reset()
        return self._recalls.layout

    @property
    def home_radius(self) -> int:
        """Of the home in the arena of the present episode, in pixels."""
        return whole_pixels(self.arena.home_radius)

    @property
    def diagonal(self) -> int:
        """Of the arena of the present episode, in pixels."""
        return whole_pixels(self.arena.diagonal)

    @property
    def forager(self) -> Forager:
        """The robot at its task, as it is now."""
        self._require_first_reset()
        return self._recalls.forager

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Makes this episode and those that follow repeatable, bit for bit. The same seed has the same start,
                food places, food types and noise on every backend. Without a seed, episodes go on, or follow from an
                `np_random` that was set meanwhile.
            options: `start` (x mm, y mm, heading degrees) and `foods`, one (x mm, y mm) an object; what is left
                out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room; the
                present episode then goes on. After any other error, such as a lost robot, another reset is needed.
        """
        super().reset(seed=seed)
        if self.np_random is not self._generator:
            self._generator = self.np_random
            self._recalls.seed(int(self.np_random.integers(2**62)) if seed is None else seed)
        try:
            forager = self._recalls.begin(self.np_random, options)
        except Exception as error:
            self._over |= not isinstance(error, ValueError)
            raise
        self._seeded, self._over, self._executed, self._correct = True, False, None, None
        self._state = int(forager.state)
        if self.render_mode == "human":
            self.render()
        return self._observation(forager), episode_info(forager)

    def step(self, action: ActionT) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """One round.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An action that is not in the action space.
        """
        if self._over:
            self._require_first_reset()
            steps = self._recalls.forager.episode.steps
            raise ResetNeeded(f"the episode ended after {steps} steps; call reset() to start another")
        numbers = self._numbers(action)
        self._correct = BEHAVIOURS[self._state]
        try:
            forager = self._recalls.step(numbers)
        except LOST as lost:
            self._over, forager = True, self._recalls.forager
            info = episode_info(forager) | {"robot_lost": str(lost)}
            return self._observation(forager), forager.episode.reward, False, True, info
        episode, self._state = forager.episode, int(forager.state)
        self._over = episode.terminated or episode.truncated
        if self._over:
            self.world.stop()
        if self.render_mode == "human":
            self.render()
        ends = episode.terminated, episode.truncated
        return self._observation(forager), episode.reward, *ends, episode_info(forager)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        return self._screen.show(self.view)

    def view(self) -> View:
        """What a picture of the present round shows.

        Raises:
            ResetNeeded: Before the first reset.
        """
        robot = {"executed": self._executed, "correct": self._correct, "confidence": self.confidence}
        return recall_view(self.arena, self.world, self.forager, self.limit, **robot)

    def close(self) -> None:
        """Stop the robot and close the window."""
        self.world.close()
        self._screen.close()

    @abstractmethod
    def _numbers(self, action: ActionT) -> Sequence[float]:
        """An action as `WorldRecalls.step` takes it.

        Raises:
            ValueError: It is not in the action space.
        """

    @abstractmethod
    def _observation(self, forager: ForagerState) -> Observation:
        """What the policy gets to know, in fresh arrays."""

    def _require_first_reset(self) -> None:
        if not self._seeded:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")
