"""Decisions as text, in files and rows."""

import dataclasses

import pytest

from khepera_forage.task.decision_fields import Field
from khepera_forage.task.decision_text import decisions_from_text, decisions_text, differences
from khepera_forage.task.decisions import Decisions

FIELDS = [Field.of(field) for field in dataclasses.fields(Decisions)]


@pytest.mark.parametrize(
    ("decisions", "text"),
    [
        (Decisions(), ""),
        (Decisions(next_to_food=17), "next_to_food=17"),
        (Decisions(next_to_food=17, round_duration=0.2), "round_duration=0.2;next_to_food=17"),
        (Decisions(patience=50), "patience=50"),
        (Decisions(equal_distance="farther state"), "equal_distance=farther state"),
        (Decisions(following_gain=1 / 3), "following_gain=0.3333333333333333"),
    ],
)
def test_text_lists_the_changed_decisions_and_is_read_back(decisions: Decisions, text: str) -> None:
    assert decisions_text(decisions) == text
    assert decisions_from_text(text) == decisions


@pytest.mark.parametrize("field", FIELDS, ids=lambda field: field.name)
def test_every_field_is_read_back(field: Field) -> None:
    values = field.choices or (field.kind(field.least), field.kind(field.most))
    for value in values:
        try:
            decisions = Decisions.from_changes({field.name: value})
        except ValueError:  # a radius beyond `home_to_wall`
            continue
        assert decisions_from_text(decisions_text(decisions)) == decisions


def test_text_may_name_a_default() -> None:
    """A file stays readable when a later version has its value as the default."""
    assert decisions_from_text("next_to_food=20") == Decisions()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("next_to_foot=17", "decision 'next_to_foot' is unknown; allowed: aimed, "),
        ("next_to_food", "decision 'next_to_food'; allowed: NAME=VALUE"),
        ("next_to_food=17;", "decision ''; allowed: NAME=VALUE"),
        ("next_to_food=31", "decision next_to_food is 31.0; allowed: a number from 10 to 30 pixels"),
        ("next_to_food=many", "decision next_to_food is 'many'; allowed: a number from 10 to 30"),
        ("patience=1.5", "decision patience is '1.5'; allowed: a whole number from 1 to 10000 rounds"),
        ("next_to_food=17;next_to_food=18", "decision next_to_food is set twice; allowed: once"),
        ("next_to_food=17.0", "decision 'next_to_food=17.0'; allowed: 'next_to_food=17'"),
        ("next_to_food= 17", "decision 'next_to_food= 17'; allowed: 'next_to_food=17'"),
        ("next_to_food=1_7", "decision 'next_to_food=1_7'; allowed: 'next_to_food=17'"),
        ("next_to_food=17; separation=20", "decision ' separation' is unknown"),
    ],
)
def test_damaged_text_is_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match="allowed") as error:
        decisions_from_text(text)
    assert str(error.value).startswith(message)


def test_duplicate_on_the_command_line_is_refused() -> None:
    with pytest.raises(ValueError, match="decision patience is set twice; allowed: once"):
        Decisions.parse(["patience=5", "separation=20", "patience=5"])


def test_differences_name_the_fields_and_both_values() -> None:
    decisions = Decisions(next_to_food=17, equal_distance="farther state")
    assert differences(decisions, Decisions(separation=20)) == (
        "next_to_food is 17, not 20; equal_distance is farther state, not nearer state; separation is 14, not 20"
    )
    assert differences(decisions, decisions) == ""
