"""The recall phase: one robot forages alone (sections 4.6 and 5.4). What its two kinds of environment share."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Generic, SupportsFloat, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.envs.arena_pool import Arenas
from khepera_forage.envs.arguments import (
    COMPILED,
    PYMUNK,
    FoodOdds,
    check_backend,
    checked_decisions,
    whole_number,
)
from khepera_forage.envs.recalls import Forager, Shown, WorldRecalls
from khepera_forage.envs.rendering import RENDER_MODES, Screen, View, recall_view
from khepera_forage.noise import Noise
from khepera_forage.robots.model import KHEPERA
from khepera_forage.sim.arena import MOST_FOODS, Arena
from khepera_forage.sim.world import LOST, Layout, World
from khepera_forage.task.arena_map import whole_pixels
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.task.states import Behaviour

if TYPE_CHECKING:
    from khepera_forage.envs.compiled.batch import CompiledRecalls

Observation = dict[str, Any]
ActionT = TypeVar("ActionT")


def episode_info(
    state: Any,
    pose: Any,
    score: Any,
    penalty: Any,
    correct: Any,
    steps: Any,
    delivered: Any,
    poison_home: Any,
) -> dict[str, Any]:
    """The info of recall environments; every argument is one value, or an array with one element or row a world.

    Args:
        state: The state.
        pose: x and y in pixels and orientation in degrees, as the camera reports them.
        score: Equation 5.1, in percent.
        penalty: Taken off the score for food left in the arena, in percent.
        correct: Steps on which the teacher would have done the same.
        steps: Steps so far.
        delivered: Food brought home that is not poisonous.
        poison_home: Poisonous food brought home.
    """
    return {
        "state": state,
        "correct_behaviour": state,
        "pose": pose,
        "score": score,
        "penalty": penalty,
        "correct": correct,
        "steps": steps,
        "delivered": delivered,
        "poison_home": poison_home,
    }


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
        self.decisions = checked_decisions(decisions)
        self.metadata = self.metadata | {"render_fps": 1 / self.decisions.round_duration}
        self.foods = whole_number("foods", foods, 1, MOST_FOODS)
        self.limit = whole_number("limit", limit, 1)
        settings = arena, foods, limit, noise, food_types, self.decisions
        if check_backend(backend) == PYMUNK:
            self._recalls = WorldRecalls(*settings, world, robot)
        elif world is not None:
            raise ValueError(f"world is {world!r}; allowed with backend={COMPILED!r}: None")
        else:
            from khepera_forage.envs.compiled.batch import CompiledRecalls  # needs numba

            self._recalls = CompiledRecalls(*settings, robot)
        self.largest_diagonal = self._recalls.largest_diagonal
        """Of all arenas in which an episode may take place, in pixels."""
        self.render_mode = render_mode
        self._screen = Screen(render_mode, self.decisions.round_duration)
        self._seeded, self._over = False, True
        self._generator: np.random.Generator | None = None
        """The `np_random` that the episodes follow from."""
        self._executed: Behaviour | None = None
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
            ValueError: Options that are unknown or place something off the free floor, or an arena with no room.
        """
        super().reset(seed=seed)
        if self.np_random is not self._generator:
            self._generator = self.np_random
            self._recalls.seed(int(self.np_random.integers(2**62)) if seed is None else seed)
        shown = self._recalls.begin(self.np_random, options)
        self._seeded, self._over, self._executed = True, False, None
        if self.render_mode == "human":
            self.render()
        return self._observation(shown), _info(shown)

    def step(self, action: ActionT) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """One round.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An action that is not in the action space.
        """
        if self._over:
            self._require_first_reset()
            steps = self._recalls.shown().steps
            raise ResetNeeded(f"the episode ended after {steps} steps; call reset() to start another")
        numbers = self._numbers(action)
        try:
            shown = self._recalls.step(numbers)
        except LOST as lost:
            self._over, shown = True, self._recalls.shown()
            return (
                self._observation(shown),
                shown.reward,
                False,
                True,
                _info(shown) | {"robot_lost": str(lost)},
            )
        self._over = shown.terminated or shown.truncated
        if self._over:
            self.world.stop()
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
        forager, info = self.forager, _info(self._recalls.shown())
        return recall_view(self.arena, self.world, forager, info, self.limit, self._executed, self.confidence)

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
    def _observation(self, shown: Shown) -> Observation:
        """What the policy gets to know, in fresh arrays."""

    def _require_first_reset(self) -> None:
        if not self._seeded:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")


def _info(shown: Shown) -> dict[str, Any]:
    """The info of one round."""
    pose = np.array((shown.x, shown.y, shown.orientation))
    return episode_info(
        *(shown.state, pose, shown.score, shown.penalty, shown.correct, shown.steps),
        *(shown.delivered, shown.poison_home),
    )
