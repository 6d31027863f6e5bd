"""Pages with markers and tags at true size, to print and cut out, drawn with matplotlib (extra `plots`)."""

import os
from collections.abc import Sequence
from pathlib import Path

from khepera_forage.extras import require
from khepera_forage.files import replacing
from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.calibration import FLOOR_SIDE
from khepera_forage.vision.shapes import ARRANGEMENTS, MARKER_FRAME

PAGE_WIDTH, PAGE_HEIGHT = 210.0, 297.0
"""A4, upright, in mm."""
DPI = 600
"""Resolution of PNG: a pixel is 0.04 mm."""
FORMATS = (".svg", ".png", ".pdf")
_INCH, _POINT = 25.4, 25.4 / 72  # mm
_MIDDLE = PAGE_WIDTH / 2
_FIRST_MARKER, _SPACING = 68.0, 118.0
"""Distance in mm of the first marker's middle from the top of the page, and of the next marker's middle from it."""
_SCALE_LINE = 100.0
"""Length in mm of the line that shows whether the page was printed at true size."""


class Page:
    """A page on which lengths are in mm from its upper left corner; what is drawn later is above.

    Attributes:
        figure: What is drawn.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """

    def __init__(self) -> None:
        require("a page to print", "plots")
        from matplotlib.figure import Figure

        self.figure = Figure(figsize=(PAGE_WIDTH / _INCH, PAGE_HEIGHT / _INCH), dpi=DPI)
        self._axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0, PAGE_WIDTH), ylim=(PAGE_HEIGHT, 0))
        self._axes.set_axis_off()

    def rectangle(self, x: float, y: float, width: float, height: float, black: bool = True) -> None:
        """A filled rectangle from its upper left corner."""
        from matplotlib.patches import Rectangle

        colour = "black" if black else "white"
        self._axes.add_patch(Rectangle((x, y), width, height, color=colour, linewidth=0, antialiased=False, zorder=2))

    def line(self, x1: float, y1: float, x2: float, y2: float) -> None:
        """A thin line."""
        self._axes.plot((x1, x2), (y1, y2), color="black", linewidth=0.3 / _POINT)

    def text(self, y: float, text: str, x: float = _MIDDLE, size: float = 3.2) -> None:
        """A line of text around x on a baseline; the size is the height of its letters."""
        self._axes.text(x, y, text, fontsize=size / 0.72 / _POINT, ha="center", va="baseline")

    def ruler(self, y: float, text: str) -> None:
        """A line of known length, and what it shows."""
        self.line(_MIDDLE - _SCALE_LINE / 2, y, _MIDDLE + _SCALE_LINE / 2, y)
        for x in (_MIDDLE - _SCALE_LINE / 2, _MIDDLE + _SCALE_LINE / 2):
            self.line(x, y - 2, x, y + 2)
        self.text(y + 6.5, text)


def marker_pages(numbers: Sequence[int] = (1, 2), grid: bool = False) -> list[Page]:
    """Pages with two markers each, of some numbers; `grid` are those of the table of twelve."""
    foot = PAGE_HEIGHT - 36
    pages = []
    for first in range(0, len(numbers), 2):
        page = Page()
        page.text(10, "Markers for the overhead camera. Print at 100 %, on matt paper, and check:")
        for place, number in enumerate(numbers[first : first + 2]):
            _draw_marker(page, number, grid, _MIDDLE, _FIRST_MARKER + place * _SPACING)
        page.ruler(foot, "this line is 100 mm long, and the white of a marker 120 x 80 mm.")
        page.text(foot + 13, "Cut along the outer edge of the frame. Mount it level over the gripper,")
        page.text(foot + 18, "its middle over the middle of the robot, its arrow towards the gripper.")
        pages.append(page)
    return pages


def tag_pages(
    robots: Sequence[int], food: Sequence[int], floor: Sequence[int], robot_size: float, food_size: float
) -> list[Page]:
    """Pages with the tags of robots, food and floor, by their ids; sizes are those of a robot's and food's tag in mm.

    Raises:
        ValueError: An id twice, or one that no tag has, or a size that does not fit on a page.
    """
    require("tags", "camera", "plots")
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
            page = Page()
            page.text(7, "ArUco tags, 4 x 4. Print at 100 %, on matt paper, and check:")
            page.ruler(12, f"this line is 100 mm long, and a black square {size:g} mm wide.")
            for place, tag in enumerate(group[first : first + columns * rows]):
                x = _MIDDLE + (place % columns - (columns - 1) / 2) * step
                y = 22 + (place // columns) * (step + 7) + step / 2
                _draw_tag(page, tag, size, step, x, y)
                page.text(y + step / 2 + 4, f"{kind} {tag}{', top is front' if kind == 'robot' else ''}", x)
            pages.append(page)
    return pages


def _draw_tag(page: Page, tag: int, size: float, outer: float, x: float, y: float) -> None:
    """A tag centred at (x, y) on the page, and the edges of its white margin, to cut along."""
    from khepera_forage.vision.tags import CELLS, white_cells

    cell, left, top = size / CELLS, x - size / 2, y - size / 2
    page.rectangle(left, top, size, size)
    for row, column in white_cells(tag):
        page.rectangle(left + column * cell, top + row * cell, cell, cell, black=False)
    for dx, dy in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
        corner_x, corner_y = x + dx * outer / 2, y + dy * outer / 2
        page.line(corner_x, corner_y, corner_x - dx * 3, corner_y)
        page.line(corner_x, corner_y, corner_x, corner_y - dy * 3)


def _draw_marker(page: Page, number: int, grid: bool, x: float, y: float) -> None:
    """One marker centred at (x, y) on the page, its front to the right."""
    for grow, black in ((MARKER_FRAME, True), (0.0, False)):
        length, width = MARKER_LENGTH + 2 * grow, MARKER_WIDTH + 2 * grow
        page.rectangle(x - length / 2, y - width / 2, length, width, black)
    arrangements, side = ARRANGEMENTS["grid" if grid else "holes"]
    for forward, left in arrangements[number]:
        page.rectangle(x + forward - side / 2, y - left - side / 2, side, side)
    front = x + MARKER_LENGTH / 2 + MARKER_FRAME + 3
    page.line(front, y, front + 12, y)
    for end in (-1, 1):
        page.line(front + 12, y, front + 8, y + end * 3)
    page.text(y + 9, "front", front + 7)
    page.text(y + MARKER_WIDTH / 2 + MARKER_FRAME + 6, f"marker {number}", x, 4.2)


def save_pages(path: str | os.PathLike[str], pages: Sequence[Page]) -> Path:
    """Write pages as SVG, PNG or PDF, depending on the suffix of the path; several pages only as PDF.

    Returns:
        The path.

    Raises:
        ValueError: Another suffix.
    """
    from matplotlib.backends.backend_pdf import PdfPages

    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"page of markers {str(path)!r}; allowed: a name that ends in {', '.join(FORMATS)}")
    if len(pages) > 1 and suffix != ".pdf":
        raise ValueError(f"{str(path)!r} would have {len(pages)} pages; allowed: a name that ends in .pdf")
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as partial:
        if suffix == ".pdf":
            with PdfPages(partial) as file:
                for page in pages:
                    page.figure.savefig(file, format="pdf")
        else:
            pages[0].figure.savefig(partial, format=suffix[1:])
    return path
