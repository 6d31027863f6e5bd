"""Pages with markers and tags at true size, to print and cut out."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from khepera_forage.extras import require
from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.calibration import FLOOR_SIDE
from khepera_forage.vision.shapes import ARRANGEMENTS, MARKER_FRAME

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

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


class Element(NamedTuple):
    """Something on a page: as SVG, and how Pillow draws it with some pixels per mm."""

    svg: str
    draw: Callable[["ImageDraw", float], None]


Page = list[Element]
"""Everything on a page, lowest first. Lengths are in mm from its upper left corner."""


def _rectangle(x: float, y: float, width: float, height: float, black: bool) -> Element:
    """A filled rectangle from its upper left corner."""

    def draw(drawing: "ImageDraw", scale: float) -> None:
        # Pillow fills the last pixel too.
        end = (round((x + width) * scale) - 1, round((y + height) * scale) - 1)
        drawing.rectangle((round(x * scale), round(y * scale), *end), fill=0 if black else 255)

    size = f'width="{width:g}" height="{height:g}"'
    return Element(f'<rect x="{x:g}" y="{y:g}" {size} fill="{"black" if black else "white"}"/>', draw)


def _line(x1: float, y1: float, x2: float, y2: float) -> Element:
    """A thin line."""

    def draw(drawing: "ImageDraw", scale: float) -> None:
        drawing.line([n * scale for n in (x1, y1, x2, y2)], fill=0, width=round(0.3 * scale))

    ends = f'x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}"'
    return Element(f'<line {ends} stroke="black" stroke-width="0.3"/>', draw)


def _text(y: float, text: str, x: float = _MIDDLE, size: float = 3.2) -> Element:
    """A line of text around x on a baseline; the size is the height of its letters."""

    def draw(drawing: "ImageDraw", scale: float) -> None:
        from PIL import ImageFont

        font = ImageFont.load_default(size / 0.72 * scale)
        drawing.text((x * scale, y * scale), text, fill=0, font=font, anchor="ms")

    font = f'font-family="sans-serif" font-size="{size / 0.72:g}" text-anchor="middle"'
    return Element(f'<text x="{x:g}" y="{y:g}" {font}>{text}</text>', draw)


def marker_pages(numbers: Sequence[int] = (1, 2), grid: bool = False) -> list[Page]:
    """Pages with two markers each, of some numbers; `grid` are those of the table of twelve."""
    foot = PAGE_HEIGHT - 36
    pages = []
    for first in range(0, len(numbers), 2):
        page: Page = [_text(10, "Markers for the overhead camera. Print at 100 %, on matt paper, and check:")]
        for place, number in enumerate(numbers[first : first + 2]):
            page += _marker(number, grid, _MIDDLE, _FIRST_MARKER + place * _SPACING)
        page += _ruler(foot, "this line is 100 mm long, and the white of a marker 120 x 80 mm.")
        page += [
            _text(foot + 13, "Cut along the outer edge of the frame. Mount it level over the gripper,"),
            _text(foot + 18, "its middle over the middle of the robot, its arrow towards the gripper."),
        ]
        pages.append(page)
    return pages


def tag_pages(
    robots: Sequence[int], food: Sequence[int], floor: Sequence[int], robot_size: float, food_size: float
) -> list[Page]:
    """Pages with the tags of robots, food and floor, by their ids; sizes are those of a robot's and food's tag in mm.

    Raises:
        ValueError: An id twice, or one that no tag has, or a size that does not fit on a page.
    """
    require("tags", "camera")
    ids = [*robots, *food, *floor]
    for i, tag in enumerate(ids):
        if tag in ids[:i]:
            raise ValueError(f"tag {tag} is given twice; allowed: each id once")
        if not 1 <= tag <= 49:
            raise ValueError(f"tag is {tag}; allowed: ids 1 to 49")
    pages = []
    for kind, group, size in (("robot", robots, robot_size), ("food", food, food_size), ("floor", floor, FLOOR_SIDE)):
        if not 10 <= size <= 170:
            raise ValueError(f"size of a {kind}'s tag is {size:g} mm; allowed: 10 to 170 mm")
        step = size + 2 * max(5.5, size / 10)
        columns, rows = max(1, int(200 // step)), max(1, int(262 // (step + 7)))
        for first in range(0, len(group), columns * rows):
            page: Page = [_text(7, "ArUco tags, 4 x 4. Print at 100 %, on matt paper, and check:")]
            page += _ruler(12, f"this line is 100 mm long, and a black square {size:g} mm wide.")
            for place, tag in enumerate(group[first : first + columns * rows]):
                x = _MIDDLE + (place % columns - (columns - 1) / 2) * step
                y = 22 + (place // columns) * (step + 7) + step / 2
                page += _tag(tag, size, step, x, y)
                front = ", top is front" if kind == "robot" else ""
                page.append(_text(y + step / 2 + 4, f"{kind} {tag}{front}", x))
            pages.append(page)
    return pages


def _ruler(y: float, text: str) -> Iterator[Element]:
    """A line of known length, and what it shows."""
    yield _line(_MIDDLE - _SCALE_LINE / 2, y, _MIDDLE + _SCALE_LINE / 2, y)
    for end in (-1, 1):
        x = _MIDDLE + end * _SCALE_LINE / 2
        yield _line(x, y - 2, x, y + 2)
    yield _text(y + 6, text)


def _tag(tag: int, size: float, outer: float, x: float, y: float) -> Iterator[Element]:
    """A tag centred at (x, y) on the page, and the edges of its white margin, to cut along."""
    from khepera_forage.vision.tags import CELLS, white_cells

    cell, left, top = size / CELLS, x - size / 2, y - size / 2
    yield _rectangle(left, top, size, size, True)
    for row, column in white_cells(tag):
        yield _rectangle(left + column * cell, top + row * cell, cell, cell, False)
    for dx, dy in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
        corner_x, corner_y = x + dx * outer / 2, y + dy * outer / 2
        yield _line(corner_x, corner_y, corner_x - dx * 3, corner_y)
        yield _line(corner_x, corner_y, corner_x, corner_y - dy * 3)


def _marker(number: int, grid: bool, x: float, y: float) -> Iterator[Element]:
    """One marker centred at (x, y) on the page, its front to the right."""
    for grow, black in ((MARKER_FRAME, True), (0.0, False)):
        length, width = MARKER_LENGTH + 2 * grow, MARKER_WIDTH + 2 * grow
        yield _rectangle(x - length / 2, y - width / 2, length, width, black)
    arrangements, side = ARRANGEMENTS["grid" if grid else "holes"]
    for forward, left in arrangements[number]:
        yield _rectangle(x + forward - side / 2, y - left - side / 2, side, side, True)
    front = x + MARKER_LENGTH / 2 + MARKER_FRAME + 3
    yield _line(front, y, front + 12, y)
    for side in (-1, 1):
        yield _line(front + 12, y, front + 8, y + side * 3)
    yield _text(y + 9, "front", front + 7)
    yield _text(y + MARKER_WIDTH / 2 + MARKER_FRAME + 6, f"marker {number}", x, 4.2)


def svg(page: Page) -> str:
    """A page as an SVG document whose lengths are in mm."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{PAGE_WIDTH:g}mm" height="{PAGE_HEIGHT:g}mm" '
        f'viewBox="0 0 {PAGE_WIDTH:g} {PAGE_HEIGHT:g}" shape-rendering="crispEdges">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    return "\n".join([*lines, *(element.svg for element in page), "</svg>", ""])


def save_pages(path: str | os.PathLike[str], pages: Sequence[Page]) -> Path:
    """Write pages as SVG, PNG or PDF, depending on the suffix of the path; several pages only as PDF.

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
    if len(pages) > 1 and suffix != ".pdf":
        raise ValueError(f"{str(path)!r} would have {len(pages)} pages; allowed: a name that ends in .pdf")
    if suffix == ".svg":
        path.write_text(svg(pages[0]), encoding="utf-8")
    elif suffix == ".png":
        _image(pages[0]).save(path, dpi=(DPI, DPI))
    else:
        dpi = DPI if len(pages) == 1 else DPI // 2
        first, *others = (_image(page, dpi) for page in pages)
        first.save(path, resolution=dpi, save_all=True, append_images=others)
    return path


def _image(page: Page, dpi: int = DPI) -> "Image":
    """A page as a grey image."""
    require("a PNG or PDF", "render", otherwise="; SVG works without")
    from PIL import Image, ImageDraw

    scale = dpi / 25.4
    image = Image.new("L", (round(PAGE_WIDTH * scale), round(PAGE_HEIGHT * scale)), 255)
    drawing = ImageDraw.Draw(image)
    for element in page:
        element.draw(drawing, scale)
    return image
