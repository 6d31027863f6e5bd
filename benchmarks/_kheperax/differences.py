"""What is equal and what is not, as read in the source of Kheperax 0.2.0 that the comparison runs."""

from _kheperax.theirs import About
from _kheperax.work import FOODS, HELD, ROUNDS, SENSOR_NOISE, TRAVEL, WHEEL_NOISE
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import RADIUS, WHEEL_BASE
from khepera_forage.robots.proximity import REACH
from khepera_forage.sim.pymunk.khepera import SUBSTEPS
from khepera_forage.thesis.tables import Column, Table

EQUAL = f"""## What is equal

- The arena (650 x 600 mm), {len(FOODS)} obstacles in the same places, a robot of {RADIUS:g} mm radius; where each
  robot starts, and what its wheels are told: whole speed units at random, each held for {HELD} steps, {ROUNDS} steps to
  an episode.
- A step: both wheels roll what they are told for 0.1 s (at most {TRAVEL:g} mm), in one go where nothing is touched;
  then everything is sensed anew, by eight sensors that point the same ways and see at most {REACH:g} mm from the
  robot's centre.
- Worlds do not touch one another, and each draws random numbers of its own for wheels and sensors, at every step, also
  where the size of the noise is 0.
- All cores: a JAX device on each, a thread of numba on each. Compiling and putting robots back are not counted.
"""

_COLUMNS = (Column("matter"), Column("Kheperax"), Column("BatchWorld"))
_NOTE = (
    "Files in brackets are Kheperax'. What it does more than ours stands above, then what both do differently, then "
    "what only ours does."
)


def unequal(about: About) -> Table:
    """What is not equal.

    Args:
        about: What Kheperax was seen to do.
    """
    noise = Noise.laboratory()
    more = [
        ("bumpers", "two (`simu/robot.py`)", "none"),
        ("reward", "the wheels' energy, at every step (`tasks/main.py`)", "none: bodies only"),
        (
            "sight of obstacles",
            f"each of eight rays is crossed with each of {about.segments} segments at every step (`simu/laser.py`); "
            "there are no discs, a cylinder is a square of four segments",
            "four walls and four discs; only what is in reach is looked at",
        ),
    ]
    differently = [
        (
            "what a sensor reads",
            "distance to where its ray, from the robot's centre, crosses a segment",
            "0 to 1023: a Khepera's response to the nearest point of each obstacle within 60 degrees of its axis, "
            "from where the sensor sits; whole numbers",
        ),
        (
            "touching a wall",
            "the pose before the step is tested, not the one after it: a robot first drives into the wall (here "
            f"{about.into_wall:.1f} mm), then stays as it is for good, whatever it is told (ten steps backwards: "
            f"{about.backed_off:.1f} mm; `Robot.move`)",
            f"followed in {SUBSTEPS} steps of 20 ms: walls hold the robot back or turn it, and it drives off again",
        ),
        (
            "free motion",
            "the exact arc",
            "the arc's length in the direction of its middle, off by less than 0.1 mm; near a wall or food, speeds "
            "change a fifth of a step late or less",
        ),
        ("obstacles", "stand for ever", "are food: pushed along, held against walls and one another"),
        (
            "noise of the wheels",
            f"normal, {WHEEL_NOISE:g} mm added to each wheel's travel, then cut off at full speed",
            f"normal, {100 * noise.wheel_slip:g} % of the travel, and a lasting {100 * noise.wheel_bias:g} % for each "
            "wheel",
        ),
        (
            "noise of the sensors",
            f"normal, {SENSOR_NOISE:g} mm added to a distance",
            f"uniform, {100 * noise.proximity_gain:g} % of a reading, and a floor of 0 to {noise.proximity_floor}",
        ),
        ("between the wheels", f"{2 * RADIUS:g} mm: always the body's width", f"{WHEEL_BASE:g} mm"),
        ("numbers", f"{about.numbers}, XLA's fast math", "float64, no fast math"),
        (
            "what a step costs",
            "the same in every world: where JAX is vectorised, both sides of a condition are computed",
            "more where something is near or touched; robots driven at random touch more than the teacher's",
        ),
        (
            "the loop over steps",
            "inside JAX, no Python between, but for the line with a call a step",
            "one call of Python a step, which checks and copies the motors of all worlds",
        ),
    ]
    only_ours = [
        (
            "gripper",
            "none: a disc",
            "palm and fingers that touch walls and food; arm, jaw and optical barrier move and are read",
        ),
        (
            "camera",
            "none",
            "takes a frame at every step: jitter, losses, reversals, cables, and the tracks of all regions",
        ),
        ("encoders", "none", "counted, slipping or not"),
    ]
    return Table("unequal", "What is not equal", _NOTE, _COLUMNS, [*more, *differently, *only_ours])
