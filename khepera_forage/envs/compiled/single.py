"""`Corridor-v0` and its kin in batch physics, one world at a time: what `gym.make(..., physics="batch")` makes."""

from abc import abstractmethod
from typing import Any, Generic

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.envs.arguments import FoodOdds, behaviour_number, motor_action
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.batch import asked_for, no_room
from khepera_forage.envs.compiled.one_world import OneWorld, play
from khepera_forage.envs.compiled.parameters import rules_of
from khepera_forage.envs.compiled.view import view_of
from khepera_forage.envs.recall import ActionT, Observation, RecallEnv
from khepera_forage.envs.rendering import View
from khepera_forage.envs.rendering.screen import Screen
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, MAX_SPEED
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.numbers import keys_of
from khepera_forage.task.scoring import penalty, score
from khepera_forage.task.states import BEHAVIOURS, Behaviour

Row = list[float]
_FIRST = np.zeros(1, np.int64)


class CompiledRecallEnv(gym.Env[Observation, ActionT], Generic[ActionT]):
    """A recall environment in batch physics: spaces, rewards, ends, infos and errors are those of `RecallEnv`.

    It plays what world 0 of the same seed plays in `make_vec`, to the last bit.

    Args:
        arena: As for `RecallEnv`; so are the others.
        foods: Food objects, 1 to 16.
        limit: Steps after which an episode is truncated.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type.
        render_mode: None, "human" or "rgb_array".

    Raises:
        ValueError: An argument out of range.
    """

    metadata = RecallEnv.metadata
    _numbers: int
    """How many an action has in the kernel."""

    def __init__(
        self,
        arena: Arena | str = "corridor",
        foods: int = 1,
        limit: int = 500,
        noise: Noise | None = None,
        food_types: FoodOdds = None,
        render_mode: str | None = None,
    ) -> None:
        setting, rules = rules_of(arena, foods, limit, noise, food_types)
        self.foods, self.limit = setting.foods, rules.limit
        self.render_mode = render_mode
        self._screen = Screen(render_mode)
        stands_for = self._stands_for(arena, foods, limit)
        self.arena, self.diagonal, self.home_radius = (
            stands_for.arena,
            stands_for.diagonal,
            stands_for.home_radius,
        )
        self.action_space, self.observation_space = stands_for.action_space, stands_for.observation_space
        self._home = rules.place[:3].copy()
        self._world = OneWorld(setting, rules, self._numbers)
        self._seeded = False
        self._over = True
        self._executed: Behaviour | None = None
        self.confidence: tuple[float, ...] | None = None
        """Confidence level of each behaviour, shown beside the picture; whoever decides may set it."""

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
        given, bodies = self._world.given, self._world.worlds.bodies
        given.pose[:], given.places[:] = asked_for(self.arena, self.foods, options or {})
        if seed is not None or not self._seeded:
            start = seed if seed is not None else int(self.np_random.integers(2**62))
            bodies.keys[body.KEY], bodies.keys[body.ROUND] = keys_of(start, _FIRST)[0], 0
        self._over = True
        given.fresh[0] = 1.0
        play(self._world.memory)
        given.fresh[0] = 0.0
        if np.isnan(bodies.robots[body.X]):
            raise no_room(self.arena, self.foods)
        self._seeded = True
        self._over = False
        self._executed = None
        if self.render_mode == "human":
            self.render()
        task = self._world.worlds.tasks.tolist()
        return self._observation(task), self._info(task)

    def step(self, action: ActionT) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One round of 0.1 s.

        Raises:
            ResetNeeded: Before the first reset, or after the end of an episode.
            ValueError: An action that is not in the action space.
        """
        world = self._world
        if self._over:
            self._require_reset()
        self._command(action, world.given.action)
        play(world.memory)
        task = world.worlds.tasks.tolist()
        terminated, truncated = task[at.TERMINATED] != 0.0, task[at.TRUNCATED] != 0.0
        self._over = terminated or truncated
        if self.render_mode == "human":
            self.render()
        return self._observation(task), task[at.REWARD], terminated, truncated, self._info(task)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        return self._screen.show(self.view)

    def view(self) -> View:
        """What a picture of the present round shows.

        Raises:
            ResetNeeded: Before the first reset.
        """
        if not self._seeded:
            self._require_reset()
        info = self._info(self._world.worlds.tasks.tolist())
        return view_of(self._world, self.arena, self._executed, self.confidence)._replace(
            step=info["steps"], limit=self.limit, score=info["score"], delivered=info["delivered"]
        )

    def close(self) -> None:
        """Close the window."""
        self._screen.close()

    @abstractmethod
    def _stands_for(self, arena: Arena | str, foods: int, limit: int) -> RecallEnv[ActionT]:
        """The environment that this is in other physics."""

    @abstractmethod
    def _command(self, action: ActionT, row: NDArray[np.float64]) -> None:
        """Write an action as the kernel takes it."""

    @abstractmethod
    def _observation(self, task: Row) -> Observation:
        """What the policy gets to know, in fresh arrays."""

    def _require_reset(self) -> None:
        if not self._seeded:
            raise ResetNeeded("the environment was not reset yet; call reset() before anything else")
        steps = int(self._world.worlds.tasks[at.STEPS])
        raise ResetNeeded(f"the episode ended after {steps} steps; call reset() to start another")

    def _info(self, task: Row) -> dict[str, Any]:
        state, steps, correct = int(task[at.STATE]), int(task[at.STEPS]), int(task[at.CORRECT])
        delivered, deliverable = int(task[at.DELIVERED]), int(task[at.DELIVERABLE])
        return {
            "state": state,
            "correct_behaviour": state,
            "pose": self._world.worlds.bodies.robots[body.OWN_X : body.OWN_FOUND].copy(),
            "score": score(correct, steps, delivered, deliverable),
            "penalty": penalty(delivered, deliverable),
            "correct": correct,
            "steps": steps,
            "delivered": delivered,
            "poison_home": int(task[at.POISON_HOME]),
        }


class CompiledBehavioursEnv(CompiledRecallEnv[int]):
    """`BehavioursEnv` in batch physics."""

    _numbers = 1

    def _stands_for(self, arena: Arena | str, foods: int, limit: int) -> RecallEnv[int]:
        return BehavioursEnv(arena=arena, foods=foods, limit=limit)

    def _command(self, action: int, row: NDArray[np.float64]) -> None:
        behaviour = behaviour_number(action, 10)
        self._executed = BEHAVIOURS[behaviour]
        row[0, 0] = behaviour

    def _observation(self, task: Row) -> Observation:
        diagonal = self.diagonal
        home, food = int(task[at.HOME_DISTANCE]), int(task[at.FOOD_DISTANCE])
        return {
            "object_presence": np.int64(task[at.PRESENCE]),
            "robot_home_distance": np.array((home if home < diagonal else diagonal,)),
            "food_type": np.int64(task[at.VECTOR_TYPE]),
            "arms_height": np.array((int(task[at.VECTOR_ARM]),)),
            "robot_food_distance": np.array((food if food < diagonal else diagonal,)),
        }


class CompiledWheelsEnv(CompiledRecallEnv[NDArray[np.float64]]):
    """`WheelsEnv` in batch physics."""

    _numbers = 4

    def _stands_for(self, arena: Arena | str, foods: int, limit: int) -> RecallEnv[NDArray[np.float64]]:
        return WheelsEnv(arena=arena, foods=foods, limit=limit)

    def _command(self, action: NDArray[np.float64], row: NDArray[np.float64]) -> None:
        left, right, arm, jaw = motor_action(action).tolist()
        row[0] = (
            left * MAX_SPEED,
            right * MAX_SPEED,
            round((ARM_DOWN + ARM_RAISED) / 2 - arm * (ARM_DOWN - ARM_RAISED) / 2),
            JAW_CLOSED if jaw > 0 else JAW_OPEN,
        )

    def _observation(self, task: Row) -> Observation:
        robot = self._world.worlds.bodies.robots
        senses = robot[body.PRESENT : body.PROXIMITY + 6].astype(np.int64)
        present, found = senses[0], robot[body.OWN_FOUND]
        return {
            "proximity": senses[body.PROXIMITY - body.PRESENT :],
            "arm": senses[body.ARM_READ - body.PRESENT :][:1],
            "jaw": senses[body.JAW_READ - body.PRESENT :][:1],
            "object_presence": np.int64(present != 0),
            "pose": robot[body.OWN_X : body.OWN_FOUND].copy(),
            "tracked": np.int64(found),
            "food_seen": np.int64(task[at.FOOD_SEEN]),
            "food": np.array((task[at.FOOD_X], task[at.FOOD_Y])),
            "food_type": np.int64(task[at.FOOD_TYPE]),
            "home": self._home.copy(),
            "wall": np.array((task[at.WALL_DISTANCE], task[at.WALL_BEARING])),
        }
