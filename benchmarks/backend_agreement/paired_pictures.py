"""Pictures of the random arenas, and of what is delivered in each."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from backend_agreement.arenas import HOME_RADIUS, KINDS, RandomArena
from backend_agreement.paired import COMPILED, POLICIES, PYMUNK, PairedRecall
from khepera_forage.estimates import pick
from khepera_forage.figures import (
    COLOURS,
    GREY,
    MARKERS,
    SMALL,
    WIDTH,
    grid,
    legend,
    new_figure,
    padded,
)
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, RADIUS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = 12
"""Arenas in the picture."""
_SCALE = 500.0
"""mm: length of the scale below each arena."""


def arenas_picture(arenas: Sequence[RandomArena]) -> "Figure":
    """The first arenas of the family, each with the start of its first recall."""
    figure = new_figure(WIDTH, 9.6)
    for axes, arena in zip(figure.subplots(4, 3).flat, arenas[:SHOWN], strict=False):
        _draw(axes, arena)
    for axes in figure.axes:
        axes.set_aspect("equal")
        axes.axis("off")
    figure.suptitle("Random arenas with the first start")
    _key(figure)
    return figure


def delivered_picture(rows: Sequence[PairedRecall]) -> "Figure":
    """Share of the food delivered in each arena, compiled against pymunk."""
    figure = new_figure(WIDTH, 3.6)
    for axes, policy in zip(figure.subplots(1, len(POLICIES)), POLICIES, strict=True):
        axes.plot((0, 100), (0, 100), color=GREY, lw=0.8, label="as much on both backends")
        for kind, colour, marker in zip(KINDS, COLOURS, MARKERS, strict=False):
            own = pick(rows, policy=policy, kind=kind.name)
            arenas = [pick(own, arena=number) for number in sorted({row.arena for row in own})]
            points = [
                [_share(pick(group, backend=backend)) for group in arenas] for backend in (PYMUNK, COMPILED)
            ]
            axes.plot(*points, marker, ms=4.5, alpha=0.6, color=colour, mew=0, label=kind.name)
        grid(axes, "both")
        axes.set_aspect("equal")
        axes.set_xlim(*padded(0, 100))
        axes.set_ylim(*padded(0, 100))
        axes.tick_params(labelsize=SMALL)
        axes.set_title(policy, fontsize=10)
        axes.set_xlabel("food delivered, pymunk (%)", fontsize=9)
    figure.axes[0].set_ylabel("food delivered, compiled (%)", fontsize=9)
    legend(figure, figure.axes[0], "one mark an arena", columns=3)
    return figure


def _share(rows: Sequence[PairedRecall]) -> float:
    return 100.0 * sum(row.delivered for row in rows) / max(1, sum(row.not_poisonous for row in rows))


def _draw(axes: "Axes", random: RandomArena) -> None:
    from matplotlib.patches import Circle, Polygon

    arena, layout = random.arena, random.first_layout
    axes.add_patch(Polygon(arena.walls, facecolor="0.95", edgecolor="black"))
    for obstacle in arena.obstacles:
        axes.add_patch(Polygon(obstacle, facecolor="0.5", edgecolor="black"))
    axes.add_patch(Circle(arena.home, HOME_RADIUS, facecolor=COLOURS[4], alpha=0.5))
    for food in layout.foods:
        axes.add_patch(Circle(food, FOOD_RADIUS, facecolor=COLOURS[2]))
    x, y, heading = layout.starts[0]
    axes.add_patch(Circle((x, y), RADIUS, facecolor=COLOURS[0]))
    axes.plot(
        (x, x + FINGER_TIP * math.cos(heading)), (y, y + FINGER_TIP * math.sin(heading)), color=COLOURS[0]
    )
    left, bottom, *_ = arena.bounds
    axes.plot((left, left + _SCALE), (bottom - 40, bottom - 40), color=GREY, lw=2)
    axes.set_title(
        f"{random.kind.name}; {random.foods} food object{'s' * (random.foods > 1)}", fontsize=SMALL
    )
    axes.autoscale_view()


def _key(figure: "Figure") -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=COLOURS[4], alpha=0.5, ms=12, marker="o", ls="", label="home"),
        Line2D([], [], color=COLOURS[2], ms=5, marker="o", ls="", label="food"),
        Line2D([], [], color=COLOURS[0], ms=7, marker="o", label="robot and heading"),
        Line2D([], [], mfc="0.5", mec="black", ms=9, ls="", marker="p", label="obstacle"),
        Line2D([], [], color=GREY, lw=2, label=f"{_SCALE:.0f} mm"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, frameon=False, fontsize=SMALL)
