"""`Decisions`: everything that the thesis leaves open, each decision with its default and the reason for it.

`Noise` describes devices; `Decisions` describes how we read the thesis. Every rule of the task takes its numbers from
here at run time, so that a decision can be changed in one place, for every backend.

The defaults were inferred from the thesis's tables of the corridor (docs/decisions.md). Where these say
nothing, the defaults are those of version 0.1 (`task.decision_versions`), which were chosen with the teacher alone.
"""

import dataclasses
import numbers
from collections import namedtuple
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from khepera_forage.task.decision_versions import CURRENT, V0_1


class Field(NamedTuple):
    """What is known of one field of `Decisions`.

    Attributes:
        kind: `float`, `int` or `str`.
        unit: Of a number; empty for a choice.
        least: Smallest allowed number.
        most: Largest allowed number.
        choices: The named alternatives of a choice.
        section: Of the thesis, where it leaves this open.
        reason: What the field means, and why it has its default.
        name: Of the field.
    """

    kind: type
    unit: str
    least: float
    most: float
    choices: tuple[str, ...]
    section: str
    reason: str
    name: str = ""

    @property
    def allowed(self) -> str:
        """The allowed values, for people."""
        if self.choices:
            return ", ".join(map(repr, self.choices))
        kind = "a whole number" if self.kind is int else "a number"
        return f"{kind} from {self.least:g} to {self.most:g} {self.unit}"

    def checked(self, value: Any) -> Any:
        """An allowed value, as a plain `float`, `int` or `str`.

        Raises:
            ValueError: The value is not allowed.
        """
        if self.choices:
            fine = isinstance(value, str) and value in self.choices
        else:
            kind: Any = numbers.Integral if self.kind is int else numbers.Real
            # NaN fails the comparison.
            fine = isinstance(value, kind) and not isinstance(value, bool) and self.least <= value <= self.most
        if not fine:
            raise ValueError(f"decision {self.name} is {value!r}; allowed: {self.allowed}")
        return self.kind(value)

    def parse(self, text: str) -> Any:
        """A value that was given as text; what cannot be read is returned as text, for `checked` to refuse."""
        try:
            return self.kind(text)
        except ValueError:
            return text

    def as_number(self, value: Any) -> float:
        """A value as rules take it."""
        return float(self.choices.index(value)) if self.choices else float(value)


def _number(default: float, least: float, most: float, unit: str, section: str, reason: str) -> Any:
    return _field(default, Field(type(default), unit, least, most, (), section, reason))


def _choice(default: str, choices: tuple[str, ...], section: str, reason: str) -> Any:
    return _field(default, Field(str, "", 0.0, 0.0, choices, section, reason))


def _field(default: Any, known: Field) -> Any:
    return dataclasses.field(default=default, metadata={"decision": known})


