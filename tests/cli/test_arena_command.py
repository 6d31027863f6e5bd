"""`khepera-forage arena`, and `--arena` of other commands: named arenas, files and procedural levels."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from khepera_forage.envs.rendering import palette
from khepera_forage.sim.arena_file import read_arena, write_arena
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import ARENAS, FAMILY, family_arena
from khepera_forage.sim.arenas.procedural import LEVELS, procedural_arena
from tests.cli.running import Run

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


def test_list_has_every_arena_and_difficulty(run: Run) -> None:
    out = run("arena list")
    names = [line.split()[0] for line in out.splitlines() if line]
    assert names == ["arena", *ARENAS, "Procedural-v1", *DIFFICULTIES]
    assert "TMaze-v1        1400 x  860        8     1    1000" in out


@pytest.mark.parametrize("name", ["corridor", "t_maze", "obstacles", "mixed_foods", "procedural"])
def test_arena_is_drawn(name: str, run: Run) -> None:
    picture = Path("new/arena.png")
    level = f"--difficulty hard --level {LEVELS}" if name == "procedural" else ""
    out = run(f"arena show {name} {level} --out {picture}")
    assert f"{picture}: {'procedural_hard_1000000' if level else name}\n" in out
    assert ("step limit" if not level else f"step limit {DIFFICULTIES['hard'].limit}") in out
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
def test_arena_that_is_not_allowed_is_drawn_and_refused(old: str, new: str, message: str, run: Run) -> None:
    Path("narrow.toml").write_text(DOORS)
    assert "longest way" in run("arena show narrow.toml")
    Path("narrow.toml").write_text(DOORS.replace(old, new))
    assert run.refused("arena show narrow.toml", status=1).startswith(f"khepera-forage arena show: {message}")
    assert share(Path("arena.png"), palette.FLOOR) > 0.1
    red = share(Path("arena.png"), (217, 95, 107))  # where a robot does not fit, seen through on the floor
    assert red > 0.001 if "no way" in message else red == 0


def test_written_arena_is_the_one_named(run: Run) -> None:
    for name in FAMILY:
        run(f"arena write {name} {name}.toml")
        assert read_arena(f"{name}.toml") == family_arena(name)
    run("arena write procedural new/level.toml --level 9")
    assert read_arena("new/level.toml") == procedural_arena(9, "medium")
    assert "`khepera-forage arena show copy.toml` draws it" in run("arena write new/level.toml copy.toml")
    assert Path("copy.toml").read_text() == Path("new/level.toml").read_text()


def test_recall_takes_a_named_arena_and_an_arena_file(run: Run) -> None:
    write_arena(family_arena("t_maze"), "mine.toml")
    texts = []
    for arena in ("mine.toml", "t_maze", "mixed_foods"):
        run(f"recall --arena {arena} --episodes 1 --out rows.csv")
        texts.append(Path("rows.csv").read_text())
    assert texts[0] == texts[1]
    assert "mixed_foods" in texts[2]
