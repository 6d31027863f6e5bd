"""`khepera-forage arena`: list the named arenas, draw an arena and what is wrong with it, and write one to a file."""

import argparse
import math
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from khepera_forage.cli.options import ARENA_FILES, Group, check_file, command, option, out, refuse_ignored
from khepera_forage.envs.arena_settings import environment_name, settings_of
from khepera_forage.envs.arguments import checked_arena, set_up_of
from khepera_forage.envs.rendering import palette
from khepera_forage.extras import require
from khepera_forage.figures import OURS, SMALL, THESIS, legend, new_figure, save
from khepera_forage.geometry import polygon
from khepera_forage.option_values import given_path, whole_number
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.arena_file import ArenaPlan, read_plan, write_arena
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES, checked_difficulty
from khepera_forage.sim.arenas.named import ARENAS, named_arena
from khepera_forage.sim.arenas.procedural import LEVELS, procedural_arena
from khepera_forage.sim.layout_checks import check_apart, check_seen
from khepera_forage.sim.waypoints import check_paths, path_length, shortest_path, too_narrow
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import DEFAULT_DECISIONS

PROCEDURAL = "procedural"
_MARGIN = 30.0
"""mm beside the walls."""
Paths = Sequence[tuple[Point, ...]]

_ALLOWED = f"{', '.join(ARENAS)}, {PROCEDURAL}, or a file *{ARENA_FILES}"
_LEVEL = f"number of a {PROCEDURAL} arena (0); below {LEVELS:,} for training, from there on for the test"
_CHOICE = (
    option("arena", _ALLOWED, metavar="NAME|FILE"),
    option("--difficulty", f"of a {PROCEDURAL} arena (medium)", choices=tuple(DIFFICULTIES)),
    option("--level", _LEVEL, whole_number(0)),
)


class Findings(NamedTuple):
    """Why environments refuse an arena, if they do; paths to food and home; and floor in which a robot cannot turn."""

    refusal: str = ""
    to_food: Paths = ()
    to_home: Paths = ()
    narrow: Paths = ()


@command()
def list_command(arguments: argparse.Namespace) -> None:
    """List the named arenas."""
    print("arena        environment     size in mm    walls  food   limit")
    for name in ARENAS:
        arena, settings = checked_arena(name, DEFAULT_DECISIONS), settings_of(name)
        left, bottom, right, top = arena.bounds
        size = f"{environment_name(name) + '-v1':15} {right - left:4g} x {top - bottom:4g}"
        print(f"{name:12} {size}   {len(arena.segments):6d} {settings['foods']:5d} {settings['limit']:7d}")
    print("\nProcedural-v1   size in mm                walls  food   limit")
    for name, difficulty in DIFFICULTIES.items():
        (short, long), (narrow, wide) = difficulty.length, difficulty.width
        size = f"{short} x {narrow} to {long} x {wide}"
        print(f"{name:15} {size:24} {f'<={difficulty.most_walls}':>6} {difficulty.foods:5d} {difficulty.limit:7d}")


@command(*_CHOICE, out("arena.png", "picture, whose name ends in .png"))
def show_command(arguments: argparse.Namespace) -> int:
    """Draw an arena with its shortest paths."""
    require("khepera-forage arena show", "plots")
    check_file(arguments.out, (".png",))
    plan = _chosen_plan(arguments)
    findings = _find(plan)
    _draw(plan, findings, arguments.out)
    print(f"{arguments.out}: {plan.name}")
    if findings.refusal:
        print(f"khepera-forage arena show: {findings.refusal}", file=sys.stderr)
        return 1
    arena = plan.arena()
    left, bottom, right, top = arena.bounds
    length = max(map(path_length, (*findings.to_food, *findings.to_home)))
    limit = settings_of(arguments.arena if arguments.arena in ARENAS else arena)["limit"]
    if arguments.arena == PROCEDURAL:
        limit = checked_difficulty(arguments.difficulty or "medium").limit
    size = f"{right - left:g} x {top - bottom:g} mm, {len(arena.segments)} walls"
    print(f"{size}, food objects: {len(arena.foods)}, longest way {length:.0f} mm, step limit {limit}")
    return 0


@command(*_CHOICE, option("file", f"name of the new file, which ends in {ARENA_FILES}", given_path, "FILE"))
def write_command(arguments: argparse.Namespace) -> None:
    """Write an arena to a file, to change it."""
    path: Path = arguments.file
    arena = _chosen_plan(arguments).arena()
    if path.suffix != ARENA_FILES:
        raise ValueError(f"file is {str(path)!r}; allowed: a name that ends in {ARENA_FILES}")
    if path.exists():
        raise FileExistsError(f"{path} exists; choose another name, or remove it first")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_arena(arena, path)
    print(f"{path}: {arena.name}; `khepera-forage arena show {path}` draws it")


