"""`Decisions`: every field with its range and reason, their text, and clear errors for what is not allowed."""

import dataclasses
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from khepera_forage.task.decision_versions import V0_1 as FIELDS_OF_V0_1
from khepera_forage.task.decisions import (
    FIELDS,
    Decisions,
    Field,
    decisions_from_text,
    decisions_from_words,
    decisions_text,
)

V0_1 = Decisions.v0_1()
every_field = pytest.mark.parametrize("field", FIELDS.values(), ids=lambda field: field.name)


@every_field
def test_every_choice_and_both_ends_of_a_range_are_accepted_and_read_back(field: Field) -> None:
    for value in field.choices or (field.kind(field.least), field.kind(field.most)):
        try:
            decisions = Decisions.from_changes({field.name: value})
        except ValueError as error:  # a radius beyond `home_to_wall`
            assert "home_radius" in str(error)  # noqa: PT017
            continue
        assert getattr(decisions, field.name) == value
        assert Decisions.from_changes(decisions.changed()) == decisions
        assert decisions_from_text(decisions_text(decisions)) == decisions


@every_field
def test_other_value_is_refused_with_everything_that_is_allowed(field: Field) -> None:
    wrong: list[Any] = ["", "something else", None, True, ["raised"], np.array([20.0, 21.0]), 1j, math.nan]
    if not field.choices:
        step = 1 if field.kind is int else 1e-6
        wrong += [field.kind(field.least) - step, field.kind(field.most) + step, 10**400, math.inf, "20"]
    if field.kind is int:
        wrong += [1.5, 1.0]
    for value in wrong:
        with pytest.raises(ValueError, match="allowed") as error:
            Decisions(**{field.name: value})
        assert str(error.value) == f"decision {field.name} is {value!r}; allowed: {field.allowed}"


def test_numbers_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^decision close_to_food is 24\.0; allowed: at least next_to_food, 25\.0$"):
        Decisions(next_to_food=25.0, close_to_food=24.0)
    with pytest.raises(ValueError, match=r"^decision home_radius is 101\.0; allowed: at most home_to_wall, 100\.0$"):
        Decisions(home_radius=101.0, home_to_wall=100.0)
    Decisions(next_to_food=25.0, close_to_food=25.0)


def test_values_are_stored_as_plain_numbers_and_texts() -> None:
    given: dict[str, Any] = {"next_to_food": 17, "patience": np.int64(7), "equal_distance": np.str_("farther state")}
    decisions = Decisions(**given)
    stored = decisions.next_to_food, decisions.patience, decisions.equal_distance
    assert stored == (17.0, 7, "farther state")
    assert [type(value) for value in stored] == [float, int, str]


def test_version_0_1_names_every_field_and_does_not_follow_the_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    assert list(FIELDS_OF_V0_1) == list(FIELDS)
    defaults = {field.name: field.default for field in dataclasses.fields(Decisions)} | {"recall_marker": 1}
    monkeypatch.setattr(Decisions.__init__, "__defaults__", tuple(defaults.values()))
    assert Decisions().recall_marker == 1
    assert dataclasses.asdict(Decisions.v0_1()) == dict(FIELDS_OF_V0_1)


def test_changes_are_relative_to_a_base_and_differing_gives_both_values() -> None:
    base = Decisions(next_to_food=17.0, patience=7)
    assert base.changed() == {"next_to_food": 17.0, "patience": 7}
    assert Decisions.from_changes({"patience": 8}, base) == Decisions.parse(["patience=8"], base)
    assert Decisions.parse([], base) == base
    one, other = replace(V0_1, next_to_food=17, equal_distance="farther state"), replace(V0_1, separation=20)
    assert one.differing(other) == {
        "next_to_food": (17.0, 20.0),
        "equal_distance": ("farther state", "nearer state"),
        "separation": (14.0, 20.0),
    }


@pytest.mark.parametrize(
    ("text", "decisions", "is_written"),
    [
        ("v0.1", V0_1, True),
        ("v0.1;round_duration=0.2;next_to_food=17", replace(V0_1, next_to_food=17, round_duration=0.2), True),
        ("v0.1;equal_distance=farther state", replace(V0_1, equal_distance="farther state"), True),
        ("v0.1;following_gain=0.3333333333333333", replace(V0_1, following_gain=1 / 3), True),
        ("v1", Decisions(), True),
        ("v1;next_to_food=22", Decisions(next_to_food=22), True),
        # Without a version, of version 0.1. A default may be named: a later version may have another.
        ("", V0_1, False),
        ("separation=20", replace(V0_1, separation=20), False),
        ("next_to_food=20", V0_1, False),
    ],
)
def test_text_names_version_and_changes(text: str, decisions: Decisions, is_written: bool) -> None:
    assert decisions_from_text(text) == decisions
    assert (decisions_text(decisions) == text) is is_written
    if is_written:
        assert decisions_from_words(text.split(";")) == decisions


def test_text_names_the_older_of_two_versions_that_are_as_near() -> None:
    new = [(name, value) for name, (value, _) in Decisions().differing(V0_1).items()]
    between = Decisions.from_changes(dict(new[: len(new) // 2]), V0_1)
    assert len(between.differing(V0_1)) == len(between.changed())
    assert decisions_text(between).startswith("v0.1;")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("next_to_food", "decision 'next_to_food'; allowed: NAME=VALUE, such as next_to_food=22"),
        ("next_to_food=", "decision next_to_food is ''; allowed: a number"),
        ("patience=1.5", "decision patience is '1.5'; allowed: a whole number from 1 to 10000 rounds"),
        ("patience=5;patience=5", "decision patience is set twice; allowed: once"),
        ("next_to_food=17;", "decision ''; allowed: NAME=VALUE"),
        ("next_to_food=17.0", "decision 'next_to_food=17.0'; allowed: 'next_to_food=17'"),
        ("next_to_food=17; separation=20", "decision ' separation' is unknown"),
        ("v1;v1", "decision 'v1'; allowed: NAME=VALUE"),
    ],
)
def test_wrong_text_is_refused(text: str, message: str) -> None:
    """More cases: `tests/cli/test_user_errors.py`."""
    with pytest.raises(ValueError, match="allowed") as error:
        decisions_from_text(text)
    assert str(error.value).startswith(message)
