"""Sets of decisions, whichever fields they have: how they differ, and how they are made from changes or from text."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self

from khepera_forage.task.decision_fields import Field, checked, parse


@dataclass(frozen=True, slots=True)
class DecisionSet:
    """What can be done with a set of decisions; its fields are those of the subclass.

    Raises:
        ValueError: A field does not allow its value.
    """

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, checked(Field.of(field), getattr(self, field.name)))

    def differing(self, other: Self) -> dict[str, tuple[Any, Any]]:
        """Fields in which two sets differ: name to this set's value and the other's."""
        pairs = {f.name: (getattr(self, f.name), getattr(other, f.name)) for f in fields(self)}
        return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}

    def changed(self) -> dict[str, Any]:
        """Fields that differ from the defaults, with their values."""
        return {name: own for name, (own, _) in self.differing(type(self)()).items()}

    @classmethod
    def from_changes(cls, changes: Mapping[str, Any], base: Self | None = None) -> Self:
        """The set that differs from another one in these fields.

        Args:
            changes: Values by the names of their fields.
            base: The other set; the defaults if left out.

        Raises:
            ValueError: An unknown field, or a value out of range.
        """
        known = {field.name for field in fields(cls)}
        for name in changes:
            if name not in known:
                raise ValueError(f"decision {name!r} is unknown; allowed: {', '.join(sorted(known))}")
        return replace(cls() if base is None else base, **changes)

    @classmethod
    def parse(cls, assignments: Sequence[str], base: Self | None = None) -> Self:
        """The set that assignments such as `next_to_food=22` describe.

        Args:
            assignments: Texts of the form NAME=VALUE, as the command line's `--decision` takes them.
            base: The set that they change; the defaults if left out.

        Raises:
            ValueError: Not of this form, an unknown or repeated field, or a value out of range.
        """
        changes: dict[str, Any] = {}
        by_name = {field.name: Field.of(field) for field in fields(cls)}
        for assignment in assignments:
            name, sign, text = assignment.partition("=")
            if not sign:
                raise ValueError(f"decision {assignment!r}; allowed: NAME=VALUE, such as next_to_food=22")
            if name in changes:
                raise ValueError(f"decision {name} is set twice; allowed: once")
            changes[name] = parse(by_name[name], text) if name in by_name else text
        return cls.from_changes(changes, base)
