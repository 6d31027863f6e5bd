"""The recall phase: one robot forages alone (sections 4.6 and 5.4). What its two kinds of environment share."""

from abc import abstractmethod
from typing import Any, Generic, SupportsFloat, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.envs.arguments import (
    FoodOdds,
    arenas_of,
    food_odds,
    the_arena,
    whole_number,
)
from khepera_forage.envs.forager import Forager, site_of
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.screen import RENDER_MODES, Screen, foods_shown, robot_shown
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import LOST, World
from khepera_forage.task.food_tracking import FoodRegister, FoodTypes
from khepera_forage.task.placement import given_layout
from khepera_forage.task.scoring import penalty, score
from khepera_forage.task.states import Behaviour
from khepera_forage.vision.scene import MM_PER_PIXEL

Observation = dict[str, Any]
ActionT = TypeVar("ActionT")
MARKER = 2
"""Holes of the marker of a robot that forages alone: the learner's."""


class RecallEnv(gym.Env[Observation, ActionT], Generic[ActionT]):
    """What both kinds of recall environment share: the episode, its score and its pictures."""

    metadata = {"render_modes": list(RENDER_MODES), "render_fps": 10}  # noqa: RUF012 (Gymnasium's own form)

    def __init__(
        self,
        arena: Arena | str = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | None = None,
        food_types: FoodOdds = None,
        render_mode: str | None = None,
        world: World | None = None,
    ) -> None:
        self.world: World = PymunkWorld([the_arena(arena)], (MARKER,), noise) if world is None else world
        (self.arena,) = arenas_of(self.world, 1)
        self.foods = whole_number("foods", foods, 1)
        self.limit = whole_number("limit", limit, 1)
        self.render_mode = render_mode
        self._screen = Screen(render_mode)
        self._odds = food_odds(food_types)
        self._site = site_of(self.arena)
        self._forager: Forager | None = None
        self._steps = self._correct = 0
        self._over = True
        self._executed: Behaviour | None = None
        self.confidence: tuple[float, ...] | None = None
        """Confidence level of each behaviour, shown beside the picture; whoever decides may set it."""

    @property
    def home_radius(self) -> int:
        """Of the home, in pixels."""
        return self._site.home_radius

    @property
    def diagonal(self) -> int:
        """Of the arena, in pixels."""
        return self._site.diagonal

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
            seed: Makes the episode repeatable, bit for bit.
            options: `start` (x mm, y mm, heading degrees) and `foods`, one (x mm, y mm) an object; what is left
                out is random.

        Raises:
            ValueError: Options that are unknown or place something off the free floor.
        """
        super().reset(seed=seed)
        places, types, world = self.np_random.spawn(3)
        self.layout = given_layout(self.arena, self.foods, options or {}, places)
        self.world.reset(world, self.layout)
        register = FoodRegister(
            self._site,
            [(food.x / MM_PER_PIXEL, food.y / MM_PER_PIXEL) for food in self.layout.foods],
            FoodTypes(self.foods, self._odds, types),
        )
        self._forager = Forager(self.world.robots[0], self._site, self.world.markers[0], register)
        self._forager.perceive(self.world.camera.look())
        self._steps = self._correct = 0
        self._over = False
        self._executed = None
        if self.render_mode == "human":
            self.render()
        return self._observation(self._forager), self._info(self._forager)

    def step(self, action: ActionT) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """One round of 0.1 s.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An action that is not in the action space.
        """
        forager = self._forager or self.forager
        if self._over:
            raise ResetNeeded(f"the episode ended after {self._steps} steps; call reset() to start another")
        motors = self._motors(action, forager)
        register = forager.register
        delivered, poison = register.delivered_food, register.poison_home
        correct = self._is_correct(motors, forager)
        self._steps += 1
        self._correct += correct
        try:
            forager.drive(motors)
            self.world.advance()
            forager.perceive(self.world.camera.look())
        except LOST as lost:
            self._over = True
            info = {**self._info(forager), "robot_lost": str(lost)}
            return self._observation(forager), -1.0 / self.limit, False, True, info
        reward = (register.delivered_food - delivered) - (register.poison_home - poison) - 1.0 / self.limit
        terminated = register.finished
        truncated = not terminated and self._steps >= self.limit
        self._over = terminated or truncated
        if self.render_mode == "human":
            self.render()
        return self._observation(forager), reward, terminated, truncated, self._info(forager)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        return self._screen.show(self.view)

    def view(self) -> View:
        """What a picture of the present round shows."""
        forager = self.forager
        info = self._info(forager)
        scene = self.world.camera.look()
        return View(
            arenas=(self.arena,),
            robots=(robot_shown("robot", forager, self.world, 0, None, self._executed, self.confidence),),
            foods=foods_shown(self.world, (forager,)),
            regions=scene.regions,
            step=self._steps,
            limit=self.limit,
            score=info["score"],
            delivered=info["delivered"],
            title=f"Recall in the {self.arena.name}",
        )

    def close(self) -> None:
        """Stop the robot and close the window."""
        self.world.close()
        self._screen.close()

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
        register, raw = forager.register, forager.raw
        delivered, deliverable = register.delivered_food, register.deliverable
        state = int(forager.state)
        return {
            "state": state,
            "correct_behaviour": state,
            "pose": np.array((raw.x, raw.y, raw.orientation)),
            "score": score(self._correct, self._steps, delivered, deliverable),
            "penalty": penalty(delivered, deliverable),
            "correct": self._correct,
            "steps": self._steps,
            "delivered": delivered,
            "poison_home": register.poison_home,
        }
