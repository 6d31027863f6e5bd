"""`Decisions`: every field with its range and reason, and clear errors for what is not allowed."""

import dataclasses
import math
import pickle
from typing import Any

import numpy as np
import pytest

from khepera_forage.task.decision_versions import V0_1
from khepera_forage.task.decisions import DEFAULT_VALUES, FARTHER_STATE, FIELDS, Decisions

NUMBERS = [name for name, field in FIELDS.items() if not field.choices]
COUNTS = [name for name in NUMBERS if FIELDS[name].kind is int]
CHOICES = [name for name, field in FIELDS.items() if field.choices]


def made(name: str, value: Any) -> Decisions:
    return Decisions(**{name: value})


def check_refused(name: str, value: Any) -> None:
    """A value is refused with one error that quotes it and everything that is allowed."""
    with pytest.raises(ValueError, match="allowed") as error:
        made(name, value)
    assert str(error.value) == f"decision {name} is {value!r}; allowed: {FIELDS[name].allowed}"


# ---------------------------------------------------------------- fields


@pytest.mark.parametrize("name", FIELDS)
def test_field_has_section_reason_and_unit(name: str) -> None:
    field = FIELDS[name]
    assert field.section[0] in "345"
    assert field.reason.endswith(".")
    assert bool(field.unit) != bool(field.choices)


@pytest.mark.parametrize("name", NUMBERS)
def test_default_number_is_in_its_range(name: str) -> None:
    field = FIELDS[name]
    default = getattr(Decisions(), name)
    assert field.least <= default <= field.most
    assert type(default) is field.kind


@pytest.mark.parametrize("name", CHOICES)
def test_default_choice_is_allowed(name: str) -> None:
    assert getattr(Decisions(), name) in FIELDS[name].choices


@pytest.mark.parametrize("name", CHOICES)
def test_every_choice_is_accepted(name: str) -> None:
    for choice in FIELDS[name].choices:
        assert getattr(made(name, choice), name) == choice


# A radius beyond `home_to_wall`, and thresholds in the wrong order, have tests of their own.
@pytest.mark.parametrize("name", [n for n in NUMBERS if n not in ("home_radius", "home_to_wall")])
@pytest.mark.parametrize("end", ["least", "most"])
def test_ends_of_the_range_are_accepted(name: str, end: str) -> None:
    value = FIELDS[name].kind(getattr(FIELDS[name], end))
    assert getattr(made(name, value), name) == value


# ---------------------------------------------------------------- refused values


@pytest.mark.parametrize("name", NUMBERS)
def test_number_out_of_range_is_refused(name: str) -> None:
    field = FIELDS[name]
    step = 1 if field.kind is int else 1e-6
    for value in (field.kind(field.least) - step, field.kind(field.most) + step, 10**400):
        check_refused(name, value)


@pytest.mark.parametrize("name", NUMBERS)
def test_number_of_the_wrong_type_is_refused(name: str) -> None:
    values: list[Any] = [math.nan, math.inf, -math.inf, "20", None, True, [20.0], 1j, np.array([20.0, 21.0])]
    for value in values:
        check_refused(name, value)


@pytest.mark.parametrize("name", COUNTS)
@pytest.mark.parametrize("value", [1.5, 1.0])
def test_count_that_is_not_a_whole_number_is_refused(name: str, value: float) -> None:
    check_refused(name, value)


@pytest.mark.parametrize("name", CHOICES)
def test_unknown_choice_is_refused(name: str) -> None:
    values: list[Any] = ["", "something else", 0, None, True, ["raised"], np.array(["raised", "lowered"])]
    for value in values:
        check_refused(name, value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"next_to_food": 25.0, "close_to_food": 24.0},
            "decision close_to_food is 24.0; allowed: at least next_to_food, 25.0",
        ),
        (
            {"home_radius": 101.0, "home_to_wall": 100.0},
            "decision home_radius is 101.0; allowed: at most home_to_wall, 100.0",
        ),
        (
            {"home_radius": 100.0, "home_to_wall": 99.0},
            "decision home_radius is 100.0; allowed: at most home_to_wall, 99.0",
        ),
    ],
)
def test_numbers_that_contradict_each_other_are_refused(changes: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match="allowed") as error:
        Decisions(**changes)  # type: ignore[arg-type]
    assert str(error.value) == message


def test_thresholds_may_be_equal() -> None:
    assert Decisions(next_to_food=25.0, close_to_food=25.0).changed() == {
        "next_to_food": 25.0,
        "close_to_food": 25.0,
    }


# ---------------------------------------------------------------- sets of decisions


@pytest.mark.parametrize(
    ("name", "value", "plain"),
    [
        ("next_to_food", 17, 17.0),
        ("next_to_food", np.float32(17.5), 17.5),
        ("patience", np.int64(7), 7),
        ("equal_distance", np.str_("farther state"), "farther state"),
    ],
)
def test_value_is_stored_as_a_plain_number_or_text(name: str, value: Any, plain: Any) -> None:
    stored = getattr(made(name, value), name)
    assert stored == plain
    assert type(stored) is FIELDS[name].kind


