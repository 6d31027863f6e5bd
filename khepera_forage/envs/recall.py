"""The recall phase: one robot forages alone (sections 4.6 and 5.4). What its two kinds of environment share."""

from abc import abstractmethod
from typing import Any, Generic, SupportsFloat, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arena_pool import ArenaPool, Arenas
from khepera_forage.envs.arguments import (
    FoodOdds,
    arenas_of,
    check_round_duration,
    checked_decisions,
    food_odds,
    timing_of,
    whole_number,
)
from khepera_forage.envs.forager import Forager, arena_map_of
from khepera_forage.envs.layouts import given_layout, tracker_of
from khepera_forage.envs.rendering import RENDER_MODES, Screen, View, recall_view
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.arena import MOST_FOODS, Arena
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import LOST, World
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions
from khepera_forage.task.episode import Episode, begin_episode, end_step, penalty, score
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key
from khepera_forage.task.states import Behaviour

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

    def __init__(
        self,
        arena: Arenas = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | str | None = None,
        food_types: FoodOdds = None,
        render_mode: str | None = None,
        world: World | None = None,
        decisions: Decisions | None = None,
    ) -> None:
        self.decisions = checked_decisions(decisions)
        self.metadata = self.metadata | {"render_fps": 1 / self.decisions.round_duration}
        self._noise = noise
        self.world: World
        if world is None:
            self._pool: ArenaPool | None = ArenaPool(arena, self.decisions)
            self._enter(self._pool[0])
        else:
            check_round_duration(world, self.decisions)
            self._pool, self.world = None, world
            (self.arena,) = arenas_of(self.world, 1)
            self._map = arena_map_of(self.arena)
        self.foods = whole_number("foods", foods, 1, MOST_FOODS)
        self.limit = whole_number("limit", limit, 1)
        self.render_mode = render_mode
        self._screen = Screen(render_mode, self.decisions.round_duration)
        self._odds = food_odds(food_types)
        self._values = self.decisions.values()
        self._key: int | None = None
        self._episodes = 0
        self._forager: Forager | None = None
        self._episode = Episode()
        self._over = True
        self._executed: Behaviour | None = None
        self.confidence: tuple[float, ...] | None = None
        """Confidence level of each behaviour, shown beside the picture; a policy's owner may set it."""

    @property
    def backend(self) -> str:
        """What simulates the bodies: "pymunk", "compiled", or "laboratory" for real or virtual robots."""
        return "pymunk" if isinstance(self.world, PymunkWorld) else "laboratory"

    @property
    def home_radius(self) -> int:
        """Of the home in the arena of the present episode, in pixels."""
        return self._map.home_radius

    @property
    def diagonal(self) -> int:
        """Of the arena of the present episode, in pixels."""
        return self._map.diagonal

    @property
    def largest_diagonal(self) -> int:
        """Of all arenas in which an episode may take place, in pixels."""
        return self._map.diagonal if self._pool is None else self._pool.diagonal

    @property
    def forager(self) -> Forager:
        """The robot at its task."""
        if self._forager is None:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")
        return self._forager

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Makes this episode and those that follow repeatable, bit for bit. The same seed has the same start,
                food places and food types on every backend.
            options: `start` (x mm, y mm, heading degrees) and `foods`, one (x mm, y mm) an object; what is left
                out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor.
        """
        super().reset(seed=seed)
        if seed is not None or self._key is None:
            self._key = key_of(int(self.np_random.integers(2**62)) if seed is None else seed)
            self._episodes = 0
        key, episode = self._key, self._episodes
        arena = self.arena if self._pool is None else self._pool[self._pool.number(key, episode)]
        self.layout = given_layout(arena, self.foods, options or {}, layout_key(key, episode), self._values)
        if arena is not self.arena:
            self._enter(arena)
        self._episodes += 1
        self.world.reset(self.np_random.spawn(1)[0], self.layout)
        tracker = tracker_of(self.layout.foods, self._map)
        draw_food_types(tracker.foods, food_type_key(key, episode), self._odds)
        self._forager = Forager(self.world.robots[0], self._map, self.world.markers[0], tracker, self._values)
        self._forager.perceive(self.world.camera.look())
        begin_episode(self._episode, tracker)
        self._over = False
        self._executed = None
        if self.render_mode == "human":
            self.render()
        return self._observation(self._forager), self._info(self._forager)

    def step(self, action: ActionT) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """One round.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An action that is not in the action space.
        """
        forager, episode = self._forager or self.forager, self._episode
        if self._over:
            raise ResetNeeded(f"the episode ended after {episode.steps} steps; call reset() to start another")
        motors = self._motors(action, forager)
        correct = self._is_correct(motors, forager)
        try:
            forager.drive(motors)
            self.world.advance()
            forager.perceive(self.world.camera.look())
        except LOST as lost:
            self._over = True
            end_step(episode, forager.tracker, correct, self.limit)
            info = {**self._info(forager), "robot_lost": str(lost)}
            return self._observation(forager), episode.reward, False, True, info
        end_step(episode, forager.tracker, correct, self.limit)
        self._over = episode.terminated or episode.truncated
        if self._over:
            self.world.stop()
        if self.render_mode == "human":
            self.render()
        return (
            self._observation(forager),
            episode.reward,
            episode.terminated,
            episode.truncated,
            self._info(forager),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        return self._screen.show(self.view)

    def view(self) -> View:
        """What a picture of the present round shows."""
        forager = self.forager
        info = self._info(forager)
        return recall_view(self.arena, self.world, forager, info, self.limit, self._executed, self.confidence)

    def close(self) -> None:
        """Stop the robot and close the window."""
        self.world.close()
        self._screen.close()

    def _enter(self, arena: Arena) -> None:
        """Let the coming episode take place in an arena, in a world of its own."""
        self.arena, self._map = arena, arena_map_of(arena)
        self.world = PymunkWorld(
            [arena], (self.decisions.recall_marker,), self._noise, timing=timing_of(self.decisions)
        )

    @abstractmethod
    def _motors(self, action: ActionT, forager: Forager) -> Motors:
        """What an action commands."""

    @abstractmethod
    def _is_correct(self, motors: Motors, forager: Forager) -> bool:
        """Whether the teacher would have done the same on the same perception."""

    @abstractmethod
    def _observation(self, forager: Forager) -> Observation:
        """What the policy gets to know, in fresh arrays."""

    def _info(self, forager: Forager) -> dict[str, Any]:
        raw = forager.raw
        pose = np.array((raw.x, raw.y, raw.orientation))
        episode, tracker = self._episode, forager.tracker
        lost = penalty(tracker.delivered, tracker.deliverable)
        return episode_info(
            int(forager.state),
            pose,
            score(episode.correct, episode.steps, lost),
            lost,
            episode.correct,
            episode.steps,
            tracker.delivered,
            tracker.poison_home,
        )
