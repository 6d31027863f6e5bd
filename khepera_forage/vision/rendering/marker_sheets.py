"""A page with both markers at true size, to print, cut out and put on real robots."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from khepera_forage.extras import require
from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.shapes import HOLE_SIDE, MARKER_FRAME, MARKER_HOLES

if TYPE_CHECKING:
    from PIL.Image import Image

PAGE_WIDTH, PAGE_HEIGHT = 210.0, 297.0
"""A4, upright, in mm."""
DPI = 600
"""Resolution of PNG and PDF: a pixel is 0.04 mm."""
FORMATS = (".svg", ".png", ".pdf")
_MIDDLE = PAGE_WIDTH / 2
_FIRST_MARKER, _SPACING = 68.0, 118.0
"""Distance in mm of the first marker's middle from the top of the page, and of the next marker's middle from it."""
_SCALE_LINE = 100.0
"""Length in mm of the line that shows whether the page was printed at true size."""


class Rectangle(NamedTuple):
    """A filled rectangle: upper left corner and size in mm from the page's upper left corner, black or white."""

    x: float
    y: float
    width: float
    height: float
    black: bool


class Line(NamedTuple):
    """A thin line in mm."""

    x1: float
    y1: float
    x2: float
    y2: float


class TextLine(NamedTuple):
    """A line of text: middle of its baseline in mm, and the height of its letters in mm."""

    x: float
    y: float
    size: float
    text: str


Element = Rectangle | Line | TextLine


def elements() -> Iterator[Element]:
    """Everything on the page, lowest first."""
    yield TextLine(
        _MIDDLE, 10, 3.2, "Markers for the overhead camera. Print at 100 %, on matt paper, and check:"
    )
    for number, holes in enumerate(sorted(MARKER_HOLES)):
        yield from _marker(holes, _MIDDLE, _FIRST_MARKER + number * _SPACING)
    foot = PAGE_HEIGHT - 36
    yield Line(_MIDDLE - _SCALE_LINE / 2, foot, _MIDDLE + _SCALE_LINE / 2, foot)
    for end in (-1, 1):
        x = _MIDDLE + end * _SCALE_LINE / 2
        yield Line(x, foot - 2, x, foot + 2)
    yield TextLine(_MIDDLE, foot + 6, 3.2, "this line is 100 mm long, and the white of a marker 120 x 80 mm.")
    yield TextLine(
        _MIDDLE,
        foot + 13,
        3.2,
        "Cut along the outer edge of the frame. Mount it level over the gripper,",
    )
    yield TextLine(
        _MIDDLE, foot + 18, 3.2, "its middle over the middle of the robot, its arrow towards the gripper."
    )


def _marker(holes: int, x: float, y: float) -> Iterator[Element]:
    """One marker centred at (x, y) on the page, its front to the right."""
    for grow, black in ((MARKER_FRAME, True), (0.0, False)):
        length, width = MARKER_LENGTH + 2 * grow, MARKER_WIDTH + 2 * grow
        yield Rectangle(x - length / 2, y - width / 2, length, width, black)
    for forward, left in MARKER_HOLES[holes]:
        yield Rectangle(x + forward - HOLE_SIDE / 2, y - left - HOLE_SIDE / 2, HOLE_SIDE, HOLE_SIDE, True)
    front = x + MARKER_LENGTH / 2 + MARKER_FRAME + 3
    yield Line(front, y, front + 12, y)
    for side in (-1, 1):
        yield Line(front + 12, y, front + 8, y + side * 3)
    yield TextLine(front + 7, y + 9, 3.2, "front")
    name = "1 hole" if holes == 1 else f"{holes} holes"
    yield TextLine(x, y + MARKER_WIDTH / 2 + MARKER_FRAME + 6, 4.2, name)


def svg() -> str:
    """The page as an SVG document whose lengths are in mm."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{PAGE_WIDTH:g}mm" height="{PAGE_HEIGHT:g}mm" '
        f'viewBox="0 0 {PAGE_WIDTH:g} {PAGE_HEIGHT:g}" shape-rendering="crispEdges">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for element in elements():
        if isinstance(element, Rectangle):
            x, y, width, height, black = element
            fill = "black" if black else "white"
            lines.append(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" fill="{fill}"/>')
        elif isinstance(element, Line):
            x1, y1, x2, y2 = element
            lines.append(
                f'<line x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}" stroke="black" stroke-width="0.3"/>'
            )
        else:
            lines.append(
                f'<text x="{element.x:g}" y="{element.y:g}" font-family="sans-serif" '
                f'font-size="{element.size / 0.72:g}" text-anchor="middle">{element.text}</text>'
            )
    return "\n".join([*lines, "</svg>", ""])


def save_marker_sheet(path: str | os.PathLike[str]) -> Path:
    """Write the page as SVG, PNG or PDF, depending on the suffix of the path.

    Returns:
        The path.

    Raises:
        ValueError: Another suffix.
        ImportError: PNG and PDF need Pillow, which is not installed.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"page of markers {str(path)!r}; allowed: a name that ends in {', '.join(FORMATS)}")
    if suffix == ".svg":
        path.write_text(svg(), encoding="utf-8")
    elif suffix == ".png":
        _image().save(path, dpi=(DPI, DPI))
    else:
        _image().save(path, resolution=DPI)
    return path


def _image() -> "Image":
    """The page as a grey image."""
    require("a PNG or PDF", "render", otherwise="; SVG works without")
    from PIL import Image, ImageDraw, ImageFont

    scale = DPI / 25.4
    image = Image.new("L", (round(PAGE_WIDTH * scale), round(PAGE_HEIGHT * scale)), 255)
    drawing = ImageDraw.Draw(image)
    for element in elements():
        if isinstance(element, Rectangle):
            x, y, width, height, black = element
            # Pillow fills the last pixel too.
            end = (round((x + width) * scale) - 1, round((y + height) * scale) - 1)
            drawing.rectangle((round(x * scale), round(y * scale), *end), fill=0 if black else 255)
        elif isinstance(element, Line):
            drawing.line([v * scale for v in element], fill=0, width=round(0.3 * scale))
        else:
            font = ImageFont.load_default(element.size / 0.72 * scale)
            drawing.text((element.x * scale, element.y * scale), element.text, fill=0, font=font, anchor="ms")
    return image
