"""Raw data for tests: at random, and on an open floor."""

from typing import Any

from hypothesis import strategies as st

from khepera_forage.geometry.plane import bearing_of, length, turn_to
from khepera_forage.task.perception import RawData

_FOLLOWING = (
    *("home_distance", "home_bearing", "home_path"),
    *("food_distance", "food_bearing", "food_path", "food_waypoint_x", "food_waypoint_y"),
)
"""What `placed` finds."""
_places = st.floats(0.0, 130.0) | st.just(50.0)
raw_data = st.builds(
    RawData,
    proximity=st.tuples(*[st.integers(0, 1023)] * 6),
    arm=st.integers(215, 255),
    jaw=st.integers(0, 200),
    object_presence=st.sampled_from((0, 255)),
    x=_places,
    y=_places,
    orientation=st.integers(0, 359),
    tracked=st.booleans(),
    food_seen=st.booleans(),
    food_x=_places,
    food_y=_places,
    food_type=st.integers(0, 3),
    home_x=_places,
    home_y=_places,
    home_radius=st.integers(1, 40),
    home_opening=st.floats(-180.0, 180.0),
    wall_distance=st.floats(0.0, 60.0),
    wall_bearing=st.floats(-180.0, 180.0),
    **{name: st.just(0.0) for name in _FOLLOWING},
).map(lambda raw: placed(raw))


def placed(raw: RawData, **changes: Any) -> RawData:
    """Raw data with some of it changed, and the distances and bearings that follow."""
    raw = raw._replace(**changes)
    home = raw.home_x - raw.x, raw.home_y - raw.y
    food = (raw.food_x - raw.x, raw.food_y - raw.y) if raw.food_seen else (0.0, 0.0)
    return raw._replace(
        home_distance=length(*home),
        home_path=length(*home),
        home_bearing=turn_to(bearing_of(*home), raw.orientation),
        food_distance=length(*food),
        food_bearing=turn_to(bearing_of(*food), raw.orientation) if raw.food_seen else 0.0,
        food_path=length(*food),
        food_waypoint_x=raw.food_x if raw.food_seen else 0.0,
        food_waypoint_y=raw.food_y if raw.food_seen else 0.0,
    )


OPEN_FLOOR = placed(
    RawData(
        proximity=(0, 0, 0, 0, 0, 0),
        arm=215,
        jaw=200,
        object_presence=0,
        x=50.0,
        y=23.0,
        orientation=0,
        tracked=True,
        food_seen=True,
        food_x=90.0,
        food_y=23.0,
        food_type=0,
        home_x=110.0,
        home_y=23.0,
        home_radius=20,
        home_opening=180.0,
        wall_distance=23.0,
        wall_bearing=90.0,
        **dict.fromkeys(_FOLLOWING, 0.0),
    )
)
"""A robot with its arm up looks along the corridor, at food 40 pixels ahead and the home behind the food."""
