"""The pictures of scripts are readable at the size at which pages show them, drawn from the rows of quick runs.

Scripts that measure times are not among them: they would measure again.
"""

import runpy
import shutil
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import ROOT
from tests.benchmarks.test_scripts import SCRIPTS, available
from tests.figure_checks import check_readable, check_shading_is_explained

CONTINUED = [name for name, script in SCRIPTS.items() if script.runs and "--fresh" in script.options]


@pytest.mark.parametrize("script", available(*CONTINUED))
def test_pictures_are_readable_and_explain_their_shading(
    script: str, quick_run: QuickRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = SCRIPTS[script].run
    out = shutil.copytree(quick_run(script, *run), tmp_path / "out")
    figures: dict[str, Figure] = {}
    monkeypatch.setattr(
        "khepera_forage.experiments.page.save", lambda figure, path: figures.update({path.name: figure})
    )
    subcommand = [SCRIPTS[script].subcommand] if SCRIPTS[script].subcommand else []
    arguments = [*subcommand, "--quick", "--seed", "1", "--out", str(out), *run]
    monkeypatch.setattr(sys, "argv", [script, *arguments])
    # The rows are finished, so the script only draws.
    main = runpy.run_path(str(ROOT / "benchmarks" / f"{script}.py"))["main"]
    assert main() == 0
    assert figures
    for name, figure in figures.items():
        try:
            check_readable(figure)
            check_shading_is_explained(figure)
        except AssertionError as error:
            raise AssertionError(f"{name}: {error}") from error
