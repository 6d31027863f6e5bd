"""The recall environments on the backend "compiled", one world at a time: `gym.make(..., backend="compiled")`."""

from abc import abstractmethod
from typing import Any, Generic

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.envs.arena_pool import Arenas
from khepera_forage.envs.arguments import FoodOdds, checked_decisions, motor_action
from khepera_forage.envs.backends import COMPILED
from khepera_forage.envs.behaviours_env import BehavioursEnv, observation_of
from khepera_forage.envs.compiled.batch import CompiledBatch, Shown
from khepera_forage.envs.compiled.forager import CompiledForager, world_of_records
from khepera_forage.envs.recall import ActionT, Observation, RecallEnv, episode_info
from khepera_forage.envs.rendering import Screen, View, recall_view
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Point
from khepera_forage.sim.world import Layout
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import BEHAVIOURS, NUM_BEHAVIOURS, Behaviour, behaviour_number

_FIRST = np.zeros(1, np.int64)
"""The only world of a batch of one."""
_VECTOR = slice(Shown._fields.index("object_presence"), Shown._fields.index("robot_food_distance") + 1)
"""Where the state vector is in what environments show."""


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
        layout: Where everything stood at the last reset.
        world: The bodies and the camera as they are now; only the environment resets and advances them.
        confidence: Confidence level of each behaviour, shown beside the picture; a policy's owner may set it.

    Raises:
        ValueError: An argument out of range.
    """

    metadata = RecallEnv.metadata
    backend = COMPILED
    _numbers: int
    """How many numbers an action has."""

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
        self._batch = CompiledBatch(1, arena, foods, limit, noise, food_types, self.decisions)
        self._noise = noise
        self.metadata = self.metadata | {"render_fps": 1 / self.decisions.round_duration}
        self.foods, self.limit = foods, limit
        self.render_mode = render_mode
        self._screen = Screen(render_mode, self.decisions.round_duration)
        like = self._like(arena=arena, foods=foods, limit=limit, decisions=self.decisions)
        self.action_space, self.observation_space = like.action_space, like.observation_space
        self.largest_diagonal = like.largest_diagonal
        self._waiting, self._action = np.zeros(1, np.bool_), np.zeros((1, self._numbers))
        self._seeded, self._over = False, True
        self._executed: Behaviour | None = None
        self._enter_arena()
        self.layout: Layout
        self.confidence: tuple[float, ...] | None = None

    @property
    def diagonal(self) -> int:
        """Of the arena of the present episode, in pixels."""
        return whole_pixels(self.arena.diagonal)

    @property
    def home_radius(self) -> int:
        """Of the home in the arena of the present episode, in pixels."""
        return whole_pixels(self.arena.home_radius)

    @property
    def forager(self) -> CompiledForager:
        """The robot at its task, as it is now."""
        self._require_first_reset()
        return CompiledForager(self._batch.world(0), self.arena, self.decisions)

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
        batch = self._batch
        if seed is not None or not self._seeded:
            batch.seed([int(self.np_random.integers(2**62)) if seed is None else seed], _FIRST)
        batch.restart(_FIRST, options)
        self._seeded, self._over, self._executed = True, False, None
        self._enter_arena()
        # The robot has stood still for one round, so it is still where it started.
        self.layout = Layout(self.world.poses(), tuple(Point(x, y) for x, y, _ in self.world.food_places()))
        if self.render_mode == "human":
            self.render()
        shown = Shown._make(batch.shown[0].item())
        return self._observation(shown), _info(shown)

    def step(self, action: ActionT) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One round.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An action that is not in the action space.
        """
        if self._over:
            self._require_first_reset()
            steps = int(self._batch.shown["steps"][0])
            raise ResetNeeded(f"the episode ended after {steps} steps; call reset() to start another")
        self._command(action, self._action[0])
        shown = Shown._make(self._batch.step(self._action, self._waiting)[0].item())
        self._over = shown.terminated or shown.truncated
        if self.render_mode == "human":
            self.render()
        return self._observation(shown), shown.reward, shown.terminated, shown.truncated, _info(shown)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        return self._screen.show(self.view)

    def view(self) -> View:
        """What a picture of the present round shows.

        Raises:
            ResetNeeded: Before the first reset.
        """
        forager, info = self.forager, _info(Shown._make(self._batch.shown[0].item()))
        return recall_view(self.arena, self.world, forager, info, self.limit, self._executed, self.confidence)

    def close(self) -> None:
        """Close the window."""
        self._screen.close()

    @abstractmethod
    def _like(self, **kwargs: Any) -> RecallEnv[ActionT]:
        """The environment that this is on another backend."""

    @abstractmethod
    def _command(self, action: ActionT, row: NDArray[np.float64]) -> None:
        """Write an action as `CompiledBatch.step` takes it."""

    @abstractmethod
    def _observation(self, shown: Shown) -> Observation:
        """The observation, in fresh arrays, from what environments show."""

    def _enter_arena(self) -> None:
        """Make the arena of the world that of the environment."""
        self.arena = self._batch.arenas[0]
        self.world = world_of_records(self._batch.world(0), self.arena, self._noise, self.decisions)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._enter_arena()  # a copied world would show records of its own

    def _require_first_reset(self) -> None:
        if not self._seeded:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")


def _info(shown: Shown) -> dict[str, Any]:
    """The info of one round, from what environments show."""
    pose = np.array((shown.x, shown.y, shown.orientation))
    return episode_info(
        *(shown.state, pose, shown.score, shown.penalty, shown.correct, shown.steps),
        *(shown.delivered, shown.poison_home),
    )


class CompiledBehavioursEnv(CompiledRecallEnv[int]):
    """`BehavioursEnv` on the backend "compiled"."""

    _numbers = 1

    def _like(self, **kwargs: Any) -> RecallEnv[int]:
        return BehavioursEnv(**kwargs)

    def _command(self, action: int, row: NDArray[np.float64]) -> None:
        row[0] = behaviour = behaviour_number(action, NUM_BEHAVIOURS)
        self._executed = BEHAVIOURS[behaviour]

    def _observation(self, shown: Shown) -> Observation:
        vector: Any = shown[_VECTOR]
        return observation_of(vector, shown.diagonal)


class CompiledWheelsEnv(CompiledRecallEnv[NDArray[np.float64]]):
    """`WheelsEnv` on the backend "compiled"."""

    _numbers = 4

    def _like(self, **kwargs: Any) -> RecallEnv[NDArray[np.float64]]:
        return WheelsEnv(**kwargs)

    def _command(self, action: NDArray[np.float64], row: NDArray[np.float64]) -> None:
        row[:] = motor_action(action)

    def _observation(self, shown: Shown) -> Observation:
        return {
            "proximity": np.array(shown.proximity),
            "arm": np.array((shown.arm,)),
            "jaw": np.array((shown.jaw,)),
            "object_presence": np.int64(shown.object_presence),
            "pose": np.array((shown.x, shown.y, shown.orientation)),
            "tracked": np.int64(shown.tracked),
            "food_seen": np.int64(shown.food_seen),
            "food": np.array((shown.food_x, shown.food_y)),
            "food_type": np.int64(shown.type_in_gripper),
            "home": np.array((shown.home_x, shown.home_y, shown.home_radius)),
            "wall": np.array((shown.wall_distance, shown.wall_bearing)),
        }
