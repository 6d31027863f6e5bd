"""Decisions as text, in files and rows."""

from dataclasses import replace

import pytest

from khepera_forage.task import decisions as decisions_module
from khepera_forage.task.decisions import (
    FIELDS,
    Decisions,
    Field,
    decisions_from_text,
    decisions_from_words,
    decisions_text,
    differences,
)

V0_1 = Decisions.v0_1()
OTHER_DEFAULTS = replace(V0_1, next_to_food=17, patience=7, orienting="lowered over food")


@pytest.fixture
def other_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    """The defaults are other ones than those of version 0.1."""
    monkeypatch.setitem(decisions_module.VERSIONS, "v1", OTHER_DEFAULTS)


TEXTS = [
    (V0_1, "v0.1"),
    (replace(V0_1, next_to_food=17), "v0.1;next_to_food=17"),
    (replace(V0_1, next_to_food=17, round_duration=0.2), "v0.1;round_duration=0.2;next_to_food=17"),
    (replace(V0_1, patience=50), "v0.1;patience=50"),
    (replace(V0_1, equal_distance="farther state"), "v0.1;equal_distance=farther state"),
    (replace(V0_1, following_gain=1 / 3), "v0.1;following_gain=0.3333333333333333"),
]


@pytest.mark.parametrize(("decisions", "text"), TEXTS)
def test_text_names_version_and_changed_decisions_and_is_read_back(decisions: Decisions, text: str) -> None:
    assert decisions_text(decisions) == text
    assert decisions_from_text(text) == decisions


@pytest.mark.usefixtures("other_defaults")
@pytest.mark.parametrize(
    ("decisions", "text"),
    [
        *TEXTS,
        (OTHER_DEFAULTS, "v1"),
        (replace(OTHER_DEFAULTS, patience=100), "v1;patience=100"),
        (replace(OTHER_DEFAULTS, next_to_food=22), "v1;next_to_food=22"),
    ],
)
def test_text_keeps_its_meaning_under_other_defaults(decisions: Decisions, text: str) -> None:
    assert decisions_text(decisions) == text
    assert decisions_from_text(text) == decisions


@pytest.mark.usefixtures("other_defaults")
@pytest.mark.parametrize(
    ("words", "decisions"),
    [
        ([], OTHER_DEFAULTS),
        (["v1"], OTHER_DEFAULTS),
        (["next_to_food=22"], replace(OTHER_DEFAULTS, next_to_food=22)),
        (["v1", "next_to_food=22"], replace(OTHER_DEFAULTS, next_to_food=22)),
        (["v0.1"], V0_1),
        (["v0.1", "patience=7", "next_to_food=22"], replace(V0_1, patience=7, next_to_food=22)),
    ],
)
def test_first_word_may_name_the_version_that_the_others_change(
    words: list[str], decisions: Decisions
) -> None:
    assert decisions_from_words(words) == decisions


@pytest.mark.usefixtures("other_defaults")
def test_text_of_a_set_between_two_versions_names_the_older() -> None:
    between = replace(V0_1, next_to_food=17, patience=50)
    assert decisions_text(between) == "v0.1;next_to_food=17;patience=50"


@pytest.mark.usefixtures("other_defaults")
@pytest.mark.parametrize(("text", "decisions"), [("", V0_1), ("separation=20", replace(V0_1, separation=20))])
def test_text_without_a_version_is_of_version_0_1(text: str, decisions: Decisions) -> None:
    assert decisions_from_text(text) == decisions


def test_text_of_the_present_version_is_of_the_defaults() -> None:
    assert decisions_from_text("v1") == Decisions()
    assert decisions_from_text("v1;separation=20") == Decisions(separation=20)


@pytest.mark.parametrize("field", FIELDS.values(), ids=lambda field: field.name)
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
    assert decisions_from_text("next_to_food=20") == decisions_from_text("v0.1;next_to_food=20") == V0_1


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
        ("v2", "version 'v2' of the decisions is unknown; allowed: 'v0.1', 'v1'"),
        ("v2;next_to_food=17", "version 'v2' of the decisions is unknown; allowed: 'v0.1', 'v1'"),
        ("v0.1 ;next_to_food=17", "version 'v0.1 ' of the decisions is unknown; allowed: "),
        ("v1;", "decision ''; allowed: NAME=VALUE"),
        ("v1;v1", "decision 'v1'; allowed: NAME=VALUE"),
        ("next_to_food=17;v1", "decision 'v1'; allowed: NAME=VALUE"),
        ("v1;next_to_food=17.0", "decision 'next_to_food=17.0'; allowed: 'next_to_food=17'"),
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
    decisions = replace(V0_1, next_to_food=17, equal_distance="farther state")
    assert differences(decisions, replace(V0_1, separation=20)) == (
        "next_to_food is 17, not 20; equal_distance is farther state, not nearer state; separation is 14, not 20"
    )
    assert differences(decisions, decisions) == ""
