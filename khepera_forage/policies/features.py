"""Observations: their spaces, and features, which are rows of numbers about -1..1 for networks and other learners."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from khepera_forage.policies.distance import ARM_SPAN, CORRIDOR_DIAGONAL, STATE_WIDTH
from khepera_forage.policies.policy import Observation, state_vector_of
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN
from khepera_forage.task.states import FoodType, StateVector

BEHAVIOUR_FEATURES = 9
WHEELS_FEATURES = 25
INFRA_REDS = 6
MAX_PROXIMITY = 1023.0


def state_vector_space(diagonal: int) -> spaces.Dict:
    """The space of state vectors (4.3), whose longest distance is `diagonal` pixels."""
    return spaces.Dict(
        object_presence=spaces.Discrete(2),
        robot_home_distance=spaces.Box(0, diagonal, (1,), np.int64),
        food_type=spaces.Discrete(len(FoodType)),
        arms_height=spaces.Box(ARM_RAISED, ARM_DOWN, (1,), np.int64),
        robot_food_distance=spaces.Box(0, diagonal, (1,), np.int64),
    )


def raw_data_space() -> spaces.Dict:
    """The space of raw data (4.2.2)."""
    place = 2000.0  # pixels: further than any camera sees
    return spaces.Dict(
        proximity=spaces.Box(0, 1023, (6,), np.int64),
        arm=spaces.Box(ARM_RAISED, ARM_DOWN, (1,), np.int64),
        jaw=spaces.Box(JAW_CLOSED, JAW_OPEN, (1,), np.int64),
        object_presence=spaces.Discrete(2),
        pose=spaces.Box(np.array((-place, -place, 0.0)), np.array((place, place, 360.0)), (3,), np.float64),
        tracked=spaces.Discrete(2),
        food_seen=spaces.Discrete(2),
        food=spaces.Box(-place, place, (2,), np.float64),
        food_type=spaces.Discrete(len(FoodType)),
        home=spaces.Box(-place, place, (3,), np.float64),
        wall=spaces.Box(np.array((0.0, -180.0)), np.array((place, 180.0)), (2,), np.float64),
    )


def encoded(vectors: NDArray[Any] | Sequence[Any], diagonal: int) -> NDArray[np.float64]:
    """State vectors for learners that calculate: categories one-hot at half weight, numbers scaled.

    Between encoded vectors the Manhattan distance is that of section 4.6.1.

    Args:
        vectors: Of shape (n, 5).
        diagonal: What the two distances are divided by, in pixels.

    Returns:
        Of shape (n, 9): two columns for ObjectPresence, four for FoodType (0 or 0.5 each), then ArmsHeight by 55,
        RobotHomeDistance and RobotFoodDistance by the diagonal.

    Raises:
        ValueError: There are not five columns.
    """
    rows = np.asarray(vectors, np.float64)
    if rows.ndim != 2 or rows.shape[1] != STATE_WIDTH:
        raise ValueError(f"vectors have shape {rows.shape}; allowed: (n, {STATE_WIDTH})")
    presence, home, food_type, arm, food = rows.T[..., None]
    return np.concatenate(
        (
            0.5 * (presence == np.arange(2)),
            0.5 * (food_type == np.arange(len(FoodType))),
            (arm - ARM_RAISED) / ARM_SPAN,
            home / diagonal,
            food / diagonal,
        ),
        axis=1,
    )


def behaviour_features(shown: Observation) -> NDArray[np.float32]:
    """State vectors in observations, of shape (n, 9); see `encoded`.

    Args:
        shown: One observation, see `policies.policy.state_vector_of`, or those of a vector environment.
    """
    if not isinstance(shown, Mapping):
        return state_vector_features(np.array([state_vector_of(shown)]))
    return state_vector_features(np.hstack([_column(shown, key, 1) for key in StateVector._fields]))


def state_vector_features(vectors: NDArray[Any]) -> NDArray[np.float32]:
    """State vectors of shape (n, 5), encoded as `behaviour_features` are."""
    return encoded(vectors, CORRIDOR_DIAGONAL).astype(np.float32)


def wheels_features(shown: Mapping[str, Any]) -> NDArray[np.float32]:
    """Observations of `CorridorWheels-v1` and `RectangleWheels-v1`, with places relative to the robot.

    Args:
        shown: One observation, or those of a vector environment; one `home` may serve all.

    Returns:
        Of shape (n, 25): six infra-reds, arm, jaw, object presence, tracked, food seen; four columns of food type;
        food ahead, to the left, distance; home ahead, to the left, distance; distance from the wall, cosine and sine
        of its bearing; whether at home.

    Raises:
        ValueError: Part of the raw data is missing.
    """
    pose, food, home = _column(shown, "pose", 3), _column(shown, "food", 2), _column(shown, "home", 3)
    seen, wall = _column(shown, "food_seen", 1), _column(shown, "wall", 2)
    heading, bearing = np.radians(pose[:, 2]), np.radians(wall[:, 1])
    home_part = _ahead(home[:, :2] - pose[:, :2], heading)
    parts = (
        _column(shown, "proximity", INFRA_REDS) / MAX_PROXIMITY,
        (_column(shown, "arm", 1) - 215) / 40,
        _column(shown, "jaw", 1) / 200,
        _column(shown, "object_presence", 1),
        _column(shown, "tracked", 1),
        seen,
        _column(shown, "food_type", 1) == np.arange(len(FoodType)),
        _ahead(food - pose[:, :2], heading) * seen,
        home_part,
        wall[:, :1] / CORRIDOR_DIAGONAL,
        np.column_stack((np.cos(bearing), np.sin(bearing))),
        home_part[:, 2:] * CORRIDOR_DIAGONAL <= home[:, 2:],
    )
    return np.concatenate(parts, axis=1, dtype=np.float32, casting="unsafe")


def _ahead(apart: NDArray[np.float64], heading: NDArray[np.float64]) -> NDArray[np.float64]:
    """Place `apart` from the robot in the camera's picture: ahead of it, to its left, and its distance."""
    cosine, sine = np.cos(heading), np.sin(heading)
    x, y = apart.T
    return np.column_stack((x * cosine + y * sine, y * cosine - x * sine, np.hypot(x, y))) / CORRIDOR_DIAGONAL


def _column(shown: Mapping[str, Any], key: str, width: int) -> NDArray[Any]:
    """One part of the observations, one row an environment."""
    if key not in shown:
        raise ValueError(f"observation lacks {key!r}, it has {list(shown)}")
    return np.asarray(shown[key]).reshape(-1, width)
