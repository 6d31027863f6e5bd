"""The prior: which laboratories a builder in 2001 could have had, before the thesis's results are looked at.

Every range and every share has a source. Values that are not here are those of version 0.1, under which the
prior was written, or the laboratory's of `Noise`.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

from numpy.random import Generator

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.noise import Noise
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.decisions import FIELDS, Decisions

_TRIES = 10_000
"""Draws after which no laboratory satisfies the rules that connect decisions."""
_SPEEDS = "robot drivers of the time: KSIM2 10, WSU 9, FHV at most 15, NIC-IF 20 units"


class PriorRange(NamedTuple):
    """A number, uniform between two ends, and the source of these."""

    least: float
    most: float
    source: str


class Shares(NamedTuple):
    """The probability of each named alternative, and the source of these."""

    of: Mapping[Any, float]
    source: str


def _equal(source: str, *alternatives: Any) -> Shares:
    return Shares(dict.fromkeys(alternatives, 1.0 / len(alternatives)), source)


class LabModel(NamedTuple):
    """What a replication of the thesis needs to know: how it is read, and how inaccurate its devices and hands are."""

    decisions: Decisions
    noise: Noise


def laboratory_text(laboratory: LabModel) -> str:
    """The text of a laboratory; equal laboratories have equal texts."""
    decisions, noise = laboratory
    return json.dumps({"decisions": asdict(decisions), "noise": asdict(noise)})


def laboratory_from_text(text: str) -> LabModel:
    """The laboratory of a text; decisions that it leaves out are those of version 0.1.

    Raises:
        ValueError: Not of this form, an unknown field, or a value that is not allowed.
    """
    try:
        parts = json.loads(text)
        return LabModel(Decisions.from_changes(parts["decisions"], Decisions.v0_1()), Noise(**parts["noise"]))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{text!r} is no laboratory: {error}") from error


@dataclass(frozen=True, slots=True)
class Prior:
    """Independent distributions of fields of `Decisions` and of `Noise`, by name."""

    decisions: Mapping[str, PriorRange | Shares]
    noise: Mapping[str, PriorRange]

    @property
    def parts(self) -> dict[str, PriorRange | Shares]:
        """What is drawn, by the name of the field, decisions first."""
        return {**self.decisions, **self.noise}

    @property
    def text(self) -> str:
        """Everything that draws depend on."""
        values = {
            name: part[:2] if isinstance(part, PriorRange) else list(part.of.items())
            for name, part in self.parts.items()
        }
        return json.dumps(values)

    def draw(self, rng: Generator) -> LabModel:
        """A random laboratory; sets that break a rule between decisions, or do not fit an arena, are drawn again.

        Raises:
            ValueError: No set satisfies these rules.
        """
        problem = ""
        for _ in range(_TRIES):
            values = {name: _value(part, rng) for name, part in self.decisions.items()}
            sizes = {name: _value(part, rng) for name, part in self.noise.items()}
            try:
                return LabModel(_decisions(values), replace(Noise.laboratory(), **sizes))
            except ValueError as error:
                problem = str(error)
        raise ValueError(f"none of {_TRIES} draws of this prior is possible; the last one: {problem}")


def _decisions(values: Mapping[str, Any]) -> Decisions:
    """Decisions with these values, rounded if they are counts; a ValueError if they contradict each other."""
    whole = {name: round(value) if FIELDS[name].kind is int else value for name, value in values.items()}
    decisions = Decisions.from_changes(whole, Decisions.v0_1())
    for name in THESIS_ARENAS:
        checked_arena(name, decisions)
    if decisions.slow_speed > decisions.search_speed:
        raise ValueError(f"slow_speed is {decisions.slow_speed}; allowed: at most search_speed")
    return decisions


def _value(part: PriorRange | Shares, rng: Generator) -> Any:
    """A random value of one field."""
    if isinstance(part, PriorRange):
        return float(rng.uniform(part.least, part.most))
    return list(part.of)[rng.choice(len(part.of), p=list(part.of.values()))]


PRIOR = Prior(
    decisions={
        "round_duration": PriorRange(
            0.08,
            0.4,
            "a robot's six exchanges are about 120 bytes: 0.14 s at 9600 baud, 0.03 s at 38400, for two robots one "
            "after the other (4.5); a frame takes 0.02 to 0.04 s",
        ),
        "arm_travel_time": PriorRange(
            0.1, 1.0, "WART 0.1 s, KNET and Webots wait 1 s; less than a round is like a round"
        ),
        "jaw_travel_time": PriorRange(0.1, 2.0, "WART 0.1 s, KNET waits 0.6 s, Webots 2 s"),
        "start_to_wall": PriorRange(60, 150, "a robot with its raised gripper at one end of the corridor"),
        "food_to_home": PriorRange(
            120, 300, "outside the home, and before the start, in a corridor of 650 mm"
        ),
        "home_to_wall": PriorRange(50, 150, "a home at the other end, whole within the corridor"),
        "home_radius": PriorRange(
            50, 110, "one food object with the robot in front of it, up to the corridor's width"
        ),
        "start_aside": PriorRange(
            -45, 45, "the picture of figure 5.1 is lost; a gripper's width from the walls"
        ),
        "food_aside": PriorRange(-45, 45, "as the start"),
        "home_aside": PriorRange(-45, 45, "as the start"),
        "food_beside_robot": _equal(
            "4.2.2: covered food is not detected when the camera redetects; not said when it does",
            "seen at its last place",
            "unseen",
            "unseen until the arm is down",
        ),
        "redetection_time": PriorRange(
            0, 5, "0 is at once, in every frame, to a person who starts the redetection"
        ),
        "no_food_distance": _equal("not said", "diagonal of the arena", "last one known"),
        "held_food": _equal(
            "not said",
            "candidate at its last place",
            "no candidate",
            "candidate in the gripper",
            "hides all food",
        ),
        "next_to_food": PriorRange(
            12, 24, "from where the fingers enclose food, to where they just clear it"
        ),
        "close_to_food": PriorRange(22, 50, "beyond next, within half a corridor"),
        "equal_distance": _equal("table 4.2 leaves it out", "nearer state", "farther state"),
        "search_speed": PriorRange(6, 15, _SPEEDS),
        "home_speed": PriorRange(6, 15, _SPEEDS),
        "slow_speed": PriorRange(3, 10, f'"slowly" beside search; {_SPEEDS}'),
        "orient_speed": PriorRange(2, 6, "a tenth of a finger in a control period"),
        "retreat_speed": PriorRange(3, 8, "as MOVE SLOWLY, backwards"),
        "turn_speed": PriorRange(3, 8, "a turn of 5 to 14 degrees in 0.1 s"),
        "quick_turn_speed": PriorRange(5, 12, "a turn of 9 to 21 degrees in 0.1 s"),
        "search_without_food": _equal("4.2: SEARCH FOR FOOD, no more", "small circle", "wander"),
        "beside_food": _equal("not said", "back off", "turn away", "drive on"),
        "back_off_distance": PriorRange(
            10,
            19,
            "from food that touches the body, to the reach of the infra-reds: 50 mm between body and food",
        ),
        "orienting": _equal("3.7 names arm, jaw and barrier", "lowered before food", "lowered over food"),
        "arm_after_orienting": _equal("not said", "raised", "as it is"),
        "aimed": PriorRange(2, 10, "orientations are whole degrees; open fingers leave 10 mm on either side"),
        "astray": PriorRange(15, 45, "beyond aimed; from there a finger sweeps food away"),
        "missed_distance": PriorRange(8, 11, "food that touches the body, to food beyond the barrier"),
        "release_depth": PriorRange(3, 10, "inside the home, so that jitter does not undo it"),
        "rounds_after_training": PriorRange(
            0, 50, "never before the end; an operator who sees that both are done, and stops two robots"
        ),
        "distance_arithmetic": Shares(
            {"32-bit floats": 0.5, "64-bit floats": 0.25, "exact": 0.25},
            'a C program\'s "float number" (4.6.1)',
        ),
        "food_to_walls": PriorRange(40, 60, "the open gripper, 55 mm wide, with its fingers of 4 mm"),
        "recall_marker": _equal("3.5 has both robots' markers", 1, 2),
    },
    noise={
        "placement_error": PriorRange(
            0, 25, '"with a bit of effort a small displacement" (4.5.2): up to a robot\'s radius'
        ),
        "placement_heading_error": PriorRange(0, 15, "as the displacement, by eye"),
        "position_jitter": PriorRange(
            0.05, 0.5, "from our tracker to a bare threshold on an analog picture (docs/tracker.md)"
        ),
    },
)
"""What could have been, by our sources."""
