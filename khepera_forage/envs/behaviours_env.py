"""`Corridor-v1` and `Rectangle-v1`: forage alone by choosing behaviours."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.envs.recall import Observation, RecallEnv
from khepera_forage.policies.features import state_vector_space
from khepera_forage.policies.teacher import APPLICABLE
from khepera_forage.task.episode import ForagerState
from khepera_forage.task.states import BEHAVIOURS, NUM_BEHAVIOURS, FoodType, StateVector, behaviour_number

_WHOLE = tuple(np.int64(number) for number in range(len(FoodType)))
"""The values of the discrete parts of an observation: looking one up is ten times as fast as making it."""


class BehavioursEnv(RecallEnv[int]):
    """Forage alone, choosing one of ten behaviours at every step.

    ## Description
    The recall phase of the thesis (4.6, 5.4): a Khepera with a gripper finds food, picks it up or pushes it, brings
    it home, and leaves poison where it is. The behaviours are given (4.2.1); what to do when is what is learned.
    Robot and food stand at random places; the home is at one end. A step is a round.

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
    | robot_food_distance | Box(0, diagonal, (1,), int64) | pixels to the nearest candidate; see `no_food_distance` |

    ## Rewards
    +1 for food delivered, -1 for poison brought home, -1/limit a step.

    ## Starting state
    The robot anywhere outside home, heading uniform; food outside home, further than the close threshold from the
    robot and where a gripper fits around it. `reset(options={"start": (x, y, degrees), "foods": [(x, y), ...]})`
    places them, in mm.

    ## Episode end
    Terminated when all food is delivered or known to be poisonous; truncated after `limit` steps, or when a real robot
    or camera is lost: the robot is then stopped, and the last observation repeated.

    ## Info
    `state`, `correct_behaviour` (what the teacher would do now), `pose` (x, y in pixels, degrees, as the camera
    reports it), `score` (equation 5.1, percent), `penalty`, `correct`, `steps`, `delivered`, `poison_home`; when a
    real robot or camera was lost also `robot_lost`, the reason.

    ## Arguments
    `arena` (an `Arena`, the name of one, or a sequence of both, such as `["corridor", "doors"]`: every episode takes
    place in one of them, drawn at random; distances are then bounded by the largest diagonal), `foods` (number of
    objects, 1 to 16), `limit` (steps), `noise` (a `Noise`, by default the laboratory's), `food_types` (one type, or
    odds by type; by default all PICKABLE), `render_mode`, `world` (another `World` than the simulated one, in whose one
    arena everything then takes place), `decisions` (a `Decisions`: how what the thesis leaves open is read), `backend`
    ("pymunk", or "compiled", which needs numba), `robot` ("khepera", "e-puck2" or "toio": the last two have no gripper,
    and push food, by default all PUSHABLE).

    ## Version history
    - v1: the default of `decisions` is `Decisions()`, as in this class: inferred from the thesis's corridor tables
      (`docs/decisions.md`).
    - v0: first version. The default of `decisions` is `Decisions.v0_1()`: those of version 0.1 of the package.
    """

    _vector: StateVector
    """Of the last observation; a compiled world would have to rebuild the robot's whole record for it."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.action_space = spaces.Discrete(NUM_BEHAVIOURS)  # type: ignore[assignment]
        self.observation_space = state_vector_space(self.largest_diagonal)

    def action_masks(self) -> NDArray[np.bool_]:
        """Which behaviours apply now, for learners that mask actions, such as sb3-contrib's MaskablePPO.

        A behaviour applies if the tree of figure 4.2 can choose it with this object presence and food type, whatever
        the distances and the height of the arm.

        Raises:
            ResetNeeded: Before the first reset.
        """
        self._require_first_reset()
        vector = self._vector
        masks: NDArray[np.bool_] = APPLICABLE[vector.object_presence, vector.food_type].copy()
        return masks

    def _numbers(self, action: int) -> Sequence[float]:
        behaviour = behaviour_number(action, NUM_BEHAVIOURS)
        self._executed = BEHAVIOURS[behaviour]
        return (behaviour,)

    def _observation(self, forager: ForagerState) -> Observation:
        self._vector = forager.vector
        presence, home, food_type, arm, food = forager.vector
        # One fresh array for all three numbers: making an array takes longer than a slice.
        numbers = np.array((home, arm, food))
        return {
            "object_presence": _WHOLE[presence],
            "robot_home_distance": numbers[:1],
            "food_type": _WHOLE[food_type],
            "arms_height": numbers[1:2],
            "robot_food_distance": numbers[2:],
        }
