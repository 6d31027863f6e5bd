"""Arena files: exact round trips, and one error for each mistake."""

import math
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arena_file import arena_text, parse_plan, read_arena
from khepera_forage.sim.arenas.named import box

DEN = """\
name = "den"
walls = [[0, 0], [700, 0], [700, 500], [0, 500]]
home = [560, 250]
home_radius = 80
start = [100, 250, 90]  # x mm, y mm, heading degrees
foods = [[350, 200], [350, 300.25]]
obstacles = [
    [[200, 0], [240, 0], [240, 150], [200, 150]],
]
"""


inside = st.floats(0.1, 0.9)


@st.composite
def arenas(draw: st.DrawFn) -> Arena:
    """A rectangle anywhere, with places and obstacles anywhere in it: any numbers, any printable name."""
    left, bottom = draw(st.floats(-1e6, 1e6)), draw(st.floats(-1e6, 1e6))
    length, width = draw(st.floats(600, 5000)), draw(st.floats(600, 5000))

    def place() -> Point:
        return Point(left + draw(inside) * length, bottom + draw(inside) * width)

    thickness = draw(st.lists(st.floats(1, 10), max_size=3))
    return Arena(
        name=draw(st.text(st.characters(exclude_categories=["C", "Z"]), min_size=1)),
        walls=box(left, bottom, left + length, bottom + width),
        home=place(),
        home_radius=draw(st.floats(5, 50)),
        start=Pose(*place(), draw(st.floats(-1e4, 1e4))),
        foods=tuple(place() for _ in range(draw(st.integers(1, 4)))),
        obstacles=tuple(box(left + 11 * i, bottom, left + 11 * i + t, bottom + t) for i, t in enumerate(thickness)),
    )


@given(arenas())
def test_text_of_a_random_arena_reads_as_the_same(arena: Arena) -> None:
    assert read_text(arena_text(arena)) == arena


def read_text(text: str) -> Arena:
    return parse_plan(text).arena()


def test_text_has_the_keys_of_an_arena_and_short_numbers() -> None:
    arena = read_text(DEN)
    assert arena.foods == (Point(350, 200), Point(350, 300.25))
    for degrees in range(-180, 181, 15):
        text = DEN.replace("90]", f"{degrees}]")
        arena = read_text(text)
        assert arena.start == pytest.approx((100, 250, math.radians(degrees)), rel=1e-15)
        assert arena_text(arena) == text


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "den"', "name = 3", "name is 3; allowed: a text that is not empty"),
        ('name = "den"\n', "", "name is missing"),
        ("home_radius = 80", "home_radius = -8.5", "home_radius is -8.5; allowed: 5 to 10000 mm"),
        ("home_radius = 80", "home_radius = 80\ncolour = 1", "colour is unknown; allowed: foods, home, home_radius"),
        ("walls =", "wals =", "wals is unknown (did you mean walls?); allowed: foods, home, home_radius, name, "),
        ("[700, 0]", "[700.5]", "walls[1] is [700.5]; allowed: [x mm, y mm]"),
        ("[700, 0]", "[700, inf]", "walls[1] is [700, Infinity]; allowed: [x mm, y mm]"),
        ("[[0, 0], [700, 0], [700, 500], [0, 500]]", "[]", "walls is []; allowed: a list that is not empty"),
        ("[100, 250, 90]", "[100, 250]", "start is [100, 250]; allowed: [x mm, y mm, heading degrees]"),
        ("[[200, 0], [240, 0]", "[200, [240, 0]", "obstacles[0][0] is 200; allowed: [x mm, y mm]"),
        ("[100, 250, 90]", "[10, 250, 90]", "den: start at (10, 250) mm is 10 mm from a wall"),
        ("home_radius = 80", "home_radius 80", "not TOML: Expected '=' after a key in a key/value pair (at line 4, "),
    ],
)  # fmt: skip
def test_mistake_is_one_error_with_file_and_key(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert old in DEN
    path = tmp_path / "den.toml"
    path.write_text(DEN.replace(old, new))
    with pytest.raises(ValueError, match=re.escape(f"{path}: {message}")) as caught:
        read_arena(path)
    assert "\n" not in str(caught.value)


def test_file_that_is_no_text_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "den.toml"
    path.write_bytes(b"name = '\xff'")
    with pytest.raises(ValueError, match=r"den\.toml: not UTF-8 text"):
        read_arena(path)