@dataclass(frozen=True, slots=True)
class Decisions:
    """How this package reads what the thesis leaves open.

    Distances between regions are in pixels of 5 mm, as in the thesis; what lies on the floor is in mm; speeds are in
    units of 8 mm/s. The first value of a field is its default.

    Raises:
        ValueError: A value out of range or of the wrong type; the message quotes the value and what is allowed.
    """

    # Time.
    round_duration: float = _number(
        0.1, 0.05, 0.5, "s", "4.5", "Length of a round (MultiStep). The commands of all robots take effect together."
    )
    arm_travel_time: float = _number(
        0.1, 0.1, 2.0, "s", "4.2.2", "Time the arm takes between down (255) and raised (215)."
    )
    jaw_travel_time: float = _number(
        0.6, 0.1, 2.0, "s", "4.2.2", "Time the jaw takes between open (200) and closed (0)."
    )

    # The set-up of figure 5.1, whose picture did not survive. The start was chosen by hand: at 90 mm, as in version
    # 0.1, trainings without noise never ended on the pymunk of version 0.2.
    start_to_wall: float = _number(100.0, 60.0, 200.0, "mm", "5.2", "From the robot's start to the wall behind it.")
    food_to_home: float = _number(160.0, 120.0, 300.0, "mm", "5.2", "From the food to the centre of the home.")
    home_to_wall: float = _number(80.0, 50.0, 150.0, "mm", "5.2", "From the home's centre to the wall behind it.")
    home_radius: float = _number(80.0, 50.0, 110.0, "mm", "4.2.2", 'Radius of the home, "known to the robot".')
    start_aside: float = _number(
        0.0, -60.0, 60.0, "mm", "5.2", "From the arena's middle line to the start, towards the left wall."
    )
    food_aside: float = _number(0.0, -60.0, 60.0, "mm", "5.2", "From the middle line to the food, likewise.")
    home_aside: float = _number(0.0, -60.0, 60.0, "mm", "5.2", "From the middle line to the home, likewise.")

    # What the camera shows.
    food_beside_robot: str = _choice(
        "seen at its last place",
        ("seen at its last place", "unseen", "unseen until the arm is down"),
        "4.2.2",
        "Food that the tracker has lost, such as food under the robot's marker.",
    )
    redetection_time: float = _number(
        0.0, 0.0, 10.0, "s", "4.2.2", "From losing food until it is unseen, if lost food becomes unseen."
    )
    distances: str = _choice(
        "straight",
        ("straight", "along the path"),
        "4.3",
        "RobotHomeDistance and RobotFoodDistance where walls stand between.",
    )
    no_food_distance: str = _choice(
        "last one known",
        ("diagonal of the arena", "last one known"),
        "4.3",
        "RobotFoodDistance while there is no candidate food; the diagonal if any is known to be poisonous.",
    )
    held_food: str = _choice(
        "candidate in the gripper",
        ("candidate at its last place", "no candidate", "candidate in the gripper", "hides all food"),
        "4.3",
        "How food in the gripper counts for RobotFoodDistance.",
    )

    # States (tables 4.1, 4.2; figure 4.2).
    next_to_food: float = _number(
        15.0, 10.0, 30.0, "pixels", "4.2.1", "RobotNextToFoodThreshold: nearer, ORIENT begins."
    )
    close_to_food: float = _number(40.0, 20.0, 60.0, "pixels", "4.2.1", "RobotCloseToFoodThreshold.")
    equal_distance: str = _choice(
        "nearer state",
        ("nearer state", "farther state"),
        "4.2.1",
        "State at a distance that equals a threshold, which matches no row of table 4.2.",
    )
    carry_margin: float = _number(
        10.0, 0.0, 30.0, "arm positions", "4.2.1", "Above raised (215), up to which an arm counts as raised (fig. 4.2)."
    )

    # What the behaviours command (4.2): speeds of the wheels.
    search_speed: float = _number(12.0, 4.0, 20.0, "speed units", "4.2", "SEARCH FOR FOOD.")
    home_speed: float = _number(8.0, 4.0, 20.0, "speed units", "4.2", "GO HOME.")
    slow_speed: float = _number(
        5.5, 2.0, 20.0, "speed units", "4.2", "MOVE SLOWLY, AVOID FOOD, AVOID HOME, RELEASE FOOD."
    )
    push_speed: float = _number(8.0, 2.0, 20.0, "speed units", "4.2.3", "PUSH FOOD.")
    orient_speed: float = _number(4.0, 1.0, 12.0, "speed units", "4.2", "ORIENT WITH FOOD, on towards the barrier.")
    lowering_speed: float = _number(
        1.5,
        0.0,
        12.0,
        "speed units",
        "4.2",
        "ORIENT WITH FOOD, back from food too near for the arm to come down; a faster robot can leave its state.",
    )
    retreat_speed: float = _number(7.0, 1.0, 12.0, "speed units", "4.2", "Backwards, off food and out of the home.")
    circle_speed: float = _number(
        1.5, 0.0, 12.0, "speed units", "4.2", "Mean speed of SEARCH with no food in sight, in a small circle."
    )
    turn_speed: float = _number(
        5.0, 1.0, 12.0, "speed units", "4.2", "Each wheel, in a turn on the spot of up to 70 degrees."
    )
    quick_turn_speed: float = _number(8.0, 1.0, 20.0, "speed units", "4.2", "The same, in a larger turn.")

    # How the behaviours orient and carry (3.4, 3.7, 4.2).
    searching_arm: str = _choice("raised", ("raised",), "4.2", "The arm while searching; ORIENT WITH FOOD lowers it.")
    search_without_food: str = _choice(
        "small circle",
        ("small circle", "wander"),
        "4.2",
        "SEARCH with no food in sight; wandering is straight on, off walls.",
    )
    beside_food: str = _choice(
        "back off",
        ("back off", "turn away", "drive on"),
        "4.2",
        "SEARCH and MOVE SLOWLY near food. The infra-reds turn them away, unless they back off or drive on.",
    )
    back_off_distance: float = _number(
        16.0, 0.0, 20.0, "pixels", "4.2", "Distance to food from which SEARCH and MOVE SLOWLY do not shove it."
    )
    orienting: str = _choice(
        "lowered before food",
        ("lowered before food", "lowered over food"),
        "3.7",
        "ORIENT lowers the arm clear of the food, backing off if need be, or the open fingers around it.",
    )
    arm_after_orienting: str = _choice(
        "raised", ("raised", "as it is"), "4.2", "The arm in MOVE SLOWLY while it is still down after ORIENT."
    )
    aimed: float = _number(5.0, 1.0, 15.0, "degrees", "3.7", "Off the food, within which a robot counts as oriented.")
    astray: float = _number(
        20.0, 10.0, 90.0, "degrees", "3.7", "Off the food, beyond which ORIENT raises the arm to turn."
    )
    missed_distance: float = _number(
        10.0, 5.0, 15.0, "pixels", "3.7", "Nearer food is in the gripper, or the try was missed and ORIENT backs off."
    )
    release_depth: float = _number(
        7.0, 0.0, 15.0, "pixels", "4.2", "Inside the rim of the home, where food is released."
    )

    # Following (4.5.2).
    same_place: float = _number(2.0, 0.0, 10.0, "pixels", "4.5.2", "Within this, the learner is where the teacher is.")
    same_heading: float = _number(8.0, 0.0, 45.0, "degrees", "4.5.2", "Within this, both go in the same direction.")
    separation: float = _number(14.0, 5.0, 40.0, "pixels", "4.5.2", 'Beyond this, they are "significantly apart".')
    recovery_speed: float = _number(6.0, 1.0, 12.0, "speed units", "4.5.2", "Of a separated learner that catches up.")
    following_gain: float = _number(0.1, 0.01, 1.0, "speed units/degree", "4.5.2", "Of the arc towards the teacher.")
    patience: int = _number(
        100, 1, 10_000, "rounds", "5.3.1", "Of separation, after which a training attempt is given up."
    )
    most_attempts: int = _number(
        200, 1, 100_000, "attempts", "5.2", "At a training episode, after which it is hopeless."
    )
    rounds_after_training: int = _number(
        0, 0, 200, "rounds", "5.3", "From the delivery until the operator ends a training episode."
    )
    poison_in_training: str = _choice(
        "left with the arm raised",
        ("left with the arm raised",),
        "5.3",
        "When an episode with poisonous food is complete.",
    )

    # The learner (4.6.1).
    distance_arithmetic: str = _choice(
        "exact",
        ("exact", "32-bit floats", "64-bit floats"),
        "4.6.1",
        "Of the distance between state vectors: sums of floats can differ where exact ones are equal.",
    )

    # Placement (5.4.1.1: "random in every recall episode").
    food_to_walls: float = _number(
        50.0, 20.0, 100.0, "mm", "5.4.1.1", "From random food to the walls: the gripper fits."
    )
    food_spacing: float = _number(100.0, 40.0, 200.0, "mm", "5.4.2.1", "Between the centres of random food objects.")

    # Devices.
    recall_marker: int = _number(2, 1, 2, "holes", "3.5", "Of the marker of a robot that forages alone.")

    def __post_init__(self) -> None:
        for name, field in FIELDS.items():
            object.__setattr__(self, name, field.checked(getattr(self, name)))
        if self.home_radius > self.home_to_wall:
            raise ValueError(
                f"decision home_radius is {self.home_radius!r}; allowed: at most home_to_wall, {self.home_to_wall!r}"
            )
        if self.close_to_food < self.next_to_food:
            raise ValueError(
                f"decision close_to_food is {self.close_to_food!r}; allowed: at least next_to_food, "
                f"{self.next_to_food!r}"
            )

    @classmethod
    def v0_1(cls) -> Self:
        """The decisions of version 0.1, whatever the defaults are now."""
        return cls(**V0_1)

    @classmethod
    def from_changes(cls, changes: Mapping[str, Any], base: Self | None = None) -> Self:
        """The decisions that differ from others in these fields.

        Args:
            changes: Values by the names of their fields.
            base: The others; the defaults if left out.

        Raises:
            ValueError: An unknown field, or a value out of range.
        """
        for name in changes:
            if name not in FIELDS:
                raise ValueError(f"decision {name!r} is unknown; allowed: {', '.join(sorted(FIELDS))}")
        return dataclasses.replace(cls() if base is None else base, **changes)

    @classmethod
    def parse(cls, assignments: Sequence[str], base: Self | None = None) -> Self:
        """The decisions that assignments such as `next_to_food=22` describe.

        Args:
            assignments: Texts of the form NAME=VALUE, as the command line's `--decision` takes them.
            base: The decisions that they change; the defaults if left out.

        Raises:
            ValueError: Not of this form, an unknown or repeated field, or a value out of range.
        """
        changes: dict[str, Any] = {}
        for assignment in assignments:
            name, sign, text = assignment.partition("=")
            if not sign:
                raise ValueError(f"decision {assignment!r}; allowed: NAME=VALUE, such as next_to_food=22")
            if name in changes:
                raise ValueError(f"decision {name} is set twice; allowed: once")
            changes[name] = FIELDS[name].parse(text) if name in FIELDS else text
        return cls.from_changes(changes, base)

    def differing(self, other: Self) -> dict[str, tuple[Any, Any]]:
        """Fields in which two sets of decisions differ: name to this set's value and the other's."""
        pairs = {name: (getattr(self, name), getattr(other, name)) for name in FIELDS}
        return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}

    def changed(self) -> dict[str, Any]:
        """Fields that differ from the defaults, with their values."""
        return {name: own for name, (own, _) in self.differing(type(self)()).items()}

    def values(self, has_gripper: bool = True) -> "DecisionValues":
        """The decisions as rules take them: numbers, and for a choice its position among the alternatives.

        Args:
            has_gripper: Whether the robot can pick up food: the rules take this with the decisions.
        """
        values: list[Any] = [field.as_number(getattr(self, name)) for name, field in FIELDS.items()]
        return DecisionValues(*values, has_gripper)  # type: ignore[call-arg] # a named tuple


