"""Arena files: one `Arena` as TOML, with the keys of `Arena`. Places are in mm, headings in degrees.

```toml
name = "den"
walls = [[0, 0], [700, 0], [700, 500], [0, 500]]
home = [560, 250]
home_radius = 80
start = [100, 250, 90]  # x mm, y mm, and heading in degrees, counter-clockwise from the x axis
foods = [[350, 200], [350, 300]]
obstacles = [[[200, 0], [240, 0], [240, 150], [200, 150]]]  # may be left out
```
"""

import json
from decimal import Decimal, localcontext
from pathlib import Path
from typing import Any, NamedTuple

from khepera_forage.files import replacing
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.toml_table import content_of, list_of, naming, number, numbers, table, text, text_of
from khepera_forage.vision.scene import MM_PER_PIXEL

_DIGITS = 40
_PER_DEGREE = Decimal("0.01745329251994329576923690768488612713442871889")
"""Radians. With more digits than a float has, every float is the value of some decimal number of degrees."""


class ArenaPlan(NamedTuple):
    """What an arena file says. Whether it makes an arena is not checked yet.

    The attributes are those of `Arena`.
    """

    name: str
    walls: tuple[Point, ...]
    home: Point
    home_radius: float
    start: Pose
    foods: tuple[Point, ...]
    obstacles: tuple[tuple[Point, ...], ...] = ()

    @classmethod
    def of(cls, arena: Arena) -> "ArenaPlan":
        """What the file of an arena says."""
        return cls(*(getattr(arena, name) for name in cls._fields))

    def arena(self) -> Arena:
        """The arena.

        Raises:
            ValueError: It is not allowed, see `Arena`.
        """
        return Arena(*self)


def read_arena(path: Path | str) -> Arena:
    """The arena in a file.

    Raises:
        ValueError: The file is not TOML, a key is missing, unknown or has a value that is not allowed, or the arena is
            not allowed. The message names the file, and the line or the key.
        OSError: The file cannot be read.
    """
    with naming(path):
        return parse_plan(text_of(Path(path))).arena()


def read_plan(path: Path | str) -> ArenaPlan:
    """What a file says about an arena, which may be one that is not allowed; errors as of `read_arena`."""
    with naming(path):
        return parse_plan(text_of(Path(path)))


def parse_plan(toml: str) -> ArenaPlan:
    """What a text says about an arena; errors do not name a file."""
    return plan_of("", content_of(toml, Decimal))


def plan_of(key: str, value: Any) -> ArenaPlan:
    """What a table says about an arena.

    Raises:
        ValueError: A key is missing, unknown, or has a value that is not allowed.
    """
    return ArenaPlan(**table(key, value, _KEYS, ArenaPlan._fields[:-1]))


def write_arena(arena: Arena, path: Path | str) -> None:
    """Write an arena file, which `read_arena` reads as an equal arena. A file that exists is replaced as a whole.

    Raises:
        OSError: The file cannot be written.
    """
    with replacing(Path(path)) as partial:
        partial.write_text(arena_text(arena), encoding="utf-8")


def arena_text(arena: Arena) -> str:
    """The text of an arena file."""
    x, y, heading = arena.start
    lines = [
        *(f"{key} = {toml(getattr(arena, key))}" for key in ("name", "walls", "home", "home_radius")),
        f"start = [{toml(x)}, {toml(y)}, {_degrees(heading)}]  # x mm, y mm, heading degrees",
        f"foods = {toml(arena.foods)}",
    ]
    if arena.obstacles:
        lines += ["obstacles = [", *(f"    {toml(obstacle)}," for obstacle in arena.obstacles), "]"]
    return "\n".join(lines) + "\n"


def toml(value: Any) -> str:
    """A text, a number, or a tuple of such, as TOML."""
    if isinstance(value, str):
        # TOML's strings are those of JSON, but for the control character DEL.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, tuple):
        return f"[{', '.join(map(toml, value))}]"
    return repr(float(value)).removesuffix(".0")


def _point(key: str, value: Any) -> Point:
    return Point(*numbers("[x mm, y mm]")(key, value))


def _pose(key: str, value: Any) -> Pose:
    x, y, _ = numbers("[x mm, y mm, heading degrees]")(key, value)
    return Pose(x, y, _radians(Decimal(value[2])))


def _radians(degrees: Decimal) -> float:
    with localcontext(prec=_DIGITS):
        return float(degrees * _PER_DEGREE)


def _degrees(radians: float) -> str:
    """The shortest number of degrees that is read as exactly this angle."""
    with localcontext(prec=_DIGITS):
        exact = Decimal(float(radians)) / _PER_DEGREE
    for digits in range(1, _DIGITS):
        with localcontext(prec=digits):
            rounded = +exact
        if _radians(rounded) == radians:
            break
    return f"{rounded:f}"


_KEYS = {
    "name": text,
    "walls": list_of(_point),
    "home": _point,
    "home_radius": number(MM_PER_PIXEL, 10000.0, "mm"),
    "start": _pose,
    "foods": list_of(_point),
    "obstacles": list_of(list_of(_point), least=0),
}
