"""The recall phase as Gymnasium environments: one robot forages alone (sections 4.6 and 5.4)."""

from abc import abstractmethod
from typing import Any, Generic, SupportsFloat, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from khepera_forage.envs.checks import (
    FoodOdds,
    behaviour_number,
    food_odds,
    motor_action,
    the_arena,
    whole_number,
)
from khepera_forage.envs.forager import Forager, site_of
from khepera_forage.envs.placement import given_layout
from khepera_forage.envs.register import FoodRegister, FoodTypes
from khepera_forage.envs.rendering import Renderer, View
from khepera_forage.envs.showing import foods_shown, robot_shown
from khepera_forage.foraging.scoring import penalty, score
from khepera_forage.foraging.states import Behaviour
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, MAX_SPEED, Motors
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.worlds.arena import Arena
from khepera_forage.worlds.pymunk_world import PymunkWorld
from khepera_forage.worlds.world import World

Observation = dict[str, Any]
ActionT = TypeVar("ActionT")
MARKER = 2
"""Holes of the marker of a robot that forages alone: the learner's."""


class RecallEnv(gym.Env[Observation, ActionT], Generic[ActionT]):
    """What both kinds of recall environment share: the episode, its score and its pictures."""

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 10}  # noqa: RUF012 (Gymnasium's own form)

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
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(
                f"render_mode is {render_mode!r}; allowed: None, {self.metadata['render_modes']}"
            )
        self.arena = the_arena(arena)
        self.foods = whole_number("foods", foods, 1)
        self.limit = whole_number("limit", limit, 1)
        self.render_mode = render_mode
        self._odds = food_odds(food_types)
        self._site = site_of(self.arena)
        self.world: World = PymunkWorld([self.arena], (MARKER,), noise) if world is None else world
        self._forager: Forager | None = None
        self._renderer: Renderer | None = None
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
        self._forager = Forager(self.world.robots[0], self._site, MARKER, register)
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
        forager = self.forager
        if self._over:
            raise ResetNeeded(f"the episode ended after {self._steps} steps; call reset() to start another")
        motors = self._motors(action, forager)
        register = forager.register
        delivered, poison = register.delivered_food, register.poison_home
        correct = self._is_correct(motors, forager)
        forager.drive(motors)
        self.world.advance()
        forager.perceive(self.world.camera.look())
        self._steps += 1
        self._correct += correct
        reward = (register.delivered_food - delivered) - (register.poison_home - poison) - 1.0 / self.limit
        terminated = register.finished
        truncated = not terminated and self._steps >= self.limit
        self._over = terminated or truncated
        if self.render_mode == "human":
            self.render()
        return self._observation(forager), reward, terminated, truncated, self._info(forager)

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present round as an array in mode `rgb_array`; in the window in mode `human`."""
        if self.render_mode is None:
            gym.logger.warn(
                "render() without a render_mode; make the environment with render_mode='rgb_array'"
            )
            return None
        if self._renderer is None:
            self._renderer = Renderer(self.render_mode)
        return self._renderer.draw(self.view())

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
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

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
        state = forager.state
        return {
            "state": int(state),
            "correct_behaviour": int(state),
            "pose": np.array((raw.x, raw.y, raw.orientation)),
            "score": score(self._correct, self._steps, delivered, deliverable),
            "penalty": penalty(delivered, deliverable),
            "correct": self._correct,
            "steps": self._steps,
            "delivered": delivered,
            "poison_home": register.poison_home,
        }


class BehavioursEnv(RecallEnv[int]):
    """Forage alone, choosing one of ten behaviours at every step.

    ## Description
    The recall phase of the thesis (4.6, 5.4): a Khepera with a gripper finds food, picks it up or pushes it, brings
    it home, and leaves poison where it is. The behaviours are given (4.2.1); what to do when is what is learned.
    Robot and food stand at random places; the home is at one end. A step is a round of 0.1 s.

    ## Action space
    `Discrete(10)`: 0 SEARCH FOR FOOD, 1 MOVE SLOWLY, 2 ORIENT WITH FOOD, 3 EXPLORE FOOD, 4 PICK UP FOOD,
    5 PUSH FOOD, 6 AVOID FOOD, 7 GO HOME, 8 AVOID HOME, 9 RELEASE FOOD (table 4.1).

    ## Observation space
    The state vector of section 4.3, a `Dict`:

    | key | space | meaning |
    |---|---|---|
    | object_presence | Discrete(2) | 1 while something interrupts the gripper's optical barrier |
    | robot_home_distance | Box(0, diagonal, (1,), int64) | pixels of 5 mm to the centre of the home |
    | food_type | Discrete(4) | 0 unknown, 1 pickable, 2 pushable, 3 poisonous; known of food in the gripper |
    | arms_height | Box(215, 255, (1,), int64) | 255 down, 215 raised |
    | robot_food_distance | Box(0, diagonal, (1,), int64) | pixels to the nearest candidate; the diagonal without one |

    ## Rewards
    +1 for food delivered, -1 for poison brought home, -1/limit a step.

    ## Starting state
    The robot anywhere outside home, heading uniform; food outside home, further than the close threshold from the
    robot and where a gripper fits around it. `reset(options={"start": (x, y, degrees), "foods": [(x, y), ...]})`
    places them, in mm.

    ## Episode end
    Terminated when all food is delivered or known to be poisonous; truncated after `limit` steps.

    ## Info
    `state`, `correct_behaviour` (what the teacher would do now), `pose` (x, y in pixels, degrees, as the camera
    reports it), `score` (equation 5.1, percent), `penalty`, `correct`, `steps`, `delivered`, `poison_home`.

    ## Arguments
    `arena` (an `Arena`), `foods` (number of objects), `limit` (steps), `noise` (a `Noise`, by default the
    laboratory's), `food_types` (one type, or odds by type; by default all PICKABLE), `render_mode`, `world` (another
    `World` than the simulated one).

    ## Version history
    v0: first version.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        diagonal = self._site.diagonal
        distance = spaces.Box(0, diagonal, (1,), np.int64)
        self.action_space = spaces.Discrete(10)  # type: ignore[assignment]
        self.observation_space = spaces.Dict(
            object_presence=spaces.Discrete(2),
            robot_home_distance=distance,
            food_type=spaces.Discrete(4),
            arms_height=spaces.Box(ARM_RAISED, ARM_DOWN, (1,), np.int64),
            robot_food_distance=spaces.Box(0, diagonal, (1,), np.int64),
        )

    def _motors(self, action: int, forager: Forager) -> Motors:
        behaviour = behaviour_number(action, 10)
        self._executed = Behaviour(behaviour)
        return forager.motors_for(behaviour)

    def _is_correct(self, motors: Motors, forager: Forager) -> bool:
        return self._executed == forager.correct_behaviour

    def _observation(self, forager: Forager) -> Observation:
        presence, home, food_type, arm, food = forager.vector
        diagonal = self._site.diagonal
        return {
            "object_presence": np.int64(presence),
            "robot_home_distance": np.array((min(home, diagonal),)),
            "food_type": np.int64(food_type),
            "arms_height": np.array((arm,)),
            "robot_food_distance": np.array((min(food, diagonal),)),
        }


