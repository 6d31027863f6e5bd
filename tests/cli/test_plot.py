"""`khepera-forage plot` draws the rows that other commands write."""

from pathlib import Path

import pytest

from khepera_forage.cli.main import main
from khepera_forage.cli.plot import drawn
from tests.benchmarks.running import is_picture
from tests.cli.running import Run
from tests.figure_checks import check_readable, lay_out


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which a user has recalled, trained and compared."""
    folder = tmp_path_factory.mktemp("results")
    for command in (
        "recall --episodes 3 --out FOLDER/teacher.csv",
        "train --episodes 1 --seed 5 --out FOLDER/g",
        "compare --quick --seeds 1 --jobs 1 --out FOLDER/compared --only teacher --only tree",
        "recall --episodes 2 --experience FOLDER/g --out FOLDER/imitator.csv",
    ):
        assert main(command.replace("FOLDER", str(folder)).split()) == 0
    return folder


@pytest.mark.parametrize(
    "files",
    [
        "teacher.csv",
        "teacher.csv imitator.csv",
        "g/attempts.csv",
        "compared/rows.csv",
        "compared/results.json",
        "compared/results.json compared/rows.csv",
    ],
)
def test_rows_of_other_commands_are_drawn(files: str, results: Path, run: Run) -> None:
    paths = [results / file for file in files.split()]
    run("plot", *map(str, paths))
    assert is_picture(Path("plot.png"))
    check_readable(lay_out(drawn(paths)))


def test_files_of_one_name_stay_apart(results: Path, tmp_path: Path) -> None:
    paths = [tmp_path / folder / "recall.csv" for folder in "ab"]
    for path in paths:
        path.parent.mkdir()
        path.write_bytes((results / "teacher.csv").read_bytes())
    labels = [label.get_text() for label in drawn([*paths, paths[0]]).axes[0].get_yticklabels()]
    assert labels == ["teacher, corridor (b)", "teacher, corridor (a)"]


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ("teacher.csv g/attempts.csv", "are of different kinds; allowed: one kind"),
        ("g/g1.csv", "its first line is '# khepera_forage experience, version 1'; allowed: rows of `recall`"),
        ("nothing.csv", "No such file or directory"),
        ("empty.csv", "has no rows; allowed: at least one"),
        ("broken.json", "broken.json: "),
        ("teacher.csv --out plot.gif", "'plot.gif'; allowed: a name that ends in .png"),
    ],
)
def test_other_files_are_refused(
    files: str, message: str, results: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(results)
    (results / "empty.csv").write_text((results / "teacher.csv").read_text().partition("\n")[0] + "\n")
    (results / "broken.json").write_text("{")
    assert message in run.refused(f"plot {files}")
