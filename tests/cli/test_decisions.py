"""`--decision`, `--allow-other-decisions` and `khepera-forage decisions`."""

from dataclasses import replace
from pathlib import Path

import pytest

from khepera_forage.cli.main import main
from khepera_forage.experience import Experience
from khepera_forage.rollouts.row_files import read_rows
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.task.decisions import FIELDS, Decisions, decisions_text
from tests.cli.running import Run


def default(name: str) -> str:
    return f"{getattr(Decisions(), name):g}"


def test_table_has_every_decision_with_default_range_section_and_reason(run: Run) -> None:
    lines = run("decisions").splitlines()
    assert lines[0].split() == ["decision", "default", "thesis", "allowed"]
    for field, line, reason in zip(FIELDS.values(), lines[1::2], lines[2::2], strict=True):
        assert line.startswith(f"{field.name} ")
        assert f" {field.section} " in line
        assert field.unit in line
        assert reason == f"    {field.reason}"
        for choice in field.choices:
            assert choice in line
    assert sum(len(line) > 80 for line in lines[1::2]) < 10, "most lines fit a terminal"
    (next_to_food,) = [line.split() for line in lines if line.startswith("next_to_food")]
    assert next_to_food == ["next_to_food", default("next_to_food"), "pixels", "4.2.1", "10", "to", "30"]


def test_train_and_recall_store_their_decisions_of_which_the_first_may_be_a_version(run: Run) -> None:
    decision = "--decision v0.1 --decision next_to_food=22 --decision separation=20"
    run(f"train --episodes 1 --out e --seed 1 {decision}")
    experience = Experience.load("e/g1.csv")
    assert experience.decisions == replace(Decisions.v0_1(), next_to_food=22, separation=20)
    text = decisions_text(experience.decisions)
    assert {row.decisions for row in read_rows(Path("e/attempts.csv"), TrainingRow)} == {text}
    run(f"recall --experience e/g1.csv --episodes 1 --out rows.csv {decision}")
    (row,) = read_rows(Path("rows.csv"), RecallRow)
    assert (row.decisions, row.experience_size) == (text, len(experience))


@pytest.mark.parametrize("command", ["recall --episodes 1 --out rows.csv", "watch recall --every 100 --out film.gif"])
def test_experience_of_other_decisions_is_refused_unless_allowed(command: str, run: Run) -> None:
    vector = (0, 52, 0, 215, 28)
    Experience([vector], [0]).save("g1.csv")
    Experience([vector], [0], decisions=Decisions(separation=20)).save("g2.csv")
    separation = f"separation is 20, not {default('separation')}"
    both = f"next_to_food is {default('next_to_food')}, not 22; {separation}"
    name, *_, out = command.split()
    for given, differences in (("g2.csv --decision next_to_food=22", both), ("g1.csv g2.csv", separation)):
        assert run.refused(f"{command} --experience {given}") == (
            f"khepera-forage {name}: g2.csv: recorded under other decisions: {differences}; allowed: the same "
            "decisions, or any with allow_other_decisions=True (--allow-other-decisions)\n"
        )
        assert not Path(out).exists()
    run(f"{command} --experience g1.csv g2.csv --allow-other-decisions")
    assert Path(out).exists()


@pytest.mark.parametrize("backend", ["pymunk --jobs 1", "compiled"])
def test_decisions_under_which_no_training_succeeds_are_reported_in_one_line(
    backend: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The gripper cannot be lowered 12 pixels from food: its fingers reach further."""
    decision = "--decision next_to_food=12 --decision most_attempts=2"
    assert main(f"reproduce --quick --out t {decision} --backend {backend}".split()) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if "compiling" not in line]
    error = "khepera-forage reproduce: none of 2 attempts at a training episode was complete"
    assert lines == [f"{error}, with the noise 'laboratory'"]


def test_film_runs_at_the_speed_of_the_rounds(run: Run) -> None:
    from PIL import Image

    durations = []
    for value in ("0.1", "0.2"):
        run(f"watch recall --out film.gif --every 50 --decision round_duration={value}")
        with Image.open("film.gif") as film:
            durations.append(film.info["duration"])
    assert durations == [5000, 10000]
