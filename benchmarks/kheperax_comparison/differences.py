"""What is equal and what is not, according to the source of Kheperax 0.2.0 that the comparison runs."""

from khepera_forage.estimates import Column, Table
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import RADIUS, WHEEL_BASE
from khepera_forage.robots.proximity import REACH
from khepera_forage.sim.world import SUBSTEPS
from kheperax_comparison.theirs import About
from kheperax_comparison.work import FOODS, HELD, ROUNDS, SENSOR_NOISE, TRAVEL, WHEEL_NOISE

EQUAL = f"""## What is equal

- The arena (650 x 600 mm), {len(FOODS)} obstacles in the same places, robots of {RADIUS:g} mm radius, their starts, and
  the commands of their wheels: random whole speed units, each held for {HELD} steps, {ROUNDS} steps an episode.
- A step: both wheels roll for 0.1 s (at most {TRAVEL:g} mm), in one piece where nothing is touched. Then eight sensors
  are read, which point in the same directions and reach at most {REACH:g} mm from the robot's centre.
- Worlds are independent. Each draws its own random numbers for wheels and sensors at every step, even where the noise
  has size 0.
- All cores are used: by a JAX device each, or by a thread each. Compilation and resets do not count."""

_COLUMNS = (Column("aspect"), Column("Kheperax"), Column("compiled bodies"))
_NOTE = (
    "Files in brackets are those of Kheperax. First what only Kheperax does, then what both do differently, then what "
    "only our bodies do."
)


def unequal(about: About) -> Table:
    """What is not equal.

    Args:
        about: Versions and behaviour of Kheperax.
    """
    noise = Noise.laboratory()
    only_theirs = [
        ("bumpers", "two (`simu/robot.py`)", "none"),
        ("reward", "the wheels' energy, at every step (`tasks/main.py`)", "none: bodies only"),
        (
            "sight of obstacles",
            f"intersects each of eight rays with each of {about.segments} segments at every step (`simu/laser.py`); "
            "there are no discs, a cylinder is a square of four segments",
            "four walls and four discs; only obstacles within reach are considered",
        ),
    ]
    differently = [
        (
            "sensor reading",
            "distance to the intersection of a segment with its ray from the robot's centre",
            "0 to 1023: a Khepera's response to the nearest point of each obstacle within 60 degrees of the sensor's "
            "axis, at the sensor's place; whole numbers",
        ),
        (
            "touching a wall",
            "tests the pose before the step, not the one after it: a robot first drives into the wall (here "
            f"{about.into_wall:.1f} mm) and then stays there whatever the command (after ten steps backwards: "
            f"{about.backed_off:.1f} mm; `Robot.move`)",
            f"simulated in {SUBSTEPS} steps of 20 ms: walls stop or turn the robot, and it can drive off again",
        ),
        (
            "free motion",
            "the exact arc",
            "the arc's length in the direction of its middle, with an error below 0.1 mm; near a wall or food, speeds "
            "change up to a fifth of a step late",
        ),
        ("obstacles", "fixed", "are food: robots push them along, against walls and against one another"),
        (
            "noise of the wheels",
            f"normal, {WHEEL_NOISE:g} mm added to each wheel's travel, limited to full speed",
            f"normal, {100 * noise.wheel_slip:g} % of the travel, and a constant {100 * noise.wheel_bias:g} % for each "
            "wheel",
        ),
        (
            "noise of the sensors",
            f"normal, {SENSOR_NOISE:g} mm added to a distance",
            f"uniform, {100 * noise.proximity_gain:g} % of a reading, and a floor of 0 to {noise.proximity_floor}",
        ),
        ("wheel base", f"{2 * RADIUS:g} mm: always the body's width", f"{WHEEL_BASE:g} mm"),
        ("numbers", f"{about.numbers}, XLA's fast math", "float64, no fast math"),
        (
            "cost of a step",
            "the same in every world: vectorised JAX computes both sides of a condition",
            "higher where something is near or touched; robots with random commands touch more than the teacher's",
        ),
        (
            "loop over steps",
            "inside JAX, without Python, except in the line with a call a step",
            "one call of Python a step, which copies the commands of all worlds",
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
        ("encoders", "none", "counted, with slip"),
    ]
    return Table("unequal", "What is not equal", _NOTE, _COLUMNS, [*only_theirs, *differently, *only_ours])
