"""The cost of a step against the number of worlds and of food objects, as numbers and as a picture. Needs numba."""

from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.figures import GREY, OURS, SMALL, THESIS, WIDTH, grid, new_figure
from khepera_forage.sim.arena import Arena, Point, Pose
from timing import compiled
from timing.measures import Job, Line, Measure, Values

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SECTION = "Cost against the number of worlds and of food"
NOTE = (
    "A step of one world under the teacher, all cores; one core steps a few hundred worlds alone. The food lies in a "
    "hall of 2 x 2 m, which has room for 16 objects."
)
WORLDS = tuple(4**n for n in range(9))
FOODS = (1, 2, 4, 8, 12, 16)
VECTOR = {n: Measure(SECTION, f"make_vec, worlds: {n:,}", "ns a step", "Corridor-v1") for n in WORLDS}
KERNEL = {
    n: Measure(SECTION, f"kernel, worlds: {n:,}", "ns a step", "the same without observations and infos")
    for n in WORLDS
}
OBJECTS = {
    k: Measure(SECTION, f"kernel, food objects: {k}", "ns a step", f"{compiled.WORLDS:,} worlds")
    for k in FOODS
}
_HALL = Arena(
    "hall",
    (Point(0, 0), Point(2000, 0), Point(2000, 2000), Point(0, 2000)),
    Point(1000, 1000),
    100,
    Pose(300, 300, 0.0),
    (Point(500, 500),),
)
_LEAST = 5
"""Rounds of a measure; few worlds take more rounds, so that each measure lasts as long."""


def job(steps: int, seed: int) -> Job:
    """All measures.

    Args:
        steps: Of all worlds together, of each measure in a repeat.
        seed: Of all worlds.
    """
    from khepera_forage.envs.compiled.batch import CompiledBatch

    def rounds(worlds: int) -> int:
        return max(_LEAST, min(steps // worlds, 2_000))

    def vector(worlds: int) -> float:
        env: Any = gym.make_vec("khepera_forage/Corridor-v1", num_envs=worlds)
        _, infos = env.reset(seed=seed)
        seconds = []
        for _ in range(_LEAST + rounds(worlds)):
            actions = infos["correct_behaviour"]
            start = perf_counter()
            infos = env.step(actions)[4]
            seconds.append(perf_counter() - start)
        return float(np.median(seconds[_LEAST:])) / worlds * 1e9

    def kernel(batch: CompiledBatch) -> float:
        worlds = batch.num_worlds
        batch.seed(list(range(seed, seed + worlds)), np.arange(worlds))
        batch.restart(np.arange(worlds))
        shown, over = batch.shown, np.zeros(worlds, np.bool_)
        seconds = []
        for _ in range(_LEAST + rounds(worlds)):
            start = perf_counter()
            shown = batch.step(shown["state"], over)
            seconds.append(perf_counter() - start)
            over = shown["terminated"] | shown["truncated"]
        return float(np.median(seconds[_LEAST:])) / worlds * 1e9

    def repeat() -> Values:
        values = {}
        for worlds in WORLDS:
            values[VECTOR[worlds]] = vector(worlds)
            values[KERNEL[worlds]] = kernel(CompiledBatch(worlds))
        for foods in FOODS:
            values[OBJECTS[foods]] = kernel(CompiledBatch(compiled.WORLDS, _HALL, foods, 10_000))
        return values

    return repeat


def picture(lines: Sequence[Line]) -> "Figure":
    """The cost of a step against the number of worlds, and against that of food objects."""
    by_measure = {line.measure: line for line in lines}
    figure = new_figure(WIDTH, 4.4)
    left, right = figure.subplots(1, 2)
    _curve(left, by_measure, VECTOR, "make_vec", OURS, "o")
    _curve(left, by_measure, KERNEL, "kernel", THESIS, "s")
    single = by_measure.get(compiled.SINGLE)
    if single is not None:
        left.plot([1], [1e9 / single.median], "D", color=GREY, label='gym.make, backend="compiled"')
    left.set_xscale("log", base=4)
    left.set_yscale("log")
    left.set_xticks(WORLDS[::2], [f"{n:,}" for n in WORLDS[::2]])
    left.minorticks_off()
    left.set_xlabel("worlds")
    left.set_ylabel("time of a step of one world (ns)")
    _curve(right, by_measure, OBJECTS, f"kernel, {compiled.WORLDS:,} worlds", THESIS, "s")
    least = by_measure[OBJECTS[FOODS[0]]].median
    right.plot(FOODS, [least * k for k in FOODS], "--", color=GREY, lw=1.0, label="proportional")
    right.set_xticks(FOODS)
    right.set_xlabel("food objects")
    right.set_ylim(0, 1.1 * max(max(by_measure[measure].values) for measure in OBJECTS.values()))
    right.set_ylabel("time of a step of one world (ns)")
    for axes in (left, right):
        axes.tick_params(labelsize=SMALL)
        axes.legend(fontsize=SMALL, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
        grid(axes)
    return figure


def _curve(
    axes: "Axes",
    lines: Mapping[Measure, Line],
    measures: Mapping[int, Measure],
    label: str,
    colour: str,
    marker: str,
) -> None:
    """The medians of some measures, and the range of their repeats."""
    own = [lines[measure].values for measure in measures.values()]
    counts = list(measures)
    medians = [lines[measure].median for measure in measures.values()]
    axes.plot(counts, medians, marker=marker, color=colour, ms=4, label=f"{label}: median")
    band = f"{label}: lowest to highest repeat"
    axes.fill_between(
        counts, list(map(min, own)), list(map(max, own)), color=colour, alpha=0.2, lw=0, label=band
    )
