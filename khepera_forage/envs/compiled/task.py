"""The task in every world of a block: commands, perception and the account of an episode."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.envs.compiled import compiled_rules  # noqa: F401 (the first is needed before any kernel)
from khepera_forage.envs.compiled import rows as at
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, Motors, Senses, applicable
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.behaviours import command
from khepera_forage.task.perception import RawData, Site, raw_data, state_vector, way_to_wall
from khepera_forage.task.states import Behaviour, classify

_WAIT = float(Behaviour.WAIT)
_WALL_X, _WALL_Y, _NEAREST = (body.SCRATCH + n for n in range(3))


@inline
def site_of(place: NDArray[np.float64]) -> Site:
    """What a robot knows of its arena; its walls are looked at one by one elsewhere."""
    return Site(
        place[0],
        place[1],
        int(place[2]),
        place[3],
        int(place[4]),
        (place[5], place[6], place[7], place[8]),
        (),
    )


@inline
def raw_of(s: NDArray[np.float64], t: NDArray[np.float64], i: int, site: Site) -> RawData:
    """The raw data of the last round."""
    return RawData(
        (
            int(s[body.PROXIMITY * LANES + i]),
            int(s[(body.PROXIMITY + 1) * LANES + i]),
            int(s[(body.PROXIMITY + 2) * LANES + i]),
            int(s[(body.PROXIMITY + 3) * LANES + i]),
            int(s[(body.PROXIMITY + 4) * LANES + i]),
            int(s[(body.PROXIMITY + 5) * LANES + i]),
        ),
        int(s[body.ARM_READ * LANES + i]),
        int(s[body.JAW_READ * LANES + i]),
        int(s[body.PRESENT * LANES + i]),
        s[body.OWN_X * LANES + i],
        s[body.OWN_Y * LANES + i],
        int(s[body.OWN_DEGREES * LANES + i]),
        s[body.OWN_FOUND * LANES + i] != 0.0,
        t[at.FOOD_SEEN * LANES + i] != 0.0,
        t[at.FOOD_X * LANES + i],
        t[at.FOOD_Y * LANES + i],
        int(t[at.FOOD_TYPE * LANES + i]),
        site.home_x,
        site.home_y,
        site.home_radius,
        site.home_opening,
        t[at.WALL_DISTANCE * LANES + i],
        t[at.WALL_BEARING * LANES + i],
        t[at.HOME_WAY * LANES + i],
        t[at.HOME_BEARING * LANES + i],
        t[at.FOOD_WAY * LANES + i],
        t[at.FOOD_BEARING * LANES + i],
    )


@kernel
def drive(s: NDArray[np.float64], t: NDArray[np.float64], place: NDArray[np.float64]) -> None:
    """What the behaviour decided on commands, for the coming round."""
    site = site_of(place)
    for i in range(LANES):
        motors = command(int(t[at.BEHAVIOUR * LANES + i]), raw_of(s, t, i, site))
        s[body.LEFT * LANES + i], s[body.RIGHT * LANES + i] = motors.left, motors.right
        s[body.ARM_TO * LANES + i], s[body.JAW_TO * LANES + i] = motors.arm, motors.jaw
    # Apart from what differs from lane to lane: this is done for several at once.
    for i in range(LANES):
        left, right = s[body.LEFT * LANES + i], s[body.RIGHT * LANES + i]
        motors = applicable(Motors(left, right, s[body.ARM_TO * LANES + i], s[body.JAW_TO * LANES + i]))
        tell(s, i, motors)


@kernel
def command_motors(
    s: NDArray[np.float64], t: NDArray[np.float64], place: NDArray[np.float64], actions: NDArray[np.float64]
) -> None:
    """Given motors for the coming round, one row of `Motors` a lane.

    The behaviour then reads as the state where they are what the teacher would command, and as WAIT elsewhere.
    """
    site = site_of(place)
    for i in range(LANES):
        given = applicable(Motors(actions[i, 0], actions[i, 1], actions[i, 2], actions[i, 3]))
        right = applicable(command(int(t[at.STATE * LANES + i]), raw_of(s, t, i, site)))
        same = (
            given.left == right.left
            and given.right == right.right
            and given.arm == right.arm
            and given.jaw == right.jaw
        )
        t[at.BEHAVIOUR * LANES + i] = t[at.STATE * LANES + i] if same else _WAIT
        tell(s, i, given)


@inline
def tell(s: NDArray[np.float64], i: int, motors: Motors) -> None:
    """Give a robot its motors; before its first frame it stands as it was put down."""
    new = s[body.NEW * LANES + i] != 0.0
    s[body.LEFT * LANES + i] = 0.0 if new else motors.left
    s[body.RIGHT * LANES + i] = 0.0 if new else motors.right
    s[body.ARM_TO * LANES + i] = ARM_RAISED if new else motors.arm
    s[body.JAW_TO * LANES + i] = JAW_OPEN if new else motors.jaw


@kernel
def remember(s: NDArray[np.float64], t: NDArray[np.float64]) -> None:
    """Keep what the robots sense, before a round."""
    for i in range(LANES):
        t[at.BEFORE_PRESENT * LANES + i] = s[body.PRESENT * LANES + i]
        t[at.BEFORE_ARM * LANES + i] = s[body.ARM_READ * LANES + i]
        t[at.BEFORE_JAW * LANES + i] = s[body.JAW_READ * LANES + i]


@kernel
def perceive(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    t: NDArray[np.float64],
    place: NDArray[np.float64],
    walls: NDArray[np.float64],
) -> None:
    """Raw data, state vector and state, once the register has picked the nearest food and its type.

    Args:
        s: The robots' rows.
        w: The work rows.
        t: The task's rows.
        place: What a robot knows of its arena.
        walls: Its walls as `Site.walls` keeps them, one a row, in pixels.
    """
    site = site_of(place)
    for i in range(LANES):
        w[_NEAREST * LANES + i] = np.inf
    for wall in range(walls.shape[0]):
        x1, y1, ex, ey, squared = (
            walls[wall, 0],
            walls[wall, 1],
            walls[wall, 2],
            walls[wall, 3],
            walls[wall, 4],
        )
        for i in range(LANES):
            dx, dy = way_to_wall(
                s[body.OWN_X * LANES + i], s[body.OWN_Y * LANES + i], x1, y1, ex, ey, squared
            )
            far = dx * dx + dy * dy
            nearer = far < w[_NEAREST * LANES + i]
            w[_NEAREST * LANES + i] = far if nearer else w[_NEAREST * LANES + i]
            w[_WALL_X * LANES + i] = dx if nearer else w[_WALL_X * LANES + i]
            w[_WALL_Y * LANES + i] = dy if nearer else w[_WALL_Y * LANES + i]
    for i in range(LANES):
        senses = Senses(
            (0, 0, 0, 0, 0, 0, 0, 0),
            0,
            0,
            int(s[body.ARM_READ * LANES + i]),
            int(s[body.JAW_READ * LANES + i]),
            int(s[body.PRESENT * LANES + i]),
        )
        raw = raw_data(
            senses,
            s[body.OWN_X * LANES + i],
            s[body.OWN_Y * LANES + i],
            int(s[body.OWN_DEGREES * LANES + i]),
            s[body.OWN_FOUND * LANES + i] != 0.0,
            t[at.FOOD_SEEN * LANES + i] != 0.0,
            t[at.FOOD_X * LANES + i],
            t[at.FOOD_Y * LANES + i],
            int(t[at.FOOD_TYPE * LANES + i]),
            w[_WALL_X * LANES + i],
            w[_WALL_Y * LANES + i],
            site,
        )
        t[at.FOOD_TYPE * LANES + i] = raw.food_type
        t[at.WALL_DISTANCE * LANES + i] = raw.wall_distance
        t[at.WALL_BEARING * LANES + i] = raw.wall_bearing
        t[at.HOME_WAY * LANES + i] = raw.home_distance
        t[at.HOME_BEARING * LANES + i] = raw.home_bearing
        t[at.FOOD_WAY * LANES + i] = raw.food_distance
        t[at.FOOD_BEARING * LANES + i] = raw.food_bearing
        vector = state_vector(raw, site.diagonal)
        t[at.PRESENCE * LANES + i] = vector.object_presence
        t[at.HOME_DISTANCE * LANES + i] = vector.robot_home_distance
        t[at.VECTOR_TYPE * LANES + i] = vector.food_type
        t[at.VECTOR_ARM * LANES + i] = vector.arms_height
        t[at.FOOD_DISTANCE * LANES + i] = vector.robot_food_distance
        t[at.STATE * LANES + i] = classify(vector, site.home_radius).value
