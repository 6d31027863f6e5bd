"""Decisions of experience: stored in files, and refused where they differ."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from khepera_forage.experience import Experience, ExperienceError
from khepera_forage.task import decisions as decisions_module
from khepera_forage.task.decisions import Decisions

VECTOR = (0, 52, 0, 215, 28)
V0_1 = Decisions.v0_1()
OTHER = replace(V0_1, next_to_food=17, separation=20)
TEXT = "v0.1;next_to_food=17;separation=20"
DIFFERENCES = "next_to_food is 17, not 20; separation is 20, not 14"
FLAG = "or any with allow_other_decisions=True (--allow-other-decisions)"


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """A file of the decisions of version 0.1, and one of others."""
    paths = tmp_path / "default.csv", tmp_path / "other.csv"
    Experience([VECTOR], [0], seed=1, decisions=V0_1).save(paths[0])
    Experience([VECTOR] * 2, [0] * 2, seed=1, decisions=OTHER).save(paths[1])
    return paths


@pytest.mark.parametrize(
    ("line", "decisions"),
    [("", V0_1), ("# decisions: next_to_food=17;separation=20\n", OTHER), ("# decisions: mixed\n", None)],
)
def test_older_file_has_the_decisions_of_version_0_1_and_what_differs(
    line: str, decisions: Decisions | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(decisions_module.VERSIONS, "v1", replace(V0_1, patience=7, home_radius=90))
    path = tmp_path / "g1.csv"
    path.write_text(
        "# khepera_forage experience, version 1\n# package: 0.1.0\n# arena: corridor\n# seed: 7\n# episodes: 1\n"
        f"{line}# units: distances in pixels of 5 mm; arms_height 255 (down) to 215 (raised)\n"
        "object_presence,robot_home_distance,food_type,arms_height,robot_food_distance,behaviour\n"
        "0,52,UNKNOWN,215,28,SEARCH_FOR_FOOD\n# complete: 1 vectors\n"
    )
    assert Experience.load(path) == Experience([VECTOR], [0], seed=7, decisions=decisions)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "decisions are ''; allowed: a version and what differs from it, or no such line"),
        ("v2;next_to_food=17", "version 'v2' of the decisions is unknown; allowed: 'v0.1', 'v1'"),
        ("next_to_food=9", "decision next_to_food is 9.0; allowed: a number from 10 to 30 pixels"),
        ("Mixed", "decision 'Mixed'; allowed: NAME=VALUE"),
    ],
)
def test_damaged_decisions_are_an_error_with_file_and_line(
    text: str, message: str, files: tuple[Path, Path]
) -> None:
    path = files[1]
    path.write_text(path.read_text().replace(TEXT, text))
    with pytest.raises(ExperienceError, match=re.escape(f"{path}, line 6: {message}")):
        Experience.load(path)


def test_files_of_different_decisions_are_refused(files: tuple[Path, Path]) -> None:
    default, other = files
    with pytest.raises(ExperienceError) as error:
        Experience.load(default, other)
    assert str(error.value) == (
        f"{other}: recorded under other decisions: {DIFFERENCES}; allowed: the same decisions, {FLAG}"
    )
    joined = Experience.load(default, other, allow_other_decisions=True)
    assert (len(joined), joined.decisions) == (3, None)


def test_file_of_other_decisions_than_those_of_an_environment_is_refused(files: tuple[Path, Path]) -> None:
    default, other = files
    assert Experience.load(other, decisions=OTHER).decisions == OTHER
    with pytest.raises(
        ExperienceError, match=re.escape(f"{other}: recorded under other decisions: {DIFFERENCES}")
    ):
        Experience.load(other, decisions=V0_1)
    with pytest.raises(
        ExperienceError,
        match=re.escape(f"{default}: recorded under other decisions: next_to_food is 20, not 17"),
    ):
        Experience.load(other, default, decisions=OTHER)
    allowed = Experience.load(other, decisions=V0_1, allow_other_decisions=True)
    assert allowed.decisions == OTHER


def test_mixed_experience_stays_mixed_and_fits_no_environment(tmp_path: Path) -> None:
    parts = Experience([VECTOR], [0]), Experience([VECTOR], [0], decisions=OTHER)
    mixed = Experience.join(parts, allow_other_decisions=True)
    path = tmp_path / "mixed.csv"
    mixed.save(path)
    assert "# decisions: mixed\n" in path.read_text()
    assert Experience.load(path) == mixed
    for refused in (
        lambda: mixed.require_decisions(Decisions()),
        lambda: parts[0] + mixed,
        lambda: mixed + mixed,
        lambda: Experience.load(path, decisions=OTHER),
    ):
        with pytest.raises(
            ExperienceError, match="experience of mixed decisions; allowed: the same decisions, or"
        ):
            refused()
