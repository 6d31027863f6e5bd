"""`CorridorWheels-v1` and `RectangleWheels-v1`: forage alone by commanding motors."""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.envs.arguments import motor_action
from khepera_forage.envs.forager import Forager
from khepera_forage.envs.recall import Observation, RecallEnv
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    JAW_CLOSED,
    JAW_OPEN,
    Motors,
    applicable,
)
from khepera_forage.task.behaviours import decode_motors
from khepera_forage.task.states import FoodType


class WheelsEnv(RecallEnv[NDArray[np.float64]]):
    """Forage alone, commanding wheels, arm and jaw at every step.

    ## Description
    The task of `Corridor-v1` and `Rectangle-v1` one level down: raw data in, motors out, so that the behaviours too
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
    - v1: the default of `decisions` is `Decisions()`, as in this class: inferred from the thesis's corridor tables
      (`docs/decisions.md`).
    - v0: first version. The default of `decisions` is `Decisions.v0_1()`: those of version 0.1 of the package.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)  # type: ignore[assignment]
        flag = 2
        place = 2000.0  # pixels: further than any camera sees
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
            food_type=spaces.Discrete(len(FoodType)),
            home=spaces.Box(-place, place, (3,), np.float64),
            wall=spaces.Box(np.array((0.0, -180.0)), np.array((place, 180.0)), (2,), np.float64),
        )

    def _motors(self, action: NDArray[np.float64], forager: Forager) -> Motors:
        self._executed = None
        return decode_motors(*motor_action(action).tolist())

    def _is_correct(self, motors: Motors, forager: Forager) -> bool:
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
