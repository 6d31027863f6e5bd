"""Pictures of arenas: walls, home, start, food, shortest paths, and what is too narrow."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from khepera_forage.cli.arena import Findings, Paths
from khepera_forage.envs.rendering import palette
from khepera_forage.figures import OURS, SMALL, THESIS, new_figure, save
from khepera_forage.geometry import polygon
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Point
from khepera_forage.sim.arena_file import ArenaPlan

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WIDTH, _HEIGHT = 8.0, 6.0
"""Largest size of a picture in inches."""
_LEAST_WIDTH = 4.0
_EDGES = 0.7
"""Inches beside the arena, for numbers and the legend."""
_LINE = 0.25
"""Inches of the legend's second line, which narrow pictures have."""
_MARGIN = 30.0
"""mm beside the walls."""


def draw(plan: ArenaPlan, findings: Findings, path: Path) -> None:
    """Write a picture of an arena.

    Args:
        plan: The arena, which may be one that is not allowed.
        findings: Paths and narrow places to be drawn.
        path: Of the picture.
    """
    corners = tuple(point for each in (plan.walls, *plan.obstacles) for point in each)
    left, bottom, right, top = polygon.bounds((*corners, plan.home, *plan.foods, plan.start[:2]))
    length, width = right - left + 2 * _MARGIN, top - bottom + 2 * _MARGIN
    scale = min((_WIDTH - _EDGES) / length, (_HEIGHT - 2 * _EDGES) / width)
    shown_width = max(_LEAST_WIDTH, length * scale + _EDGES)
    columns = 6 if shown_width > 6 else 3
    figure = new_figure(shown_width, width * scale + 2 * _EDGES + (_LINE if columns == 3 else 0.0))
    axes = figure.subplots()
    axes.set_aspect("equal")
    axes.set_xlim(left - _MARGIN, right + _MARGIN)
    axes.set_ylim(bottom - _MARGIN, top + _MARGIN)
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel("mm", fontsize=SMALL)
    _draw_floor(axes, plan)
    _draw_places(axes, plan)
    _draw_paths(axes, findings.to_food, "start to food", OURS, "-")
    _draw_paths(axes, findings.to_home, "food to home", THESIS, "--")
    for k, part in enumerate(findings.narrow):
        label = "too narrow" if k == 0 else None
        axes.fill(*_columns(part), color=_colour(palette.LOST), alpha=0.7, lw=0, zorder=2, label=label)
    axes.set_title(f"{plan.name}: not allowed" if findings.refusal else plan.name, fontsize=10)
    figure.legend(loc="outside lower center", ncols=columns, frameon=False, fontsize=SMALL)
    save(figure, path)


def _draw_paths(axes: "Axes", paths: Paths, label: str, colour: str, style: str) -> None:
    for k, path in enumerate(paths):
        axes.plot(*_columns(path), style, color=colour, lw=1.6, zorder=3, label=label if k == 0 else None)


def _columns(places: Sequence[Point]) -> tuple[list[float], list[float]]:
    return [x for x, _ in places], [y for _, y in places]


def _draw_floor(axes: "Axes", plan: ArenaPlan) -> None:
    from matplotlib.patches import Circle, Polygon

    wall = _colour(palette.WALL)
    axes.add_patch(Polygon(plan.walls, facecolor=_colour(palette.FLOOR), edgecolor=wall, lw=2, zorder=0))
    axes.add_patch(
        Circle(
            plan.home,
            plan.home_radius,
            facecolor=_colour(palette.HOME),
            edgecolor=_colour(palette.HOME_EDGE),
            label="home",
            zorder=1,
        )
    )
    for corners in plan.obstacles:
        axes.add_patch(Polygon(corners, facecolor=wall, edgecolor=wall, zorder=2))


def _draw_places(axes: "Axes", plan: ArenaPlan) -> None:
    from matplotlib.patches import Circle

    x, y, heading = plan.start
    teacher = _colour(palette.TEACHER)
    axes.add_patch(Circle((x, y), RADIUS, facecolor=teacher, label="start", zorder=4))
    tip = x + FINGER_TIP * math.cos(heading), y + FINGER_TIP * math.sin(heading)
    axes.plot([x, tip[0]], [y, tip[1]], color=teacher, lw=3, zorder=4)
    for k, food in enumerate(plan.foods):
        axes.add_patch(
            Circle(
                food,
                FOOD_RADIUS,
                facecolor="white",
                edgecolor="black",
                lw=1.2,
                label="food" if k == 0 else None,
                zorder=5,
            )
        )


def _colour(colour: palette.Colour) -> tuple[float, float, float]:
    r, g, b = colour
    return r / 255, g / 255, b / 255
