"""The prior: which laboratories a builder in 2001 could have had, before the thesis's results are looked at.

Every range and every share has a source (`prior.toml`). Values that are not there are those of version 0.1, under which
the prior was written, or the laboratory's of `Noise`.
"""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from importlib import resources
from typing import Any, NamedTuple

from numpy.random import Generator

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.noise import Noise
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.task.decisions import FIELDS, Decisions

TRIES = 1_000
"""Sets that are drawn at most for one laboratory; of those of `PRIOR`, every second one is allowed."""


class PriorRange(NamedTuple):
    """A number, uniform between two ends, and the source of these."""

    least: float
    most: float
    source: str


class Shares(NamedTuple):
    """The probability of each named alternative, and the source of these."""

    of: Mapping[Any, float]
    source: str


class LabModel(NamedTuple):
    """What a replication of the thesis needs to know: how it is read, and how inaccurate its devices and hands are."""

    decisions: Decisions
    noise: Noise


def laboratory_text(laboratory: LabModel) -> str:
    """The text of a laboratory; equal laboratories have equal texts."""
    decisions, noise = laboratory
    return json.dumps({"decisions": asdict(decisions), "noise": asdict(noise)})


def laboratory_from_text(text: str) -> LabModel:
    """The laboratory of such a text."""
    parts = json.loads(text)
    return LabModel(Decisions(**parts["decisions"]), Noise(**parts["noise"]))


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
            ValueError: None of `TRIES` sets is allowed.
        """
        for _ in range(TRIES):
            values = {name: _value(part, rng) for name, part in self.decisions.items()}
            sizes = {name: _value(part, rng) for name, part in self.noise.items()}
            try:
                return LabModel(_decisions(values), replace(Noise.laboratory(), **sizes))
            except ValueError as error:
                reason = error
        raise ValueError(f"none of {TRIES:,} sets that the prior drew is allowed; the last one: {reason}")


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


def _part(source: str, **values: Any) -> Any:
    """A part of the prior, as a line of the file has it."""
    if "range" in values:
        least, most = values["range"]
        return PriorRange(least, most, source)
    equal = values.get("equal", ())
    return Shares(values.get("shares") or dict.fromkeys(equal, 1 / len(equal)), source)


def _read(name: str) -> Prior:
    content = tomllib.loads(resources.files(__package__).joinpath(name).read_text(encoding="utf-8"))
    parts = {kind: {key: _part(**line) for key, line in lines.items()} for kind, lines in content.items()}
    return Prior(**parts)


PRIOR = _read("prior.toml")
"""What could have been, by our sources."""
