"""What is said without optional dependencies: at once, in one line, with one command that installs all of them."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from zipfile import ZipFile

import pytest

from khepera_forage.cli.main import main
from khepera_forage.extras import EXTRAS, MissingExtraError, require
from tests.wheel.building import IMPORTS, PIP, ROOT, built_wheel

WITHOUT_OPENCV = ("calibration", "overlay", "tracker", "tracker_settings", "video")
MODULES = [module for modules in EXTRAS.values() for module in modules]


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No optional dependency can be imported, and results go to an empty folder."""
    for module in MODULES:
        monkeypatch.setitem(sys.modules, module, None)
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize(
    ("command", "extras"),
    [
        ("reproduce --quick", "fast,plots"),
        ("reproduce --quick --backend pymunk", "plots"),
        ("compare --quick --only tree", "plots"),
        ("infer --quick", "fast,plots"),
        ("dataset --episodes 1", "minari"),
        ("watch training", "render"),
        ("watch recall --out film.gif", "render"),
        ("watch recall --out film.mp4", "render,camera"),
        ("watch recall --lab virtual --out film.gif", "render,robots,camera"),
        ("teach", "render"),
        ("arena show missing.toml", "plots"),
        ("plot missing.csv", "plots"),
        ("train --lab virtual", "robots,camera"),
        ("robot probe --port /dev/ttyUSB0", "robots"),
        ("camera preview", "camera"),
        ("camera preview --out film.gif", "camera,render"),
        ("camera calibrate --points 0,0=0,0 1,0=1,0 1,1=1,1 0,1=0,1", "camera"),
        ("camera markers --out markers.svg", "plots"),
    ],
)
def test_command_says_at_once_what_to_install(command: str, extras: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command.split()) == 2
    error = capsys.readouterr().err
    assert f"pip install 'khepera-forage[{extras}]'" in error
    assert error.count("\n") == 1
    assert not list(Path().rglob("*.*")), "nothing was written"


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize(
    "command", ["decisions", "compare --list", "train --episodes 1 --out g", "recall --episodes 1 --out r.csv"]
)
def test_command_works_without_extras(command: str) -> None:
    assert main(command.split()) == 0


def test_extras_are_those_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert set(EXTRAS) <= set(project["optional-dependencies"])


@pytest.mark.usefixtures("bare")
def test_one_command_installs_everything_and_nothing_twice() -> None:
    with pytest.raises(MissingExtraError) as error:
        require("this", "render", "plots", otherwise="; or do without")
    told = "this needs pygame, PIL, matplotlib: pip install 'khepera-forage[render,plots]'; or do without"
    assert str(error.value) == told
    require("that")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package as it is published."""
    return built_wheel(tmp_path_factory.mktemp("wheel"))


def test_wheel_can_be_published(wheel: Path) -> None:
    check = [sys.executable, "-m", "twine", "check", "--strict", str(wheel)]
    done = subprocess.run(check, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert "PASSED" in done.stdout
    with ZipFile(wheel) as archive:
        shown = archive.read(next(name for name in archive.namelist() if name.endswith("METADATA"))).decode()
    links = re.findall(r"\[([^\]]*)\]\(([^)]*)\)", shown)
    assert links
    assert all(link.startswith("https:") for _, link in links), links  # there are no files beside the page


def test_every_module_of_the_wheel_imports_or_says_what_to_install(wheel: Path, tmp_path: Path) -> None:
    installed = tmp_path / "installed"
    subprocess.run([*PIP, "install", "--no-deps", "--target", str(installed), str(wheel)], check=True)
    program = f"import sys; sys.path.insert(0, {str(installed)!r}); sys.modules |= dict.fromkeys({MODULES!r})"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program + IMPORTS], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    *refused, place = done.stdout.splitlines()
    assert place.startswith(str(installed))
    assert 0 < len(refused) < 60
    for line in refused:
        assert "pip install 'khepera-forage[" in line or any(name in line for name in ("pygame", "cv2", "toio")), line
        assert not line.startswith(tuple(f"khepera_forage.vision.{name} " for name in WITHOUT_OPENCV)), line