def _chosen_plan(arguments: argparse.Namespace) -> ArenaPlan:
    """The arena, which in a file may be one that is not allowed."""
    name = arguments.arena
    if name == PROCEDURAL:
        return ArenaPlan.of(procedural_arena(arguments.level or 0, arguments.difficulty or "medium"))
    refuse_ignored(arguments, ["--difficulty", "--level"], f"with the arena {PROCEDURAL}")
    if name in ARENAS:
        return ArenaPlan.of(named_arena(name, set_up_of(DEFAULT_DECISIONS)))
    if name.endswith(ARENA_FILES):
        return read_plan(name)
    raise ValueError(f"arena is {name!r}; allowed: {_ALLOWED}")


def _find(plan: ArenaPlan) -> Findings:
    """What environments find in an arena."""
    found = Findings()
    try:
        arena = plan.arena()
        check_seen((arena,))
        start = Point(arena.start.x, arena.start.y)
        to_food = _paths(arena, [(start, food) for food in arena.foods])
        to_home = _paths(arena, [(food, arena.home) for food in arena.foods])
        found = Findings("", to_food, to_home, too_narrow(arena))
        check_apart(Layout((arena.start,), arena.foods))
        check_paths(arena)
    except ValueError as error:
        return found._replace(refusal=str(error))
    return found


def _paths(arena: Arena, ends: Iterable[tuple[Point, Point]]) -> Paths:
    """The shortest paths between places, as far as there are some."""
    found = []
    for start, goal in ends:
        with suppress(ValueError):
            found.append(shortest_path(arena, start, goal))
    return found


def _draw(plan: ArenaPlan, findings: Findings, picture: Path) -> None:
    """Write a picture of an arena, which may be one that is not allowed."""
    from matplotlib.patches import Circle, Polygon

    corners = tuple(point for each in (plan.walls, *plan.obstacles) for point in each)
    left, bottom, right, top = polygon.bounds((*corners, plan.home, *plan.foods, plan.start[:2]))
    length, width = right - left + 2 * _MARGIN, top - bottom + 2 * _MARGIN
    # In inches; numbers and the legend need the rest.
    scale = min(7.3 / length, 4.6 / width)
    figure = new_figure(max(4.0, 0.7 + scale * length), 1.65 + scale * width)
    axes = figure.subplots()
    axes.set_aspect("equal")
    axes.set_xlim(left - _MARGIN, right + _MARGIN)
    axes.set_ylim(bottom - _MARGIN, top + _MARGIN)
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel("mm", fontsize=SMALL)
    wall, teacher = _colour(palette.WALL), _colour(palette.TEACHER)
    axes.add_patch(Polygon(plan.walls, fc=_colour(palette.FLOOR), ec=wall, lw=2, zorder=0))
    home, edge = _colour(palette.HOME), _colour(palette.HOME_EDGE)
    axes.add_patch(Circle(plan.home, plan.home_radius, fc=home, ec=edge, label="home", zorder=1))
    for obstacle in plan.obstacles:
        axes.add_patch(Polygon(obstacle, fc=wall, ec=wall, zorder=2))
    x, y, heading = plan.start
    axes.add_patch(Circle((x, y), RADIUS, fc=teacher, label="start", zorder=4))
    tip = x + FINGER_TIP * math.cos(heading), y + FINGER_TIP * math.sin(heading)
    axes.plot([x, tip[0]], [y, tip[1]], color=teacher, lw=3, zorder=4)
    for food in plan.foods:
        axes.add_patch(Circle(food, FOOD_RADIUS, fc="white", ec="black", lw=1.2, label="food", zorder=5))
    for path in findings.to_food:
        axes.plot(*zip(*path, strict=True), "-", color=OURS, lw=1.6, zorder=3, label="start to food")
    for path in findings.to_home:
        axes.plot(*zip(*path, strict=True), "--", color=THESIS, lw=1.6, zorder=3, label="food to home")
    red = _colour(palette.LOST)
    for part in findings.narrow:
        axes.fill(*zip(*part, strict=True), color=red, alpha=0.7, lw=0, zorder=2, label="too narrow")
    axes.set_title(f"{plan.name}: not allowed" if findings.refusal else plan.name, fontsize=10)
    legend(figure, axes, columns=3)
    save(figure, picture)


def _colour(colour: palette.Colour) -> str:
    return "#" + bytes(colour).hex()


arena_command = Group("List, draw and write arenas.", (list_command, show_command, write_command))
