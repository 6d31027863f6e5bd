"""`khepera-forage arena`, and `--arena` of other commands: named arenas, files and procedural levels."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from khepera_forage.cli.main import main
from khepera_forage.envs.rendering import palette
from khepera_forage.sim.arena_file import read_arena, write_arena
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS, FAMILY, family_arena
from khepera_forage.sim.arenas.procedural import LEVELS, procedural_arena

DOORS = """\
name = "narrow"
walls = [[0, 0], [1000, 0], [1000, 500], [0, 500]]
home = [850, 250]
home_radius = 80
start = [150, 250, 0]
foods = [[300, 250]]
obstacles = [[[480, 0], [520, 0], [520, 300], [480, 300]]]
"""


def pixels(path: Path) -> NDArray[np.uint8]:
    return np.asarray(Image.open(path).convert("RGB"))


def share(path: Path, colour: palette.Colour) -> float:
    """Of the pixels of a picture, those of a colour."""
    return float(np.mean(np.abs(pixels(path).astype(int) - colour).max(axis=2) < 30))


def test_list_has_every_arena_and_difficulty(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["arena", "list"]) == 0
    out = capsys.readouterr().out
    names = [line.split()[0] for line in out.splitlines() if line]
    assert names == ["arena", *ARENAS, "Procedural-v1", *DIFFICULTIES]
    assert "TMaze-v1        1400 x  860        8     1    1000" in out


@pytest.mark.parametrize("name", ["corridor", "t_maze", "obstacles", "mixed_foods", "procedural"])
def test_arena_is_drawn(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    picture = Path("new/arena.png")
    level = ["--difficulty", "hard", "--level", str(LEVELS)] if name == "procedural" else []
    assert main(["arena", "show", name, *level, "--out", str(picture)]) == 0
    out, err = capsys.readouterr()
    assert f"{picture}: {'procedural_hard_1000000' if level else name}\n" in out
    assert ("step limit" if not level else f"step limit {DIFFICULTIES['hard'].limit}") in out
    assert err == ""
    assert share(picture, palette.FLOOR) > 0.1
    assert share(picture, palette.HOME) > 0.001
    assert share(picture, (0, 114, 178)) > 0.001  # paths
    assert 600 <= pixels(picture).shape[1] <= 1300


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("300], [480, 300", "400], [480, 400", "narrow: there is no way between"),  # leaves 100 mm
        ("[1000, 500], [0, 500]", "[0, 500], [1000, 500]", "narrow: walls cross or touch at (500, 250)"),
        ("[[300, 250]]", "[[150, 250]]", "food at (150, 250) mm overlaps robot at (150, 250) mm"),
        ("[[0, 0], [1000, 0]", "[[-10, 0], [1000, 0]", "arenas reach from (-10, 0) to (1000, 500) mm; allowed"),
    ],
)  # fmt: skip
def test_arena_that_is_not_allowed_is_drawn_and_refused(
    old: str, new: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("narrow.toml").write_text(DOORS)
    assert main(["arena", "show", "narrow.toml"]) == 0
    assert "longest way" in capsys.readouterr().out
    assert old in DOORS
    Path("narrow.toml").write_text(DOORS.replace(old, new))
    assert main(["arena", "show", "narrow.toml"]) == 1
    out, err = capsys.readouterr()
    assert err.startswith(f"khepera-forage arena show: {message}")
    assert err.count("\n") == 1
    assert out == "arena.png: narrow\n"
    assert share(Path("arena.png"), palette.FLOOR) > 0.1
    red = share(Path("arena.png"), (217, 95, 107))  # where a robot does not fit, seen through on the floor
    assert red > 0.001 if "no way" in message else red == 0


def test_written_arena_is_the_one_named(capsys: pytest.CaptureFixture[str]) -> None:
    for name in FAMILY:
        assert main(["arena", "write", name, f"{name}.toml"]) == 0
        assert read_arena(f"{name}.toml") == family_arena(name)
    assert main(["arena", "write", "procedural", "level.toml", "--level", "9"]) == 0
    assert read_arena("level.toml") == procedural_arena(9, "medium")
    assert main(["arena", "write", "level.toml", "copy.toml"]) == 0
    assert Path("copy.toml").read_text() == Path("level.toml").read_text()
    assert "`khepera-forage arena show copy.toml` draws it" in capsys.readouterr().out


def test_recall_takes_a_named_arena_and_an_arena_file() -> None:
    write_arena(family_arena("t_maze"), "mine.toml")
    texts = []
    for arena in ("mine.toml", "t_maze", "mixed_foods"):
        assert main(["recall", "--arena", arena, "--episodes", "1", "--out", "rows.csv"]) == 0
        texts.append(Path("rows.csv").read_text())
    assert texts[0] == texts[1]
    assert "mixed_foods" in texts[2]
