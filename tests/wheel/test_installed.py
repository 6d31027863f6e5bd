"""The wheel in empty environments: every public import and every command, without extras and with each extra.

Each environment downloads its packages, so `make test-wheel` runs these tests, and `make test` does not.
"""

import os
import subprocess
import venv
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.wheel.building import IMPORTS, built_wheel

ALL = {"render", "plots", "robots", "camera", "fast"}
ENVIRONMENTS = {
    "": set[str](),
    **{extra: {extra} for extra in ("render", "plots", "robots", "camera", "fast", "minari")},
    "all": ALL,
    "all,minari": {*ALL, "minari"},
}
"""What is installed beside the package, and which extras that are."""
COMMANDS = {
    "--version": set[str](),
    "decisions": set[str](),
    "compare --list": set[str](),
    "train --episodes 1 --out g": set[str](),
    "recall --episodes 1 --out r.csv": set[str](),
    "camera markers --out m.svg": set[str](),
    "camera markers --out m.png": {"render"},
    "watch recall --out recall.gif": {"render"},
    "watch recall --out recall.mp4": {"render", "camera"},
    "compare --quick --only tree --seeds 1 --out c": {"plots"},
    "reproduce --quick --out t": {"fast", "plots"},
    "recall --lab virtual --episodes 1 --out v.csv": {"robots", "camera"},
    "infer --quick --out i": {"fast", "plots"},
    "dataset --episodes 1 --out d": {"minari"},
}
"""Each command, and the extras without which it says what to install."""
DRAWING = (
    "khepera_forage.envs.rendering.",
    "khepera_forage.cli.teach_window",
    "khepera_forage.cli.window",
    "khepera_forage.rollouts.rendered_training",
    *(
        f"khepera_forage.vision.{name}"
        for name in ("rendering", "detection", "markers", "segmentation", "tags", "image_quality")
    ),
)
"""Modules that draw or read frames; those that import them say what to install."""


class Environment(NamedTuple):
    """An environment in which nothing but the wheel and some extras was installed.

    Attributes:
        extras: What was installed beside the package.
        bin: Folder of its programs.
    """

    extras: set[str]
    bin: Path

    def run(self, *command: str, folder: Path) -> subprocess.CompletedProcess[str]:
        """A program of the environment, started in a folder that is not the repository's."""
        variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        program, *arguments = command
        return subprocess.run(
            [str(self.bin / program), *arguments],
            capture_output=True,
            text=True,
            cwd=folder,
            env=variables | {"SDL_VIDEODRIVER": "dummy"},
            timeout=600,
        )


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built_wheel(tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module", params=ENVIRONMENTS, ids=lambda extras: extras or "no extras")
def environment(request: pytest.FixtureRequest, wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    made = Environment(ENVIRONMENTS[request.param], folder / "bin")
    wanted = f"{wheel}[{request.param}]" if request.param else str(wheel)
    done = made.run("pip", "install", "--quiet", wanted, folder=folder)
    assert done.returncode == 0, done.stderr
    return made


def test_every_module_imports_or_says_what_to_install(environment: Environment, tmp_path: Path) -> None:
    done = environment.run("python", "-W", "error", "-c", IMPORTS, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    *refused, place = done.stdout.splitlines()
    assert place.startswith(str(environment.bin.parent))
    for line in refused:
        if line.startswith(DRAWING) and "pip install" not in line:
            continue
        assert "pip install 'khepera-forage[" in line, line
        missing = line.split("khepera-forage[")[1].split("]")[0].split(",")
        assert not environment.extras & set(missing), line


@pytest.mark.parametrize("command", COMMANDS)
def test_command_works_or_says_what_to_install(environment: Environment, command: str, tmp_path: Path) -> None:
    missing = COMMANDS[command] - environment.extras
    done = environment.run("khepera-forage", *command.split(), folder=tmp_path)
    if not missing:
        assert done.returncode == 0, done.stderr
        return
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    named = done.stderr.split("pip install 'khepera-forage[")[1].split("]")[0].split(",")
    assert set(named) == missing
    assert not list(tmp_path.iterdir()), "nothing was written"