FIELDS: Mapping[str, Field] = {
    field.name: field.metadata["decision"]._replace(name=field.name) for field in dataclasses.fields(Decisions)
}
"""The fields of `Decisions` by their names, in their order."""

if TYPE_CHECKING:

    class DecisionValues(Decisions):
        """`Decisions` as numbers, and what the robot can do."""

        has_gripper: bool

else:
    DecisionValues = namedtuple("DecisionValues", (*FIELDS, "has_gripper"))
    """`Decisions` as numbers, in the same order: what rules take."""

DEFAULT_DECISIONS = Decisions()
DEFAULT_VALUES = DEFAULT_DECISIONS.values()


def _numbers_of(name: str) -> Any:  # rules compare the numbers with fields that mypy takes for text
    return tuple(map(float, range(len(FIELDS[name].choices))))


# The named alternatives of decisions as numbers, in the order of the field: what rules compare a decision with.
NEARER_STATE, FARTHER_STATE = _numbers_of("equal_distance")
SEEN_AT_LAST_PLACE, UNSEEN, UNSEEN_UNTIL_ARM_DOWN = _numbers_of("food_beside_robot")
STRAIGHT, ALONG_PATH = _numbers_of("distances")
DIAGONAL, LAST_DISTANCE = _numbers_of("no_food_distance")
AT_LAST_PLACE, NO_CANDIDATE, IN_GRIPPER, HIDES_ALL_FOOD = _numbers_of("held_food")
SMALL_CIRCLE, WANDER = _numbers_of("search_without_food")
BACK_OFF, TURN_AWAY, DRIVE_ON = _numbers_of("beside_food")
LOWERED_BEFORE_FOOD, LOWERED_OVER_FOOD = _numbers_of("orienting")
RAISED, AS_IT_IS = _numbers_of("arm_after_orienting")
EXACT, FLOATS_32, FLOATS_64 = _numbers_of("distance_arithmetic")


