"""Fields of `Decisions`: their kinds, units, ranges and reasons, and the check of a value."""

import dataclasses
import numbers
from typing import Any, NamedTuple


class Field(NamedTuple):
    """What is known of one field of `Decisions`.

    Attributes:
        name: Of the field.
        kind: `float`, `int` or `str`.
        unit: Of a number; empty for a choice.
        least: Smallest allowed number.
        most: Largest allowed number.
        choices: What a choice may be.
        section: Of the thesis, where it leaves this open.
        reason: What the field means, and why it has its default.
    """

    name: str
    kind: type
    unit: str
    least: float
    most: float
    choices: tuple[str, ...]
    section: str
    reason: str

    @classmethod
    def of(cls, field: "dataclasses.Field[Any]") -> "Field":
        """That of a dataclass field made by `number`, `count` or `choice`."""
        known: Field = field.metadata["decision"]
        return known._replace(name=field.name)

    @property
    def allowed(self) -> str:
        """The allowed values, for people."""
        if self.choices:
            return ", ".join(map(repr, self.choices))
        kind = "a whole number" if self.kind is int else "a number"
        return f"{kind} from {self.least:g} to {self.most:g} {self.unit}"

    def as_number(self, value: Any) -> float:
        """A value as rules take it."""
        return float(self.choices.index(value)) if self.choices else float(value)


def number(default: float, least: float, most: float, unit: str, section: str, reason: str) -> Any:
    """A decision that is a number."""
    return _field(default, Field("", float, unit, least, most, (), section, reason))


def count(default: int, least: int, most: int, unit: str, section: str, reason: str) -> Any:
    """A decision that is a whole number."""
    return _field(default, Field("", int, unit, least, most, (), section, reason))


def choice(default: str, choices: tuple[str, ...], section: str, reason: str) -> Any:
    """A decision between named readings."""
    return _field(default, Field("", str, "", 0.0, 0.0, choices, section, reason))


def checked(field: Field, value: Any) -> Any:
    """A value that a field allows, as a plain `float`, `int` or `str`.

    Raises:
        ValueError: The field does not allow it.
    """
    if field.choices:
        fine = isinstance(value, str) and value in field.choices
    else:
        kind: Any = numbers.Integral if field.kind is int else numbers.Real
        # NaN fails the comparison.
        fine = isinstance(value, kind) and not isinstance(value, bool) and field.least <= value <= field.most
    if not fine:
        raise ValueError(f"decision {field.name} is {value!r}; allowed: {field.allowed}")
    return field.kind(value)


def parse(field: Field, text: str) -> Any:
    """A value that was given as text; what cannot be read is returned as text, for `checked` to refuse."""
    if field.choices:
        return text
    try:
        return field.kind(text)
    except ValueError:
        return text


def _field(default: Any, known: Field) -> Any:
    return dataclasses.field(default=default, metadata={"decision": known})
