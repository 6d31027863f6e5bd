"""Every source of noise, its size, and where the figure comes from.

No figure here was fitted to the thesis's result tables. "Assumption" marks a figure that no source gives.
"""

import math
from dataclasses import dataclass, fields, replace
from numbers import Integral, Real
from typing import Any

from khepera_forage.robots.proximity import MAX_READING

SOURCES: dict[str, tuple[str, ...]] = {
    "wheels": ("wheel_slip", "wheel_bias"),
    "infra-reds": ("proximity_gain", "proximity_floor"),
    "camera jitter": ("position_jitter", "heading_jitter"),
    "reversed orientation": ("reversal_rate",),
    "tracking losses": ("loss_rate_one_hole", "loss_rate_two_holes", "loss_rate_food"),
    "cables": ("cable_loss_factor",),
    "placement": ("placement_error", "placement_heading_error"),
}
"""The fields that belong to each trouble of the laboratory, for experiments that switch them one by one."""

_MOST = dict.fromkeys(
    ("reversal_rate", "loss_rate_one_hole", "loss_rate_two_holes", "loss_rate_food", *SOURCES["wheels"]), 1.0
) | {"proximity_floor": MAX_READING, "position_jitter": 1.0}
"""Largest values; those of the others are 1e9, with which nothing overflows."""
_UNSCALED = ("loss_rounds", "cable_loss_factor")
"""Fields that are no size of an error; at least 1."""


@dataclass(frozen=True, slots=True)
class Noise:
    """The troubles of the laboratory, each with its size; a rate is a probability per round."""

    wheel_slip: float = 0.05
    """Standard deviation of each wheel's travel, as a share of it, drawn every round. KSIM2 draws +-10 %
    uniformly (standard deviation 5.8 %) and ENKI +-5 % (2.9 %); between the two. At most 1: much more
    would carry robots through walls."""
    wheel_bias: float = 0.02
    """Standard deviation of a lasting share by which one wheel travels too far. Assumption: the sources' wheel
    radii differ by 6 % (7.5 to 7.96 mm). At most 1, likewise."""
    proximity_gain: float = 0.1
    """Largest error of an infra-red reading, as a share of it, uniform in both directions (KSIM2, WSU: 10 %)."""
    proximity_floor: float = 6
    """Readings up to this are noise, uniform in 0..this (KSIM2, WSU). At most 1023, the largest reading."""
    position_jitter: float = 0.06
    """Standard deviation of a region's centre in pixels of 5 mm. Measured on rendered frames: a bare threshold is off
    by 0.09 to 0.12, version 0.1 of our tracker was by 0.04 for markers and 0.06 for food, and ours is by 0.03 at most
    (docs/tracker.md). At most 1: a robot at a wall would otherwise be seen outside its arena."""
    heading_jitter: float = 0.35
    """Standard deviation of a marker's orientation in degrees, before it is rounded to whole ones. Measured:
    version 0.1 of our tracker on rendered frames; ours is better, 0.08 (docs/tracker.md)."""
    reversal_rate: float = 0.005
    """Chance that a marker's orientation is reported the wrong way round ("sometimes", 4.2.2). Assumption: the
    thesis's markers did it; ours, whose holes tell front from back, did not in 24,000 (docs/tracker.md)."""
    loss_rate_one_hole: float = 0.001
    """Chance that the tracker loses a one-hole marker. "Once in a while" (5.3.1). Assumption: what caused it (people,
    shadows, the grabber) is not in rendered frames, in which none is lost but under a cable."""
    loss_rate_two_holes: float = 0.002
    """The same for a two-hole marker, which "is lost more frequently" (3.5). Assumption: twice."""
    loss_rate_food: float = 0.001
    """The same for a region without holes. Assumption: as a one-hole marker."""
    loss_rounds: float = 2.0
    """Mean length of a loss in rounds, geometrically distributed. Measured: food under a swaying cable on rendered
    frames, 2.2 with version 0.1 of our tracker; ours has too few losses, a bare threshold 5.1 (docs/tracker.md)."""
    cable_loss_factor: float = 10.0
    """How many times likelier a loss is under a cable (3.7: "more frequent"): food is lost with a chance of 1 % a
    round, by a count on the simulated camera 0.65 % [0.22, 1.9]. On rendered frames a bare threshold loses it with
    8 %, and our tracker lost none (docs/tracker.md)."""
    placement_error: float = 3.0
    """Standard deviation in mm with which an operator puts a robot or food on its mark (4.5.2: "a small
    displacement"). Assumption."""
    placement_heading_error: float = 2.0
    """Standard deviation in degrees of a robot's placed heading. Assumption."""

    def __post_init__(self) -> None:
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            least, most = int(name in _UNSCALED), _MOST.get(name, 1e9)
            if not isinstance(value, Real) or not least <= float(value) <= most:  # NaN fails the comparison
                raise ValueError(f"noise {name} is {value!r}; allowed: a number from {least} to {most:g}")
            object.__setattr__(self, name, int(value) if isinstance(value, Integral) else float(value))

    @classmethod
    def laboratory(cls) -> "Noise":
        """All the troubles of the thesis's laboratory: the default of every environment."""
        return cls()

    @classmethod
    def none(cls) -> "Noise":
        """Perfect wheels, sensors, camera and operator."""
        return cls.only()

    @classmethod
    def only(cls, *sources: str, laboratory: "Noise | None" = None) -> "Noise":
        """The laboratory's figures for these sources and none for the others.

        Args:
            *sources: Keys of `SOURCES`.
            laboratory: Has these figures; `Noise.laboratory()` by default.

        Raises:
            ValueError: A name that is not in `SOURCES`.
        """
        for source in sources:
            if source not in SOURCES:
                raise ValueError(f"noise source {source!r} is unknown; allowed: {', '.join(SOURCES)}")
        quiet = {name: 0 for source in SOURCES.keys() - set(sources) for name in SOURCES[source]}
        if "cable_loss_factor" in quiet:
            quiet["cable_loss_factor"] = 1
        return replace(laboratory or cls.laboratory(), **quiet)

    def scaled(self, share: float) -> "Noise":
        """Errors that are `share` times as large. How long a loss lasts and what a cable adds stay the same.

        Args:
            share: At least 0; errors grow up to what is allowed.

        Raises:
            ValueError: A negative share, or one that is not finite.
        """
        if not isinstance(share, Real) or not 0 <= float(share) < math.inf:
            raise ValueError(f"share of noise is {share!r}; allowed: a finite number >= 0")
        names = [field.name for field in fields(self) if field.name not in _UNSCALED]
        values = {name: min(getattr(self, name) * share, _MOST.get(name, 1e9)) for name in names}
        return replace(self, **values | {"proximity_floor": round(values["proximity_floor"])})


def checked_noise(noise: Any) -> Noise:
    """The noise that a user asked for: a `Noise`, `"laboratory"`, `"none"`, or None for the laboratory's."""
    if isinstance(noise, Noise):
        return noise
    if noise is None or noise == "laboratory":
        return Noise.laboratory()
    if noise == "none":
        return Noise.none()
    raise ValueError(f"noise is {noise!r}; allowed: a Noise, 'laboratory' or 'none'")