def test_decisions_are_immutable_hashable_and_picklable() -> None:
    decisions = Decisions(next_to_food=17.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        decisions.next_to_food = 18.0  # type: ignore[misc]
    assert decisions == Decisions(next_to_food=17.0) != Decisions()
    assert len({decisions, Decisions(next_to_food=17.0), Decisions()}) == 2
    assert pickle.loads(pickle.dumps(decisions)) == decisions


def test_values_are_numbers_in_the_order_of_the_fields() -> None:
    decisions = Decisions(equal_distance="farther state", patience=7, next_to_food=17)
    values = decisions.values()
    assert values._fields == (*FIELDS, "has_gripper")  # type: ignore[attr-defined]
    assert values.has_gripper is True
    assert all(type(value) is float for value in values[:-1])  # type: ignore[index]
    assert (values.patience, values.next_to_food, values.equal_distance) == (7.0, 17.0, FARTHER_STATE)
    for name in NUMBERS:
        assert getattr(values, name) == getattr(decisions, name)
    for name in CHOICES:
        assert FIELDS[name].choices[int(getattr(values, name))] == getattr(decisions, name)
    assert Decisions().values() == DEFAULT_VALUES


def test_changed_contains_only_what_differs_from_the_defaults() -> None:
    assert Decisions().changed() == {}
    changes = {"next_to_food": 17.0, "held_food": "no candidate", "patience": 7}
    assert Decisions.from_changes(changes).changed() == changes
    assert Decisions(next_to_food=Decisions().next_to_food).changed() == {}


@pytest.mark.parametrize("name", FIELDS)
def test_from_changes_is_the_inverse_of_changed(name: str) -> None:
    field = FIELDS[name]
    for value in field.choices or (getattr(Decisions(), name),):
        decisions = made(name, value)
        assert Decisions.from_changes(decisions.changed()) == decisions


def test_from_changes_refuses_an_unknown_name_and_lists_the_known_ones() -> None:
    with pytest.raises(ValueError, match="decision 'next_to_foot' is unknown; allowed: aimed, ") as error:
        Decisions.from_changes({"next_to_food": 17.0, "next_to_foot": 17.0})
    assert all(name in str(error.value) for name in FIELDS)


def test_from_changes_checks_the_values() -> None:
    with pytest.raises(
        ValueError, match="decision next_to_food is 5; allowed: a number from 10 to 30 pixels"
    ):
        Decisions.from_changes({"next_to_food": 5})


def test_version_0_1_names_every_field_and_no_other() -> None:
    assert list(V0_1) == list(FIELDS)
    assert dataclasses.asdict(Decisions.v0_1()) == dict(V0_1)
    for name, value in V0_1.items():
        assert type(value) is FIELDS[name].kind, name


def test_version_0_1_does_not_follow_the_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    before = Decisions.v0_1()
    *others, _ = (field.default for field in dataclasses.fields(Decisions))
    monkeypatch.setattr(Decisions.__init__, "__defaults__", (*others, 1))
    assert Decisions().recall_marker == 1
    assert Decisions.v0_1() == before


def test_changes_are_relative_to_a_base() -> None:
    base = Decisions(next_to_food=17.0, patience=7)
    assert Decisions.from_changes({"patience": 8}, base) == Decisions(next_to_food=17.0, patience=8)
    assert Decisions.parse(["patience=8"], base) == Decisions(next_to_food=17.0, patience=8)
    assert Decisions.parse([], base) == base


def test_differing_gives_both_values_of_each_field_that_differs() -> None:
    v0_1 = Decisions.v0_1()
    one, other = (
        dataclasses.replace(v0_1, next_to_food=17.0, patience=7),
        dataclasses.replace(v0_1, patience=8),
    )
    assert one.differing(other) == {"next_to_food": (17.0, 20.0), "patience": (7, 8)}
    assert other.differing(one) == {"next_to_food": (20.0, 17.0), "patience": (8, 7)}
    assert one.differing(one) == {}


# ---------------------------------------------------------------- the command line


def test_parse_reads_assignments() -> None:
    parsed = Decisions.parse(["next_to_food=17", "patience=7", "held_food=no candidate"])
    assert parsed.changed() == {"next_to_food": 17.0, "patience": 7, "held_food": "no candidate"}
    assert type(parsed.next_to_food) is float
    assert type(parsed.patience) is int
    assert Decisions.parse([]) == Decisions()


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("next_to_food", "decision 'next_to_food'; allowed: NAME=VALUE, such as next_to_food=22"),
        ("", "decision ''; allowed: NAME=VALUE"),
        ("next_to_foot=17", "decision 'next_to_foot' is unknown; allowed: aimed, "),
        ("=17", "decision '' is unknown"),
        ("next_to_food=near", "decision next_to_food is 'near'; allowed: a number from 10 to 30 pixels"),
        ("next_to_food=", "decision next_to_food is ''; allowed: a number"),
        ("next_to_food=nan", "decision next_to_food is nan; allowed: a number"),
        ("next_to_food=99", "decision next_to_food is 99.0; allowed: a number from 10 to 30 pixels"),
        ("patience=7.5", "decision patience is '7.5'; allowed: a whole number from 1 to 10000 rounds"),
        ("equal_distance=nearest", "decision equal_distance is 'nearest'; allowed: 'nearer state', 'farther state'"),
    ],
)  # fmt: skip
def test_parse_refuses_what_it_cannot_read(assignment: str, message: str) -> None:
    with pytest.raises(ValueError, match="allowed") as error:
        Decisions.parse([assignment])
    assert str(error.value).startswith(message)