class WheelsEnv(RecallEnv[NDArray[np.float64]]):
    """Forage alone, commanding wheels, arm and jaw at every step.

    ## Description
    The task of `Corridor-v0` and `Rectangle-v0` one level down: raw data in, motors out, so that the behaviours too
    can be learned (4.8).

    ## Action space
    `Box(-1, 1, (4,), float32)`: left wheel and right wheel (-1..1 is -20..20 speed units of 8 mm/s, rounded to whole
    units), arm (-1 is 255, down; +1 is 215, raised), jaw (above 0 closes).

    ## Observation space
    The raw data of section 4.2.2, a `Dict`:

    | key | space | meaning |
    |---|---|---|
    | proximity | Box(0, 1023, (6,), int64) | the six front infra-reds, from the left |
    | arm | Box(215, 255, (1,), int64) | position of the arm |
    | jaw | Box(0, 200, (1,), int64) | 200 open, 0 closed |
    | object_presence | Discrete(2) | 1 while the optical barrier is interrupted |
    | pose | Box((3,), float64) | x, y in pixels of 5 mm, orientation in degrees 0..359 |
    | tracked | Discrete(2) | whether the camera sees the robot now; otherwise the pose is the last one seen |
    | food_seen | Discrete(2) | whether there is a candidate food |
    | food | Box((2,), float64) | x, y of the nearest candidate in pixels; zeros without one |
    | food_type | Discrete(4) | 0 unknown, 1 pickable, 2 pushable, 3 poisonous |
    | home | Box((3,), float64) | x, y of the centre and radius in pixels |
    | wall | Box((2,), float64) | distance in pixels and bearing in degrees of the nearest wall |

    ## Rewards, starting state, episode end, info, arguments
    Those of `BehavioursEnv`. A step is correct when the motors, as applied, are those that the teacher's behaviour
    commands on the same raw data.

    ## Version history
    v0: first version.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)  # type: ignore[assignment]
        flag = 2
        place = 2000.0
        """Pixels: further than any camera sees."""
        self.observation_space = spaces.Dict(
            proximity=spaces.Box(0, 1023, (6,), np.int64),
            arm=spaces.Box(ARM_RAISED, ARM_DOWN, (1,), np.int64),
            jaw=spaces.Box(JAW_CLOSED, JAW_OPEN, (1,), np.int64),
            object_presence=spaces.Discrete(flag),
            pose=spaces.Box(
                np.array((-place, -place, 0.0)), np.array((place, place, 360.0)), (3,), np.float64
            ),
            tracked=spaces.Discrete(flag),
            food_seen=spaces.Discrete(flag),
            food=spaces.Box(-place, place, (2,), np.float64),
            food_type=spaces.Discrete(4),
            home=spaces.Box(-place, place, (3,), np.float64),
            wall=spaces.Box(np.array((0.0, -180.0)), np.array((place, 180.0)), (2,), np.float64),
        )

    def _motors(self, action: NDArray[np.float64], forager: Forager) -> Motors:
        left, right, arm, jaw = motor_action(action).tolist()
        self._executed = None
        return Motors(
            left * MAX_SPEED,
            right * MAX_SPEED,
            round((ARM_DOWN + ARM_RAISED) / 2 - arm * (ARM_DOWN - ARM_RAISED) / 2),
            JAW_CLOSED if jaw > 0 else JAW_OPEN,
        )

    def _is_correct(self, motors: Motors, forager: Forager) -> bool:
        from khepera_forage.robots.khepera import applicable

        return applicable(motors) == applicable(forager.motors_for(forager.correct_behaviour))

    def _observation(self, forager: Forager) -> Observation:
        raw = forager.raw
        return {
            "proximity": np.array(raw.proximity),
            "arm": np.array((raw.arm,)),
            "jaw": np.array((raw.jaw,)),
            "object_presence": np.int64(raw.object_presence != 0),
            "pose": np.array((raw.x, raw.y, float(raw.orientation))),
            "tracked": np.int64(raw.tracked),
            "food_seen": np.int64(raw.food_seen),
            "food": np.array((raw.food_x, raw.food_y)),
            "food_type": np.int64(raw.food_type),
            "home": np.array((raw.home_x, raw.home_y, float(raw.home_radius))),
            "wall": np.array((raw.wall_distance, raw.wall_bearing)),
        }