_SEPARATOR = ";"
_FIRST = "v0.1"
VERSIONS = {_FIRST: Decisions.v0_1(), CURRENT: DEFAULT_DECISIONS}
"""All versions by name, the oldest first."""
_ALLOWED = ", ".join(map(repr, VERSIONS))


def decisions_text(decisions: Decisions) -> str:
    """The version that differs least, the oldest of several, and the fields that differ from it."""
    changes = {name: decisions.differing(version) for name, version in VERSIONS.items()}
    nearest = min(changes, key=lambda name: len(changes[name]))
    return _SEPARATOR.join((nearest, *(_assignment(name, own) for name, (own, _) in changes[nearest].items())))


def decisions_from_text(text: str) -> Decisions:
    """The decisions that a text of `decisions_text` describes.

    Raises:
        ValueError: Not of this form, an unknown version or field, or a value that is not allowed.
    """
    base, assignments = _split(text.split(_SEPARATOR) if text else [], _FIRST)
    decisions = Decisions.parse(assignments, base)
    for assignment in assignments:
        name = assignment.partition("=")[0]
        expected = _assignment(name, getattr(decisions, name))
        if assignment != expected:  # such as ' 17', '1_7' or '17.0', which Python reads as the same number
            raise ValueError(f"decision {assignment!r}; allowed: {expected!r}")
    return decisions


