"""The pictures of all scripts are readable at the size at which pages show them, and explain their shading."""

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.test_scripts import SCRIPTS, all_scripts


@all_scripts
def test_pictures_are_readable_and_explain_their_shading(script: str, quick_run: QuickRun) -> None:
    out = quick_run(script, *SCRIPTS[script].run)
    lines = (out.parent / "pictures").read_text(encoding="utf-8").splitlines()
    assert lines
    for line in lines:
        name, fault = line.split("\t")
        assert not fault, f"{name}: {fault}"
