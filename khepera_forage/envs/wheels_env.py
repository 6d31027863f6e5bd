"""`CorridorWheels-v1` and `RectangleWheels-v1`: forage alone by commanding motors."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.envs.arguments import motor_action
from khepera_forage.envs.recall import Observation, RecallEnv
from khepera_forage.policies.features import raw_data_space
from khepera_forage.task.episode import ForagerState


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
        self.observation_space = raw_data_space()

    def _numbers(self, action: NDArray[np.float64]) -> Sequence[float]:
        numbers: list[float] = motor_action(action).tolist()
        return numbers

    def _observation(self, forager: ForagerState) -> Observation:
        return raw_data_of(self._recalls.raw)


def raw_data_of(raw: Any) -> Observation:
    """Raw data as observations have them, in fresh arrays.

    Args:
        raw: A `RawData` record; or an array of them, and each value is an array with one row a world.
    """
    return {
        "proximity": np.array(raw.proximity),
        "arm": np.array((raw.arm,)).T,
        "jaw": np.array((raw.jaw,)).T,
        "object_presence": np.int64(raw.object_presence != 0),
        "pose": np.array((raw.x, raw.y, raw.orientation)).T,
        "tracked": np.int64(raw.tracked),
        "food_seen": np.int64(raw.food_seen),
        "food": np.array((raw.food_x, raw.food_y)).T,
        "food_type": np.int64(raw.food_type),
        "home": np.array((raw.home_x, raw.home_y, raw.home_radius)).T,
        "wall": np.array((raw.wall_distance, raw.wall_bearing)).T,
    }