def decisions_from_words(words: Sequence[str]) -> Decisions:
    """The decisions that a user wrote on a command line.

    Args:
        words: First the name of a version, or nothing for the defaults; then assignments such as `next_to_food=22`.

    Raises:
        ValueError: An unknown version, or as for `Decisions.parse`.
    """
    base, assignments = _split(words, CURRENT)
    return Decisions.parse(assignments, base)


def differences(decisions: Decisions, other: Decisions) -> str:
    """The fields in which two sets differ, with both values, for error messages."""
    return "; ".join(
        f"{name} is {_value_text(own)}, not {_value_text(others)}"
        for name, (own, others) in decisions.differing(other).items()
    )


def _split(words: Sequence[str], version: str) -> tuple[Decisions, Sequence[str]]:
    """The version that the first word names, by default another one, and the remaining words."""
    if words and words[0].startswith("v") and "=" not in words[0]:
        version, *words = words
        if version not in VERSIONS:
            raise ValueError(f"version {version!r} of the decisions is unknown; allowed: {_ALLOWED}")
    return VERSIONS[version], words


def _assignment(name: str, value: Any) -> str:
    return f"{name}={_value_text(value)}"


def _value_text(value: Any) -> str:
    return str(value).removesuffix(".0")


class DecisionRow(NamedTuple):
    """One decision, as text.

    Attributes:
        name: Of the field of `Decisions`.
        default: With its unit.
        allowed: The values that the field accepts.
        section: Of the thesis, where it leaves this open.
        meaning: What the field means, and why it has its default.
    """

    name: str
    default: str
    allowed: str
    section: str
    meaning: str


def decision_table() -> list[DecisionRow]:
    """One row for each field of `Decisions`, in their order."""
    rows = []
    for name, field in FIELDS.items():
        default = getattr(DEFAULT_DECISIONS, name)
        shown = default if field.choices else f"{default:g} {field.unit}"
        allowed = "; ".join(field.choices) if field.choices else f"{field.least:g} to {field.most:g}"
        rows.append(DecisionRow(name, shown, allowed, field.section, field.reason))
    return rows
